"""What a run of trials or of clips prints: its table, the verdicts, where everything is."""

from __future__ import annotations

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_verdicts
from experiments.bench.result import Run, whole_networks
from experiments.bench.run.rows import PEAKS
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.judge import flaws
from experiments.bench.sources.trial_rows import varying

MEANS = ("spikes", "firing_rate_hz", "peak_hs", "peak_looming")
"""Means over trials that the table of a run has, as far as its models have them."""


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
        peaks = shown.filter(pl.col("quantity").is_in(MEANS)).pivot("quantity", index=keys, values="mean")
        spikes = shown.filter(quantity="spikes").select(*keys, "ci_low", "ci_high")
        trials = shown.group_by(keys).agg(pl.col("n").max())
        joined = peaks.join(trials, on=keys, nulls_equal=True, maintain_order="left")
        joined = joined.join(spikes, on=keys, how="left", nulls_equal=True, maintain_order="left")
        means = [name for name in MEANS if name in peaks.columns]
        terminal.show(joined.select(*varies, "n", *means[:1], "ci_low", "ci_high", *means[1:]))
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
