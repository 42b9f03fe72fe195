"""What a run of trials or of clips prints: its table, the verdicts, where everything is."""

from __future__ import annotations

import polars as pl

from experiments.bench.offline import OfflineReport
from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_line, show_verdicts
from experiments.bench.run.rows import RECORDING, group
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.rows import varying
from experiments.bench.trials import Report

HEADINGS = {
    "speed_cm_s": "cm/s", "distance_cm": "cm", "far_cm": "far cm", "angle_deg": "deg", "shell_grey": "shell",
    "wall_contrast": "wall", "observer_speed_cm_s": "own cm/s", "observer_turn_deg_s": "own deg/s",
    "acceleration_cm_s2": "cm/s2", "spikes": "spikes", "firing_rate_hz": "rate Hz", "peak": "peak", "trough": "trough",
    "spikes_in_window": "in window", "seconds_in_view": "s in view", "rate_in_view_hz": "Hz in view",
    "mean_hs_near_axis": "mean HS", "achieved_speed_cm_s": "reached cm/s", "drift_mm": "drift mm",
    "path_error_mm": "path error mm",
}  # fmt: skip
"""Column of a table -> its heading on the terminal."""
SPIKES = ("spikes", "firing_rate_hz", "peak", "trough")
MECHANISM = ("spikes", "spikes_in_window", "seconds_in_view", "rate_in_view_hz", "mean_hs_near_axis", "peak")
ENDS = ("peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming")
DRIVEN = ("achieved_speed_cm_s", "drift_mm", "path_error_mm")
"""Means that the table of conditions has; of figures about mechanism; what a silent model has; of an open loop."""


def show(report: Report | OfflineReport, recordings: bool) -> None:
    """Print what a run of either kind comes to; ``recordings`` is whether they were asked for."""
    if isinstance(report, OfflineReport):
        show_clips(report, recordings and report.plan.experiment.recorded)
    else:
        show_trials(report, recordings)


def show_trials(report: Report, recordings: bool) -> None:
    """Print the means of each condition, the verdicts, tests between models, and where everything is."""
    if report.provenance:
        show_line(f"{report.provenance}: imported from a log")
    if report.rows:
        terminal.show(conditions(report))
    models = {row["model"] for row in report.rows}
    for model in sorted({failure.model for failure in report.failures} - models - {"", RECORDING}):
        out_console.print(f"{model} failed in every trial", style="red")
    if report.open_loop:
        show_line(report.open_loop)
    out_console.print()
    several = len(models | {verdict.model for verdict in report.verdicts if verdict.model}) > 1
    show_verdicts(report.verdicts, model=several, provenance=report.provenance)
    for (model,), rows in group(report.rows, "model").items():
        if not any(row[end] for row in rows for end in ENDS):
            greys = [row[name] for row in rows for name in ("darkest", "brightest") if row[name] is not None]
            seen = f". Its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            show_line(f"{model} is silent: all its potentials are 0{seen}")
    if report.comparisons:
        names = [name for name in varying(report.rows, report.varies) if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        tested = pl.DataFrame(report.comparisons, infer_schema_length=None).select(columns)
        terminal.show(_rounded(tested), f"\nmodels on the same frames ({report.comparisons[0]['test']}; p after Holm)")
    if report.flaws:
        out_console.print(f"\nbeware: {report.flaws}", style="red")
    done = count(len({row["trial"] for row in report.rows}), "trial")
    _files(report, bool(recordings and report.rows), done)


def conditions(report: Report) -> pl.DataFrame:
    """Return the table of conditions: what varies, n, means over trials, and the 95 % interval of the spikes' mean."""
    rows = []
    for row in report.rows:
        channel = report.counted.get(row["model"], "hs")
        rows.append({**row, "peak": row.get(f"peak_{channel}"), "trough": row.get(f"trough_{channel}")})
    names = varying(report.rows, report.varies)
    wanted = [*(MECHANISM if report.drawing == "mechanism" else SPIKES), *(DRIVEN if report.open_loop else ())]
    if report.varies != "speed_cm_s" and "spikes_in_window" in wanted:
        wanted.remove("spikes_in_window")  # it is as long as the fastest crossing at a distance: another at each
    keys = ["model", *CONDITION_COLUMNS]
    intervals = {
        tuple(row[key] for key in keys): f"{row['ci_low']:.1f} .. {row['ci_high']:.1f}"
        for row in report.summary if row["quantity"] == "spikes" and row["ci_low"] is not None
    }  # fmt: skip
    table = pl.DataFrame(rows, infer_schema_length=None)
    means = table.group_by(keys, maintain_order=True).agg(pl.len().alias("n"), pl.col(*wanted).cast(float).mean())
    interval = pl.Series("95 %", [intervals.get(key) for key in means.select(keys).rows()], pl.String)
    return _rounded(means.with_columns(interval).select(*names, "n", "spikes", "95 %", *wanted[1:]))


def _rounded(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table as people read it: numbers of four digits, short headings."""
    return table.with_columns(pl.col(pl.Float64).round_sig_figs(4)).rename(HEADINGS, strict=False)


def show_clips(report: OfflineReport, recordings: bool) -> None:
    """Print the range of potentials of every clip at the first seed, the verdicts, and where everything is."""
    rows = [
        {
            "clip": row["clip"], "model": row["model"], "HS": f"{row['trough_hs']:+z.3f} .. {row['peak_hs']:+z.3f}",
            "VS": f"{row['trough_vs']:+z.3f} .. {row['peak_vs']:+z.3f}", "looming": round(row["peak_looming"], 2),
            "spikes": row["spikes"],
        }
        for row in report.rows if row["repeat"] == 0
    ]  # fmt: skip
    if rows:
        terminal.show(pl.DataFrame(rows, infer_schema_length=None), "potentials of each clip, first seed")
    out_console.print()
    show_verdicts(report.verdicts, model=False)
    done = count(len({row["trial"] for row in report.rows}), "clip")
    _files(report, bool(recordings and report.rows), done)


def _files(report: Report | OfflineReport, recordings: bool, done: str) -> None:
    there = {"figure.png": report.rows, "trials.parquet": True, "claims.json": report.verdicts,
             "failures.json": report.failures}  # fmt: skip
    show_files(report.folder, [name for name, given in there.items() if given], recordings, done)
