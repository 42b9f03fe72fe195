"""Budgets on the terminal and as ``budget.csv``."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from experiments.bench.firmware.budget import MOST_WAITS, Budget, label
from experiments.bench.firmware.settings import STACKED
from experiments.bench.report.terminal import out_console, show_line, show_table
from experiments.bench.run.files import replacing

NOTES = (
    "Instructions were counted in QEMU, which knows no cycles: times are of the worst frame, over an assumed range of "
    "cycles an instruction. The time is undetermined until a board measures cycles: colias firmware export says how.",
    "RAM and flash are sections of the linked program. The robot's own share is an estimate (chip.robot_ram, "
    "chip.robot_flash); the column robot is what is left to it. Interrupts are an assumption (chip.interrupts, "
    f"chip.handler_stack); each stacks {STACKED} B, floats too.",
    "Flash waits: each look-up in a table in flash waits in full, as the tables are larger than the flash's data cache "
    "of 128 B. Other loads and the fetching of instructions are left out.",
)


def show(budgets: Sequence[Budget]) -> None:
    """Print a line for each program; of one alone its RAM by purpose and its instructions by stage too."""
    show_table(_table(budgets))
    if len(budgets) == 1:
        out_console.print()
        show_table(_purposes(budgets[0]))
        out_console.print()
        show_table(_stages(budgets[0]))
        out_console.print()
        show_table(_waits(budgets[0]))
        show_line(Text(f"{budgets[0].lookups:,} look-ups a frame", "dim"))
    out_console.print()
    fitting = sum(budget.fits_memory for budget in budgets)
    show_line(budgets[0].verdict if len(budgets) == 1 else f"memory fits in {fitting} of {len(budgets)}; "
              "time undetermined where none is called too slow")  # fmt: skip
    first, chip = budgets[0], budgets[0].firmware.chip
    ranges = f"{chip.cpi_least:g} to {chip.cpi_most:g} cycles an instruction at {chip.clock_mhz:g} MHz"
    for line in (f"{ranges}; {first.compiler}; {first.emulator}", *NOTES):
        show_line(Text(line, "dim"))


def _table(budgets: Sequence[Budget]) -> Table:
    keys = list(budgets[0].point)
    table = Table(box=None, header_style="bold", pad_edge=False)
    for name in keys or ["program"]:
        table.add_column(name.partition(".")[2] or name, justify="right")
    for name in ("RAM, B", "over, B", "robot, B", "flash, kB", "worst, M", "ms", "memory"):
        table.add_column(name, justify="right")
    for budget in budgets:
        low, high = budget.milliseconds
        values = [budget.point[key] for key in keys] or [label(budget)]
        verdict = Text(_short(budget), "green" if budget.fits_memory and not budget.too_slow else "red")
        table.add_row(
            *values, f"{sum(budget.purposes.values()):,}", f"{budget.over:,}" if budget.over else "",
            f"{budget.room:,}", f"{budget.flash / 1024:.1f}",
            f"{budget.whole.worst / 1e6:.2f}", f"{low:.2f}-{high:.2f}", verdict,
        )  # fmt: skip
    return table


def _short(budget: Budget) -> str:
    missing = ", ".join(budget.lacking)
    return (f"no: {missing}" if missing else "fits") + "; too slow" * budget.too_slow


def _purposes(budget: Budget) -> Table:
    table = Table("RAM", "bytes", "region", box=None, header_style="bold", pad_edge=False)
    where = budget.regions
    for name, size in budget.purposes.items():
        table.add_row(name + (f" ({_stack(budget)})" if name == "stack" else ""), f"{size:,}", where[name])
    return table


def _stack(budget: Budget) -> str:
    chip = budget.firmware.chip
    interrupts = f"{chip.interrupts} interrupts of {STACKED} + {chip.handler_stack} B"
    return f"{budget.stack_needed:,} B needed: {budget.stack_used:,} B used, {interrupts}"


def _waits(budget: Budget) -> Table:
    """Time of the worst frame by wait states of the flash, with the tables there and where they are, in RAM."""
    numbers = map(str, range(MOST_WAITS + 1))
    table = Table("flash wait states", *numbers, box=None, header_style="bold", pad_edge=False)
    low, high = budget.milliseconds
    for name, more in (("ms, tables in flash", budget.waiting_ms), ("ms, tables in RAM", lambda waits: 0.0)):
        waited = [more(waits) for waits in range(MOST_WAITS + 1)]
        table.add_row(name, *(f"{low + wait:.2f}-{high + wait:.2f}" for wait in waited))
    return table


def _stages(budget: Budget) -> Table:
    table = Table("instructions a frame", "median", "worst", box=None, header_style="bold", pad_edge=False)
    for stage in (*budget.stages, budget.whole):
        table.add_row(stage.name, f"{stage.median:,}", f"{stage.worst:,}")
    return table


def row(budget: Budget) -> dict[str, Any]:
    """Return one line of ``budget.csv``."""
    network, chip = budget.firmware.network, budget.firmware.chip
    low, high = budget.milliseconds
    sizes = {f"{name.replace(' ', '_')}_bytes": size for name, size in budget.purposes.items()}
    stages = {f"{stage.name}_{what}": getattr(stage, what) for stage in (*budget.stages, budget.whole)
              for what in ("median", "worst")}  # fmt: skip
    return {
        **budget.point, "n_con": network.n_con, "d": network.d, "state_bits": network.state_bits,
        "lamina_bits": network.lamina_bits, "shape": chip.shape,
        "verdict": budget.verdict, "fits_memory": budget.fits_memory, "time": budget.time, **sizes,
        "stack_used_bytes": budget.stack_used, "stack_needed_bytes": budget.stack_needed,
        "over_bytes": budget.over, "room_for_robot_bytes": budget.room,
        "flash_bytes": budget.flash,
        "placement": budget.built.placement.words(), **stages, "worst_clip": budget.worst_clip,
        "least_ms": round(low, 3), "most_ms": round(high, 3), "lookups": budget.lookups,
        **{f"flash_wait_{waits}_ms": round(budget.waiting_ms(waits), 3) for waits in range(MOST_WAITS + 1)},
        "compiler": budget.compiler, "emulator": budget.emulator,
    }  # fmt: skip


def write(budgets: Sequence[Budget], path: Path) -> None:
    """Write ``budget.csv``: a line for each program."""
    rows = [row(budget) for budget in budgets]
    with replacing(path) as partial, partial.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)
