"""What a run of trials, of clips or of footage prints: its tables, the verdicts, where everything is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import polars as pl
from rich.text import Text

from experiments.base import console as terminal
from experiments.base.console import count, out_console, show_files
from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.judge.count import Kind
from experiments.judge.judge import flaws
from experiments.judge.motion import GRADES
from experiments.judge.verdict import Verdict
from experiments.kinds.result import Run, whole_networks
from experiments.show.trial_rows import varying
from experiments.store.tables import COUNTS, PEAKS, RESPONSES

SHOWN = {"spikes": ("mean", "ci_low", "ci_high"), "firing_rate_hz": ("mean",), "peak_hs": ("mean",),
         "trough_hs": ("mean",), "peak_looming": ("mean",)}  # fmt: skip
"""Quantities that the table of a run has, as far as its models have them -> their columns of the summary; a mean has
the name of its quantity."""


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
    terminal.show(run.summary, "motion over T" if run.summary.height else "motion over T: none")
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


VERDICT_COLOURS: Mapping[Kind, str] = {
    "holds": "green",
    "fails": "red",
    "sometimes": "yellow",
    "counted": "cyan",
    "unjudged": "yellow",
}


def show_verdicts(verdicts: Sequence[Verdict], *, model: bool = False, provenance: str = "") -> None:
    """Print each verdict as one sentence: the claim, in how many replicates it held, and the number that decided.

    What else was measured stands in ``claims.json``.

    Parameters
    ----------
    verdicts
        The verdicts.
    model
        Whether to name the model that each is about.
    provenance
        Where the trials come from; empty where they are simulated.
    """
    skipped = {verdict.id: verdict.outcome.least for verdict in verdicts if verdict.outcome.least}
    for verdict in (verdict for verdict in verdicts if not verdict.outcome.least):
        counted = verdict.count
        who = f" ({verdict.model})" if model and verdict.model else ""
        origin = f" [{provenance}]" if provenance else ""
        sentence = f"{verdict.title or verdict.says}; {verdict.outcome.deciding}"
        if verdict.equal is not None and verdict.outcome.equal is not None:
            sentence += f"; on equal terms {verdict.equal.sentence()}: {verdict.outcome.equal.deciding}"
        label = Text(counted.sentence(), VERDICT_COLOURS[counted.kind])
        out_console.print(Text.assemble((verdict.id, "b"), f"{who} ", label, f"{origin}: {sentence}"))
    for least in sorted(set(skipped.values())):
        names, option = ", ".join(name for name in skipped if skipped[name] == least), f" (--repeats {least})"
        out_console.print(f"skipped, for want of {least} trials of each condition{option * (not provenance)}: {names}")
