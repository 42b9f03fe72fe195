"""What a run of trials, of clips or of footage prints: its tables, the verdicts, where everything is."""

from __future__ import annotations

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_verdicts
from experiments.bench.result import Run, whole_networks
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.rows import COUNTS, PEAKS, RESPONSES
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.judge import flaws
from experiments.bench.sources.motion import GRADES, near_miss
from experiments.bench.sources.trial_rows import varying

SHOWN = {"spikes": ("mean", "ci_low", "ci_high"), "firing_rate_hz": ("mean",), "peak_hs": ("mean",),
         "trough_hs": ("mean",), "peak_looming": ("mean",)}  # fmt: skip
"""Quantities that the table of a run has, as far as its models have them -> their columns of the summary; a mean has
the name of its quantity."""
TRY = (
    "Try nearer motion, more contrast, another --size or a lower T (--set dsnn.t_sp=0.08), above a still scene's |HS|."
)


def show(run: Run) -> None:
    """Print what a run comes to: its table, the verdicts, tests between models, and where everything is."""
    clips = run.kind == "clips"
    rows = run.trials.to_dicts() if clips else whole_networks(run)
    models = {row["model"] for row in rows}
    varies = [] if clips else varying(rows, run.description["experiment"]["varies"])
    if rows and clips:
        terminal.show(run.trials.filter(repeat=0).select("clip", "model", *PEAKS, "spikes"), "first seed")
    elif rows:
        keys, shown = ["model", *CONDITION_COLUMNS], run.summary.filter(pl.col("model").is_in([*models]))
        known = [name for name in SHOWN if name in shown["quantity"]]
        values = [pl.col(column).filter(quantity=name).first().alias(name if column == "mean" else column)
                  for name in known for column in SHOWN[name]]  # fmt: skip
        table = shown.group_by(keys, maintain_order=True).agg(pl.col("n").max(), *values)
        terminal.show(table.select(*varies, "n", *table.columns[len(keys) + 1 :]))
    out_console.print()
    named = not clips and len(models | {verdict.model for verdict in run.verdicts if verdict.model}) > 1
    show_verdicts(run.verdicts, model=named, provenance=run.provenance if run.kind == "measured" else "")
    for model in sorted(models):
        seen = [row for row in rows if row["model"] == model]
        if (own := model.removesuffix("@frames")) in models - {model}:
            robot, shown = (run.frames.filter(model=name) for name in (own, model))
            logged = [name for name in RESPONSES if not robot[name].has_nulls()]
            equal = robot.join(shown, on=["trial", "frame", *logged]).height
            out_console.print(f"{own}, {model}: {equal} of {robot.height} frames have equal responses")
        if not any(row[end] for row in seen for end in PEAKS):
            greys = [row[end] for row in seen for end in ("darkest", "brightest") if row.get(end) is not None]
            range_of = f"; its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            out_console.print(f"{model} is silent: all its potentials are 0{range_of}")
    if rows and not clips and run.comparisons.height:
        names = [name for name in varies if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        title = f"\nmodels in the same trials ({run.comparisons['test'][0]}; p after Holm)"
        terminal.show(run.comparisons.select(columns), title)
    if rows and not clips and (beware := flaws(run.trials.to_dicts())):
        out_console.print(f"\nbeware: {beware}", style="red")
    show_files(run.folder, count(len({row["trial"] for row in rows}), "clip" if clips else "trial"))


def show_motion(run: Run) -> None:
    """Print what footage comes to: the intervals of motion, each model, the verdicts, and where everything is."""
    if not run.done:
        return
    if run.summary.height:
        terminal.show(run.summary, "motion over T")
    for model in sorted({*run.trials["model"]} - {*run.summary["model"]}):
        if near := near_miss(run.frames.filter(model=model), run.description[THRESHOLDS][model]):
            out_console.print(f"{model}: {near}\n  {TRY}")
    terminal.show(
        run.trials.head(1).select("source", "width", "height", "fps", "frames", "seconds"), "as models saw it"
    )
    terminal.show(_filled(run.trials.select("model", *COUNTS, *PEAKS)), "each model")
    if run.description["judged"]:
        terminal.show(_filled(run.trials.select("model", *GRADES)), "HS and optical flow, with 95 % intervals")
    show_verdicts(run.verdicts, model=len(run.models) > 1)
    show_files(run.folder, count(run.trials["frames"][0], "frame"))


def _filled(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table without the columns that have only nulls."""
    return table.select(column for column in table if column.null_count() < table.height)
