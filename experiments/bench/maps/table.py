"""A map on the terminal: a table for each claim and measure, and how much of the grid a claim holds on."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from experiments.bench.engine.terminal import out_console, show_places, show_table
from experiments.bench.maps.judging import TOGETHER, Cell, Number, by_claim, by_measure, reaches, regions
from experiments.bench.maps.plan import MapPlan
from experiments.bench.maps.run import Map


def show(made: Map) -> None:
    """Print a table for each claim and measure, the share of the grid that each claim holds on, and where all is."""
    for claim, chosen in by_claim(made.cells).items():
        what = "all claims together" if claim == TOGETHER else f"{claim}, judged on {chosen[0].experiment}"
        out_console.print(f"{what}: held in n of {chosen[0].of}", markup=False, style="bold")
        show_table(_table(made.plan, chosen))
        out_console.print()
    for name, own in by_measure(made.numbers).items():
        unit = f", {own[0].measure.unit}" if own[0].measure.unit else ""
        out_console.print(f"{name}{unit}: {own[0].measure.says}, in {own[0].experiment}", markup=False, style="bold")
        show_table(_table(made.plan, own))
        out_console.print()
    directions = zip(("across", "down"), made.plan.axes, strict=False)
    out_console.print(
        "; ".join(f"{way}: {' '.join(axis.words())}" for way, axis in directions), markup=False, soft_wrap=True
    )
    for line in (*regions(made.cells), *reaches(made.numbers)):
        out_console.print(line, markup=False)
    if any(cell.untested for cell in made.cells):
        out_console.print("?: not judged in some replicate; map.csv says why", markup=False)
    if any(each.mark for each in made.numbers):
        out_console.print("*: what the lines above say of a number; map.csv has it for each point", markup=False)
    if any(cell.vacuous for cell in made.cells):
        out_console.print("v: vacuous in some replicate, as the network answers nothing there", markup=False)
    out_console.print()
    places: dict[str, object] = {
        name: made.folder / f"map.{kind}" for name, kind in (("figure", "png"), ("table", "csv"))
    }
    if made.failures:
        places["failures"] = made.folder / "failures.json"
    show_places(places)


def _table(plan: MapPlan, chosen: Sequence[Cell] | Sequence[Number]) -> Table:
    """Held in n of N, or a number: the first axis across, the second down from its highest level, as in the figure."""
    across, up = plan.axes[0], plan.axes[1] if len(plan.axes) > 1 else None
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in ("", *across.levels):
        table.add_column(name, justify="right")
    found = {cell.point.values: cell for cell in chosen}
    for level in reversed(up.levels) if up else ("",):
        own = [found[((across.name, each), *(((up.name, level),) if up else ()))] for each in across.levels]
        table.add_row(level, *map(_shown, own))
    return table


def _shown(cell: Cell | Number) -> str:
    """A cell with what marks it."""
    if isinstance(cell, Number):
        return f"{cell.shown()}{'*' if cell.mark else ''}"
    return f"{cell.shown()}{'?' if cell.untested else ''}"
