"""The robot's chip and the network on it: what ``--set`` reaches in the commands ``colias firmware ...``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated, Any

from pydantic import Field

from dsnn.field_docs import parameters, unit
from dsnn.onboard.params import OnboardParams
from experiments.bench.run.settings import changed, collect

MODEL, CHIP = "dsnn-onboard", "chip"
LISTED_BY = "colias list parameters firmware"
CYCLES = 1.3, 1.6
"""Fewest and most cycles of an instruction: an assumption, until a board has measured them."""


@parameters
class ChipSettings:
    """The robot's processor and what else lives in it. The defaults are Colias's STM32F427 (its data sheet)."""

    columns: Annotated[int, unit("px")] = Field(default=99, ge=8, le=640)
    """Width of the camera's frames."""
    rows: Annotated[int, unit("px")] = Field(default=72, ge=8, le=640)
    """Height of the camera's frames."""
    ram_main: Annotated[int, unit("bytes")] = Field(default=192 * 1024, ge=1024, le=2**24)
    """Main RAM; DMA reaches it, so the camera's ring is here."""
    ram_core: Annotated[int, unit("bytes")] = Field(default=64 * 1024, ge=1024, le=2**24)
    """Core-coupled RAM; DMA does not reach it."""
    flash: Annotated[int, unit("bytes")] = Field(default=2 * 1024 * 1024, ge=1024, le=4 * 1024 * 1024)
    """Flash memory."""
    clock_mhz: Annotated[float, unit("MHz")] = Field(default=180.0, gt=0.0, le=1000.0)
    """Clock of the processor."""
    ring_frames: Annotated[int, unit("frames")] = Field(default=3, ge=2, le=8)
    """Length of the camera's ring, YUV422, 2 bytes a pixel: as in a shipped build."""
    stack: Annotated[int, unit("bytes")] = Field(default=2048, ge=512, le=65536)
    """RAM reserved for the stack; what the network uses of it is measured."""
    interrupt_stack: Annotated[int, unit("bytes")] = Field(default=944, ge=0, le=65536)
    """Stack that interrupts take beside the network. An assumption: four at once, each with 108 bytes that the
    processor stacks where floats are in use and 128 of its own code."""
    robot_ram: Annotated[int, unit("bytes")] = Field(default=16 * 1024, ge=0, le=2**20)
    """RAM of the rest of the robot's program. An estimate: a shipped build has 102 kB of zeroed data, of which the
    camera's ring is 42.8 kB and six maps of its one LGMD (an assumption) are as much."""

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        return self.rows, self.columns


Program = tuple[OnboardParams, ChipSettings]
"""A program for the chip: the network's parameters, and the chip."""


def sections() -> dict[str, Any]:
    """Return the sections of ``--set`` with their defaults."""
    return {MODEL: OnboardParams.robot(), CHIP: ChipSettings()}


def program(assignments: Iterable[str]) -> Program:
    """Return a program with ``SECTION.NAME=VALUE`` texts applied; `UsageError` for what is not legal."""
    values = sections()
    collected = collect(assignments, values, LISTED_BY)
    network, chip = (changed(name, value, collected.get(name, {})) for name, value in values.items())
    return network, chip
