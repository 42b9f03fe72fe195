"""What a run of trials or of clips prints: its table, the verdicts, where everything is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import polars as pl

from experiments.bench.report import terminal
from experiments.bench.report.terminal import count, out_console, show_files, show_line, show_verdicts
from experiments.bench.result import Run, whole_networks
from experiments.bench.run.description import THRESHOLDS
from experiments.bench.run.models import counted_channel
from experiments.bench.run.rows import RECORDING, group
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.judge import PATH_TOLERANCE_MM, SPEED_TOLERANCE, flaws
from experiments.bench.sources.trial_rows import drawable, varying
from experiments.bench.stats.tests import summary_rows

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
FILES = ("figure.png", "trials.parquet", "claims.json", "failures.json")
"""The files that are named, as far as they are there."""


def show(run: Run) -> None:
    """Print what a run comes to, of trials with the robot or of clips."""
    if run.kind == "clips":
        show_clips(run)
    else:
        show_trials(run)


def show_trials(run: Run) -> None:
    """Print the means of each condition, the verdicts, tests between models, and where everything is."""
    provenance, declared = run.provenance if run.kind == "measured" else "", run.description["experiment"]
    robot, every = run.description["settings"]["robot"], run.trials.to_dicts() if run.done else []
    rows = whole_networks(run)
    if provenance:
        show_line(f"{provenance}: imported from a log")
    if rows:
        terminal.show(conditions(run, rows))
    models = {row["model"] for row in rows}
    for model in sorted({*run.failures["model"]} - models - {"", RECORDING}):
        out_console.print(f"{model} failed in every trial", style="red")
    if robot["open_loop"] and rows:
        show_line(why_none_left_out(robot["power_step_cm_s"], min(row["speed_cm_s"] for row in rows)))
    out_console.print()
    several = len(models | {verdict.model for verdict in run.verdicts if verdict.model}) > 1
    show_verdicts(run.verdicts, model=several, provenance=provenance)
    for (model,), of_model in group(rows, "model").items():
        if not any(row[end] for row in of_model for end in ENDS):
            greys = [row[name] for row in of_model for name in ("darkest", "brightest") if row[name] is not None]
            seen = f". Its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
            show_line(f"{model} is silent: all its potentials are 0{seen}")
    if rows and run.comparisons.height:
        names = [name for name in varying(rows, declared["varies"]) if name != "model"]
        columns = [*names, "model", "against", "n", "mean_difference", "rank_biserial", "p_holm"]
        title = f"\nmodels on the same frames ({run.comparisons['test'][0]}; p after Holm)"
        terminal.show(_rounded(run.comparisons.select(columns)), title)
    if beware := flaws(every):
        out_console.print(f"\nbeware: {beware}", style="red")
    _files(run, len({row["trial"] for row in rows}), "trial")


def conditions(run: Run, rows: Sequence[Mapping[str, Any]]) -> pl.DataFrame:
    """Return the table of conditions: what varies, n, means over trials, and the 95 % interval of the spikes' mean."""
    declared, open_loop = run.description["experiment"], run.description["settings"]["robot"]["open_loop"]
    varies, levels = declared["varies"], run.description[THRESHOLDS]
    counted = {model: counted_channel(levels[model]) for model in levels}
    ends = [{"peak": row.get(f"peak_{counted[row['model']]}"), "trough": row.get(f"trough_{counted[row['model']]}")}
            for row in rows]  # fmt: skip
    mechanism = drawable(declared["figure"], rows) == "mechanism"
    wanted = [*(MECHANISM if mechanism else SPIKES), *(DRIVEN if open_loop else ())]
    if varies != "speed_cm_s" and "spikes_in_window" in wanted:
        wanted.remove("spikes_in_window")  # it is as long as the fastest crossing at a distance: another at each
    keys = ["model", *CONDITION_COLUMNS]
    intervals = {
        tuple(row[key] for key in keys): f"{row['ci_low']:.1f} .. {row['ci_high']:.1f}"
        for row in summary_rows(rows, keys, ("spikes",), ()) if row["ci_low"] is not None
    }  # fmt: skip
    table = pl.DataFrame([{**row, **end} for row, end in zip(rows, ends, strict=True)], infer_schema_length=None)
    means = table.group_by(keys, maintain_order=True).agg(pl.len().alias("n"), pl.col(*wanted).cast(float).mean())
    interval = pl.Series("95 %", [intervals.get(key) for key in means.select(keys).rows()], pl.String)
    names = varying(rows, varies)
    return _rounded(means.with_columns(interval).select(*names, "n", "spikes", "95 %", *wanted[1:]))


def why_none_left_out(step_cm_s: float, slowest_cm_s: float) -> str:
    """Say why no trial is left out for its speed or path where the stimulus drives open loop.

    Parameters
    ----------
    step_cm_s
        One step of a motor's power; 0 where powers have no steps.
    slowest_cm_s
        The slowest commanded speed of the stimulus.
    """
    text = (
        f"open loop: nothing corrects the stimulus, so no trial is left out for a speed {SPEED_TOLERANCE:.0%} off "
        f"or a path {PATH_TOLERANCE_MM:g} mm off"
    )
    if not step_cm_s:
        return text
    share = step_cm_s / slowest_cm_s
    return f"{text}; one step of power is {step_cm_s:g} cm/s, {share:.1%} at {slowest_cm_s:g} cm/s"


def _rounded(table: pl.DataFrame) -> pl.DataFrame:
    """Return a table as people read it: numbers of four digits, short headings."""
    return table.with_columns(pl.col(pl.Float64).round_sig_figs(4)).rename(HEADINGS, strict=False)


def show_clips(run: Run) -> None:
    """Print the range of potentials of every clip at the first seed, the verdicts, and where everything is."""
    every = run.trials.to_dicts() if run.done else []
    rows = [
        {
            "clip": row["clip"], "model": row["model"], "HS": f"{row['trough_hs']:+z.3f} .. {row['peak_hs']:+z.3f}",
            "VS": f"{row['trough_vs']:+z.3f} .. {row['peak_vs']:+z.3f}", "looming": round(row["peak_looming"], 2),
            "spikes": row["spikes"],
        }
        for row in every if row["repeat"] == 0
    ]  # fmt: skip
    if rows:
        terminal.show(pl.DataFrame(rows, infer_schema_length=None), "potentials of each clip, first seed")
    out_console.print()
    show_verdicts(run.verdicts, model=False)
    _files(run, len({row["trial"] for row in every}), "clip")


def _files(run: Run, done: int, thing: str) -> None:
    names = [name for name in FILES if (run.folder / name).is_file()]
    show_files(run.folder, names, bool(run.recordings), count(done, thing))
