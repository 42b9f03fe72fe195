"""Write a folder that builds the network for the robot: C sources, parameters, linker script, Makefile, one page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from dsnn.native.binding import ONBOARD
from dsnn.onboard.header import header
from experiments.bench.engine.errors import UsageError, printable
from experiments.bench.engine.templates import render
from experiments.bench.firmware.budget import Budget, Tools
from experiments.bench.firmware.build import (
    CHIP_SIDE,
    CONFIG,
    CORE,
    FLASH,
    MAIN,
    NATIVE,
    SECTIONS,
    computed,
    memory_script,
    script,
)
from experiments.bench.firmware.settings import Firmware, dead_zone_notice
from experiments.bench.store import places

ADDRESSES = {FLASH: 0x0800_0000, MAIN: 0x2000_0000, CORE: 0x1000_0000}
"""Addresses of the STM32F427's memories (its reference manual, memory map)."""
COPIED = (
    "startup.c", "memory.c", "chip.h", "camera.c", "camera.h", "semihost.c", "semihost.h", "counter.c", "counter.h",
    "answers.c", "host_main.c", "states.h", "split.h", SECTIONS,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Measured:
    """A budget, and what it was measured with."""

    budget: Budget
    tools: Tools


def export(wanted: Firmware, folder: Path, assignments: Sequence[str], measured: Measured | str) -> None:
    """Write the folder.

    Parameters
    ----------
    wanted
        Parameters and chip.
    folder
        A new or an empty one.
    assignments
        The ``--set`` texts that led here, for the page.
    measured
        The budget, or why there is none.

    Raises
    ------
    UsageError
        The parameters have no fixed-point form. Nothing was written.
    OSError
        The disk is full, say. Nothing is left there.
    """
    try:
        text = header(wanted.shape, wanted.network)
    except ValueError as error:
        raise UsageError(printable(str(error))) from None
    if isinstance(measured, str):
        placement, over = computed(wanted)
    else:
        placement, over = measured.budget.built.placement, measured.budget.built.over
    chip = wanted.chip
    sizes = {FLASH: chip.flash, MAIN: chip.ram_main, CORE: chip.ram_core}
    regions = {name: (ADDRESSES[name], size) for name, size in sizes.items()}
    words = {**_words(wanted, assignments, measured), "split": placement.split, "over": over}
    sources = {name: CHIP_SIDE / name for name in COPIED}
    sources |= {"main.c": CHIP_SIDE / "robot_main.c", "include/string.h": CHIP_SIDE / "include" / "string.h"}
    sources |= {name: NATIVE / name for name in ONBOARD}
    written = {
        CONFIG: text,
        "memory.ld": script(regions, chip, placement),
        "memory-qemu.ld": memory_script(chip, placement, large=True),
        "Makefile": render("firmware/templates/Makefile.j2", **words) + "\n",
        "README.md": render("firmware/templates/README.md.j2", **words) + "\n",
    }
    contents = {name: path.read_bytes() for name, path in sources.items()}
    contents |= {name: text.encode() for name, text in written.items()}
    include = folder / "include"
    try:
        include.mkdir(parents=True, exist_ok=True)
        for name, content in contents.items():
            with places.replacing(folder / name) as partial:
                partial.write_bytes(content)
    except OSError:
        for name in contents:
            (folder / name).unlink(missing_ok=True)
        include.rmdir()
        raise


def check_folder(folder: Path) -> None:
    """Raise `UsageError` where something is in the way of an export."""
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder}: is a file; legal is a new or an empty folder")
    if folder.is_dir() and any(folder.iterdir()):
        raise UsageError(f"{folder}: is not empty; legal is a new or an empty folder")
    places.check_folder(folder, f"{folder}")


def _words(wanted: Firmware, assignments: Sequence[str], measured: Measured | str) -> dict[str, Any]:
    rows, columns = wanted.shape
    options = "".join(f" --set {text}" for text in assignments)
    words: dict[str, Any] = {
        "chip": wanted.chip, "rows": rows, "columns": columns, "config": CONFIG,
        "version": version("colias-sim"),
        "notice": dead_zone_notice(wanted.network),
        "command": f"Its parameters: the defaults{' but' if options else ''}{options}.", "budget": None,
    }  # fmt: skip
    if isinstance(measured, str):
        return {**words, "missing": measured}
    budget, tools = measured.budget, measured.tools
    reasons = [f"{size:,} bytes over in {region.lower()} RAM" for region, size in budget.built.over.items()]
    if budget.flash > wanted.chip.flash:
        reasons.append(f"{budget.flash - wanted.chip.flash:,} bytes over in flash")
    reasons += [] if budget.fits_time else ["the worst frame takes too long"]
    return {
        **words, "budget": budget,
        "compiler": tools.compiler.version, "emulator": tools.qemu.version,
        "purposes": [(name, size, budget.regions[name]) for name, size in budget.purposes.items()],
        "stages": [*budget.stages, budget.whole],
        "verdict": "It fits the chip." if budget.fits else f"It does not fit the chip: {', '.join(reasons)}.",
    }  # fmt: skip
