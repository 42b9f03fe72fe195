"""Tables of a run with the robot on the terminal: the table of conditions, the verdicts, where everything is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from rich.table import Table
from rich.text import Text

from experiments.bench.report.terminal import count, out_console, show_files, show_table, show_verdicts
from experiments.bench.run.rows import RECORDING, group
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.rows import varying
from experiments.bench.stats.checks import is_number
from experiments.bench.stats.tests import LEVEL, Summary, least_of_pairs, summarise
from experiments.bench.trials import Report

SHORT = {
    "speed_cm_s": "cm/s", "distance_cm": "cm", "far_cm": "far cm", "angle_deg": "deg", "shell_grey": "shell",
    "wall_contrast": "wall", "observer_speed_cm_s": "own cm/s", "observer_turn_deg_s": "own deg/s",
    "acceleration_cm_s2": "cm/s2",
}  # fmt: skip
Rows = Sequence[Mapping[str, Any]]
OF_LOOMING = "looming detectors: their own spikes and peak"
"""A detector has no trough: at rest it is at 0.5."""


def show(report: Report, recordings: bool) -> None:
    """Print the table of conditions, the verdicts, and where everything is."""
    if report.provenance:
        out_console.print(Text.assemble((report.provenance, "b"), ": imported from a log"))
    if report.rows:
        show_table(_conditions_table(report))
    models = {row["model"] for row in report.rows} | {verdict.model for verdict in report.verdicts if verdict.model}
    several = len(models) > 1  # a model that failed in every trial has no rows, and verdicts all the same
    if report.open_loop and report.rows:
        show_table(_driven_table(report))
        out_console.print(report.open_loop)
    out_console.print()
    show_verdicts(report.verdicts, model=several, provenance=report.provenance)
    for model, greys in _silent(report.rows).items():
        out_console.print(f"{model} is silent: all its potentials are 0{greys}", markup=False)
    if report.comparisons:
        show_table(_comparisons_table(report))
    if report.flaws:
        out_console.print(Text.assemble("\n", ("beware", "red"), f": {report.flaws}"))
    names = [*(["figure.png"] if report.rows else []), "trials.parquet", *(["claims.json"] if report.verdicts else []),
             *(["failures.json"] if report.failures else [])]  # fmt: skip
    done = count(len({row["trial"] for row in report.rows}), "trial")
    show_files(report.folder, names, bool(recordings and report.rows), done)


def _silent(rows: Rows) -> dict[str, str]:
    """Return the models whose potentials are 0 in every frame of every trial, and what these frames were."""
    ends, silent = ("peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming"), {}
    for (model,), of_model in group(rows, "model").items():
        if not any(row[end] for row in of_model for end in ends):
            greys = [row[name] for row in of_model for name in ("darkest", "brightest") if row[name] is not None]
            silent[model] = f". Its frames had grey levels from {min(greys)} to {max(greys)}" if greys else ""
    return silent


def _comparisons_table(report: Report) -> Table:
    tests = max((row["test"] for row in report.comparisons), key=len)  # without a difference it has no method of p
    table = Table(
        title=f"\nmodels on the same frames ({tests}; p after Holm)", title_justify="left", box=None,
        header_style="bold", pad_edge=False,
    )  # fmt: skip
    names = [name for name in varying(report.rows, report.varies) if name != "model"]
    for name in (*(SHORT.get(name, name) for name in names), "models", "n", "difference", "rank-biserial", "p"):
        table.add_column(name, no_wrap=True)
    for row in report.comparisons:
        table.add_row(
            *("-" if row[n] is None else row[n] if isinstance(row[n], str) else f"{row[n]:g}" for n in names),
            f"{row['model']} - {row['against']}",
            f"{row['n']}",
            f"{row['mean_difference']:+z.1f}",
            f"{row['rank_biserial']:+z.2f}",
            "-" if least_of_pairs(row["n"]) > LEVEL else f"{row['p_holm']:.4f}",
        )
    return table


def _driven_table(report: Report) -> Table:
    """Return what the stimulus did in each condition: it is the same for every model."""
    table = Table(
        title="\nstimulus driven open loop (mean ± sd; drift: left positive)",
        title_justify="left", box=None, header_style="bold", pad_edge=False,
    )  # fmt: skip
    names = [name for name in varying(report.rows, report.varies) if name not in ("model", "speed_cm_s")]
    headings = ("commanded cm/s", "reached cm/s", "error", "drift mm", "path error mm")
    for name in (*(SHORT.get(name, name) for name in names), *headings):
        table.add_column(name, justify="right", no_wrap=True)
    first = [row for row in report.summary if row["model"] == report.rows[0]["model"]]
    for chosen in group(first, *CONDITION_COLUMNS).values():
        rows, wanted = {row["quantity"]: row for row in chosen}, chosen[0]["speed_cm_s"]
        values = (chosen[0][name] for name in names)
        speed, drift, path = (rows.get(name) for name in ("achieved_speed_cm_s", "drift_mm", "path_error_mm"))
        table.add_row(
            *("-" if v is None else v if isinstance(v, str) else f"{v:g}" for v in values),
            f"{wanted:g}",
            _with_spread(speed, "z.3f"),
            f"{speed['mean'] / wanted - 1:+z.1%}" if speed else "-",
            _with_spread(drift, "+z.1f"),
            f"{path['mean']:.1f}" if path else "-",
        )
    return table


def _with_spread(row: Mapping[str, Any] | None, form: str) -> str:
    """Mean and standard deviation of a quantity; a dash where nothing was measured."""
    if row is None:
        return "-"
    spread = "" if row["sd"] is None else f" ± {row['sd']:{form.removeprefix('+')}}"
    return f"{row['mean']:{form}}{spread}"


def _conditions_table(report: Report) -> Table:
    mechanism, looming = report.drawing == "mechanism", "looming" in report.counted.values()
    title = OF_LOOMING if looming else None
    table = Table(title=title, title_justify="left", box=None, header_style="bold", pad_edge=False)
    names = varying(report.rows, report.varies)
    without = {failure.model for failure in report.failures} - {row["model"] for row in report.rows} - {"", RECORDING}
    if without and "model" not in names:
        names = ["model", *names]
    for name in names:
        text = name in ("model", "motion", "direction")
        table.add_column(SHORT.get(name, name), justify="left" if text else "right", no_wrap=True)
    cells = (
        partial(_mechanism, window=report.varies == "speed_cm_s")
        if mechanism
        else partial(_spikes, rate="model" not in names)  # beside models there is no room for it
    )
    for index, chosen in enumerate(group(report.rows, "model", *CONDITION_COLUMNS).values()):
        values, measured = chosen[0], cells(chosen, report.counted.get(chosen[0]["model"], "hs"))
        if not index:
            for name in measured:
                table.add_column(name, justify="right", no_wrap=True)
        condition = ("-" if v is None else v if isinstance(v, str) else f"{v:g}" for v in (values[n] for n in names))
        table.add_row(*condition, *measured.values())
    for model in sorted(without):
        table.add_row(model, *[""] * (len(names) - 1), Text("failed", "red"))
    return table


def _spikes(rows: Rows, counted: str, *, rate: bool) -> dict[str, str]:
    """The cells of one condition, by the heading of their column; ``counted`` is the channel that they tell of."""
    spikes = _summary(rows, "spikes")
    return {
        "n": f"{len(rows)}",
        "spikes": _mean(rows, "spikes", ".1f"),
        "95 %": "-"
        if spikes is None or not is_number(spikes.ci_low)
        else f"{spikes.ci_low:.1f} .. {spikes.ci_high:.1f}",
        **({"rate Hz": _mean(rows, "firing_rate_hz", ".1f")} if rate else {}),
        "peak HS": _mean(rows, f"peak_{counted}", "+z.2f"),
        "trough HS": _mean(rows, f"trough_{counted}", "+z.2f"),
    }


def _mechanism(rows: Rows, counted: str, *, window: bool) -> dict[str, str]:
    """Make the table of the figure that is about mechanism: what makes up a count."""
    return {
        "n": f"{len(rows)}",
        "spikes": _mean(rows, "spikes", ".1f"),
        **({"in window": _mean(rows, "spikes_in_window", ".1f")} if window else {}),
        "s in view": _mean(rows, "seconds_in_view", ".2f"),
        "Hz in view": _mean(rows, "rate_in_view_hz", ".1f"),
        "mean HS": _mean(rows, "mean_hs_near_axis", "+z.2f") if counted == "hs" else "-",
        "peak HS": _mean(rows, f"peak_{counted}", "+z.2f"),
    }


def _summary(rows: Rows, column: str) -> Summary | None:
    """The summary of a column over trials; ``None`` where none has a number, as a model that does not spike."""
    values = [row[column] for row in rows if is_number(row.get(column))]
    return summarise(values, 0.0 if column == "spikes" else -math.inf) if values else None


def _mean(rows: Rows, column: str, form: str) -> str:
    """The mean of a column over trials, in a format; a dash where none has a number."""
    summary = _summary(rows, column)
    text = "-" if summary is None else f"{summary.mean:{form}}"
    return text if text.strip("+0.") else text.removeprefix("+")
