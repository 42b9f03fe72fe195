"""The chip, the memory that the robot itself needs, and how the program is compiled: ``--set chip.NAME=VALUE``."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass as validated

from dsnn.field_docs import unit, with_field_docs
from dsnn.onboard.dead_zone import dead_zone
from dsnn.onboard.params import OnboardParams
from experiments.bench.run.errors import UsageError
from experiments.bench.run.settings import Parameter, changed, collect, described

MODEL = "dsnn-onboard"
CHIP = "chip"
ALIAS = "dsnn"
"""``--set dsnn.n_con=4`` means the on-board form's own parameter here."""
LISTED_BY = "colias firmware parameters"
STACKED = 4 * (8 + 18) + 4
"""Bytes that an interrupt stacks where floats were in use: 8 words of the core, 18 of the FPU (S0 to S15, FPSCR, one
reserved), and a word that keeps the stack at multiples of 8 (ARMv7-M architecture reference manual, B1.5.6 and B1.5.7).
Lazy stacking leaves the FPU's words unwritten at first, but takes their room at once."""
WIDEST, NARROWEST = 640, 8
"""Pixels along a side of the frame that a camera of this kind gives."""


@with_field_docs
@validated(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True))
class ChipSettings:
    """The robot's processor and what else lives in it. The defaults are Colias's STM32F427 (its data sheet).

    Sizes are bytes. What is an assumption is called one; every number can be set.
    """

    shape: Annotated[str, unit("px")] = Field(
        default="99x72",
        description=f"columns x rows of the camera's frames: each a whole number from {NARROWEST} to {WIDEST}",
    )
    ram_main: Annotated[int, unit("bytes")] = Field(default=192 * 1024, ge=1024, le=2**24)
    """Main RAM; DMA reaches it, so the camera's ring is here."""
    ram_core: Annotated[int, unit("bytes")] = Field(default=64 * 1024, ge=1024, le=2**24)
    """Core-coupled RAM; DMA does not reach it."""
    flash: Annotated[int, unit("bytes")] = Field(default=2 * 1024 * 1024, ge=1024, le=4 * 1024 * 1024)
    """Flash memory."""
    ring_frames: Annotated[int, unit("frames")] = Field(default=3, ge=2, le=8)
    """Length of the camera's ring, YUV422, 2 bytes a pixel: as in a shipped build."""
    stack: Annotated[int, unit("bytes")] = Field(default=2048, ge=512, le=65536)
    """RAM reserved for the stack; its use is measured."""
    interrupts: Annotated[int, unit("levels")] = Field(default=4, ge=0, le=16)
    """Interrupts that may be under way at once, each on top of the one before, on the same stack: an assumption
    (camera's DMA, motors' UART, a tick, a fault); the chip has 16 priorities."""
    handler_stack: Annotated[int, unit("bytes")] = Field(default=128, ge=0, le=4096)
    """Stack that the code of one interrupt takes itself: an assumption."""
    robot_ram: Annotated[int, unit("bytes")] = Field(
        default=16 * 1024, ge=4, le=2**20, multiple_of=4,
        description="RAM of the rest of the robot's program. An estimate: a shipped build has 102 kB of"
        " zeroed data, of which the camera's ring is 42.8 kB and six maps of its one LGMD (an"
        " assumption) are as much",
    )  # fmt: skip
    robot_flash: Annotated[int, unit("bytes")] = Field(default=44 * 1024, ge=0, le=2**21)
    """Flash of the rest of the robot's program: a shipped build."""
    clock_mhz: Annotated[float, unit("MHz")] = Field(default=180.0, gt=0.0, le=1000.0)
    """Clock of the processor."""
    frame_ms: Annotated[float, unit("ms")] = Field(default=33.0, gt=0.0, le=10_000.0)
    """Time from frame to frame (33: 30 a second)."""
    cpi_least: Annotated[float, unit("cycles")] = Field(default=1.3, ge=0.5, le=20.0)
    """Least number of cycles an instruction takes: an assumption; flash waits are told apart."""
    cpi_most: Annotated[float, unit("cycles")] = Field(default=1.6, ge=0.5, le=20.0)
    """Greatest number of cycles an instruction takes: an assumption; flash waits are told apart."""
    optimise: Literal["s", "1", "2", "3"] = "3"
    """Level of the compiler's -O: at 3 it unrolls more, and flash is plenty."""

    def __post_init__(self) -> None:
        if self.cpi_least > self.cpi_most:
            raise ValueError(f"cpi_least={self.cpi_least:g} is above cpi_most={self.cpi_most:g}")
        form = re.fullmatch(r"[1-9]\d{0,2}x[1-9]\d{0,2}", self.shape, re.ASCII)
        if form is None or not all(NARROWEST <= side <= WIDEST for side in self.frame):
            sides = f"each a whole number from {NARROWEST} to {WIDEST}"
            raise ValueError(f"shape={self.shape}: legal is COLUMNSxROWS, such as 99x72, {sides}")

    @property
    def interrupt_stack(self) -> int:
        """Bytes of the stack that interrupts may take beside the network: each its frame and what its code takes."""
        return self.interrupts * (STACKED + self.handler_stack)

    @property
    def frame(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        columns, rows = self.shape.split("x")
        return int(rows), int(columns)


@dataclass(frozen=True, slots=True)
class Firmware:
    """One program for the chip: the network's parameters, and the chip.

    Parameters
    ----------
    network
        Of the model `MODEL`.
    chip
        The processor, the frame's shape, what else is in it.
    """

    network: OnboardParams
    chip: ChipSettings

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of the frames."""
        return self.chip.frame


def default() -> Firmware:
    """Return the on-board form's parameters for the robot's tests, on the robot's chip."""
    return Firmware(OnboardParams.robot(), ChipSettings())


def firmware(assignments: Iterable[str], base: Firmware | None = None, option: str = "--set") -> Firmware:
    """Return a program with ``SECTION.NAME=VALUE`` texts applied; sections are `MODEL` (or `ALIAS`) and `CHIP`.

    Raises
    ------
    UsageError
        A text names no parameter, or its value is not legal.
    """
    base = base or default()
    sections = {MODEL: base.network, CHIP: base.chip}
    texts = [plain_key(text) for text in assignments]
    collected = collect(texts, sections, LISTED_BY, option)
    configured = {
        name: changed(name, value, collected.get(name, {}), _typed(name, option)) for name, value in sections.items()
    }
    return Firmware(configured[MODEL], configured[CHIP])


def _typed(section: str, option: str) -> Any:
    return lambda name, text: f"{option} {section}.{name}={text}"


def plain_key(text: str) -> str:
    """``KEY=VALUE``, or a key alone, with `ALIAS` written out."""
    return f"{MODEL}{text[len(ALIAS) :]}" if text.startswith(f"{ALIAS}.") else text


def parameters() -> list[Parameter]:
    """Return every parameter that ``--set`` reaches here."""
    base = default()
    return list(described({MODEL: base.network, CHIP: base.chip}))


def dead_zone_notice(network: OnboardParams) -> str:
    """Say in one line what the longest delay cannot follow in its format; empty where that is next to nothing."""
    zone, bits = dead_zone(network), network.state_bits
    if not zone.matters:
        return ""
    falling, rising = (f"{100 * share:.2g} % of its range" for share in (zone.falling, zone.rising))
    other = f", or 16 bits ({MODEL}.state_bits=16)" if bits == 8 else ""
    return (
        f"tau_s up to {zone.tau_ms:g} ms, delay states of {bits} bits: where a delayed signal should fall to 0 it"
        f" stands still at up to {falling}, and from 0 it does not rise to {rising} or less; delays without"
        f" this are up to {math.floor(zone.longest_ms):,} ms{other}"
    )


def longest_delay() -> str:
    """Say in one line which delays the default format follows."""
    network = default().network
    longest = math.floor(dead_zone(network).longest_ms)
    return (
        f"with delay states of {network.state_bits} bits a delayed signal stands still, where it should fall to 0, if"
        f" its delay ({MODEL}.tau_s) is above {longest:,} ms at {network.fps:g} frames a second;"
        f" {MODEL}.state_bits=16 follows longer ones"
    )


def points(over: Sequence[str], assignments: Sequence[str]) -> list[tuple[Mapping[str, str], Firmware]]:
    """List every combination of ``KEY=V1,V2`` texts, each with its program; one without keys if ``over`` is empty."""
    from experiments.bench.grid import product

    if not over:
        return [({}, firmware(assignments))]
    base = firmware(assignments)
    programs: list[tuple[Mapping[str, str], Firmware]] = []
    for point in product([plain_key(text) for text in over], [plain_key(text) for text in assignments]):
        texts = [f"{key}={value}" for key, value in point]
        programs.append((dict(point), firmware(texts, base, "--over")))
    if len(programs) > MOST_POINTS:
        raise UsageError(
            f"--over: {len(programs)} points; legal are up to {MOST_POINTS}, as each is built and emulated"
        )
    return programs


MOST_POINTS = 200
