"""What a run of trials or of clips prints: its table, the verdicts, where everything is."""

from __future__ import annotations

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_verdicts
from experiments.bench.result import Run, whole_networks
from experiments.bench.run.rows import PEAKS
from experiments.bench.sources.judge import flaws
from experiments.bench.sources.trial_rows import varying


def show(run: Run) -> None:
    """Print what a run comes to: its table, the verdicts, tests between models, and where everything is."""
    clips = run.kind == "clips"
    rows = run.trials.to_dicts() if clips else whole_networks(run)
    models = {row["model"] for row in rows}
    varies = [] if clips else varying(rows, run.description["experiment"]["varies"])
    if rows and clips:
        terminal.show(run.trials.filter(repeat=0).select("clip", "model", *PEAKS, "spikes"), "first seed")
    elif rows:
        spikes = run.summary.filter(pl.col("quantity") == "spikes", pl.col("model").is_in([*models]))
        if spikes.height:
            terminal.show(spikes.select(*varies, "n", pl.col("mean").alias("spikes"), "ci_low", "ci_high"))
    out_console.print()
    named = not clips and len(models | {verdict.model for verdict in run.verdicts if verdict.model}) > 1
    show_verdicts(run.verdicts, model=named, provenance=run.provenance if run.kind == "measured" else "")
    for model in sorted(models):
        seen = [row for row in rows if row["model"] == model]
        if not any(row[end] for row in seen for end in PEAKS):
            greys = [row[end] for row in seen for end in ("darkest", "brightest") if row.get(end) is not None]
            range_of = f"; its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            out_console.print(f"{model} is silent: all its potentials are 0{range_of}")
    if rows and not clips and run.comparisons.height:
        names = [name for name in varies if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        title = f"\nmodels on the same frames ({run.comparisons['test'][0]}; p after Holm)"
        terminal.show(run.comparisons.select(columns), title)
    if rows and not clips and (beware := flaws(run.trials.to_dicts())):
        out_console.print(f"\nbeware: {beware}", style="red")
    show_files(run.folder, count(len({row["trial"] for row in rows}), "clip" if clips else "trial"))
