"""What a run of trials or of clips prints: its table, the verdicts, where everything is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_verdicts
from experiments.bench.result import Run, whole_networks
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.models import counted_channel
from experiments.bench.run.rows import PEAKS, RECORDING
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.judge import flaws
from experiments.bench.sources.trial_rows import drawable, varying

SPIKES = ("spikes", "firing_rate_hz")
MECHANISM = ("spikes", "seconds_in_view", "rate_in_view_hz", "mean_hs_near_axis")
DRIVEN = ("achieved_speed_cm_s", "drift_mm", "path_error_mm")
"""Means that the table of conditions has; of figures about mechanism; of an open loop."""


def show(run: Run) -> None:
    """Print what a run comes to: its table, the verdicts, tests between models, and where everything is."""
    clips = run.kind == "clips"
    rows = run.trials.to_dicts() if clips else whole_networks(run)
    if rows and clips:
        terminal.show(run.trials.filter(repeat=0).select("clip", "model", *PEAKS, "spikes"), "first seed")
    elif rows:
        terminal.show(conditions(run, rows))
    models = {row["model"] for row in rows}
    for model in sorted({*run.failures["model"]} - models - {"", RECORDING}):
        out_console.print(f"{model} failed in every trial", style="red")
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
        names = [name for name in varying(rows, run.description["experiment"]["varies"]) if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        title = f"\nmodels on the same frames ({run.comparisons['test'][0]}; p after Holm)"
        terminal.show(run.comparisons.select(columns), title)
    if rows and not clips and (beware := flaws(run.trials.to_dicts())):
        out_console.print(f"\nbeware: {beware}", style="red")
    show_files(run.folder, count(len({row["trial"] for row in rows}), "clip" if clips else "trial"))


def conditions(run: Run, rows: Sequence[Mapping[str, Any]]) -> pl.DataFrame:
    """Return the table of conditions: what varies, n, means over trials, and the 95 % interval of the spikes' mean."""
    declared, keys = run.description["experiment"], ["model", *CONDITION_COLUMNS]
    ends = {f"{end}_{counted_channel(levels)}" for levels in run.description[THRESHOLDS].values()
            for end in ("peak", "trough")}  # fmt: skip
    wanted = [*(MECHANISM if drawable(declared["figure"], rows) == "mechanism" else SPIKES),
              *(name for name in PEAKS if name in ends),
              *(DRIVEN if run.description["settings"]["robot"]["open_loop"] else ())]  # fmt: skip
    table = pl.DataFrame(rows, infer_schema_length=None)
    means = table.group_by(keys, maintain_order=True).agg(pl.len().alias("n"), pl.col(wanted).cast(float).mean())
    intervals = run.summary.filter(quantity="spikes").select(*keys, "ci_low", "ci_high")
    intervals = intervals.cast({name: means.schema[name] for name in keys})
    joined = means.join(intervals, on=keys, how="left", nulls_equal=True, maintain_order="left")
    return joined.select(*varying(rows, declared["varies"]), "n", "spikes", "ci_low", "ci_high", *wanted[1:])
