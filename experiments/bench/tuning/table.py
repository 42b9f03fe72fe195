"""Output of ``colias tune``: a row a model, and where everything is."""

from __future__ import annotations

from collections.abc import Callable

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_line, show_places, show_table
from experiments.bench.tuning.defined import SOME
from experiments.bench.tuning.preferences import Preferences
from experiments.bench.tuning.probes import STIMULUS
from experiments.bench.tuning.run import TuningReport

COLUMNS: tuple[tuple[str, str, str, Callable[[Preferences], str]], ...] = (
    ("speed px/s", "speed", "speed_px_s", lambda p: _cell(p.speed_px_s)),
    ("size px", "size", "size_px", lambda p: _cell(p.size_px)),
    ("c50", "contrast", "half_contrast", lambda p: _cell(p.half_contrast, "{:.2f}")),
    ("TF Hz", "frequency", "temporal_hz", lambda p: _cell(p.temporal_hz)),
    ("wave px", "frequency", "wavelength_px", lambda p: _cell(p.wavelength_px)),
    ("slope", "frequency", "slope", lambda p: _cell(p.slope, "{:z.2f}")),
    ("DSI", "direction", "dsi", lambda p: _cell(p.dsi, "{:.2f}")),
    ("prefers", "direction", "prefers_deg", lambda p: _cell(_told(p), "{:.0f}°")),
    ("off", "direction", "error_deg", lambda p: _cell(p.error_deg, "{:.0f}°")),
    ("fires", "l-over-v", "fires_deg", lambda p: _cell(p.fires_deg, "{:.0f}°")),
    ("looms", "disc", "looming_by_potential", lambda p: _cell(p.looming_by_potential, "{:.0%}")),
    ("spikes", "disc", "looming_by_spikes", lambda p: _cell(p.looming_by_spikes, "{:.0%}")),
    ("largest at", STIMULUS, "stimulus", lambda p: _cell(p.stimulus)),
)
"""Heading, the family it comes from, the field of `Preferences`, the cell."""
UNDEFINED = "n.d."
NOTE = (
    "Where each model answers most (≥, ≤: up to an end of what was shown; flat: alike everywhere). c50: "
    "contrast of half its largest answer to a dark object. Slope: of best temporal over spatial frequency; 0 temporal "
    "frequency decides, 1 speed. DSI: of HS, or looming, for gratings, |sum r exp(ia)| / sum r, r rectified; 1 one "
    "direction alone, 0.79 a cosine, 0 all alike. Off: how far (hs, vs) points off the motion. Fires: the "
    "full angle of dark looming at its first spike, median over l/v. Looms, spikes: at which share of l/v a dark disc "
    "that looms gets a higher peak, or more spikes, than the same that recedes and that crosses. Largest at: along the "
    "parameter of --over. n.d.: not defined, "
    "as below."
)


def show(report: TuningReport) -> None:
    """Print the table of preferences, what its columns mean, the paths."""
    measured = {family.name for family in report.plan.families}
    columns = [column for column in COLUMNS if column[1] in measured]
    table = Table(title="tuning", title_justify="left", box=None, header_style="bold", pad_edge=False)
    table.add_column("model", no_wrap=True)
    for name, *_ in columns:
        table.add_column(name, justify="right", no_wrap=True)
    for preference in report.preferences:
        cells = (UNDEFINED if name in preference.undefined else cell(preference) for _, _, name, cell in columns)
        table.add_row(preference.model, *cells)
    show_table(table)
    out_console.print(f"{NOTE}\n", style="dim")
    for row in report.preferences:
        for why in dict.fromkeys(row.undefined.values()):
            names = ", ".join(name for name in row.undefined if row.undefined[name] == why)
            show_line(f"{row.model}, {names}: not defined: {why}", 4)
    show_places({**report.figures, "tables": report.folder / "tuning.csv"})


def _told(preferences: Preferences) -> float | None:
    """Return the preferred direction, if it prefers one."""
    if preferences.dsi is None or preferences.prefers_deg is None or preferences.dsi < SOME:
        return None
    return round(preferences.prefers_deg) % 360


def _cell(value: object, form: str = "{}") -> str:
    return "-" if value is None else form.format(value)
