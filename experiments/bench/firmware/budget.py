"""Budget of one program on the chip: RAM and flash of its linked ELF file, instructions a frame counted in QEMU.

QEMU knows no cycles, so a budget says whether the memory fits, and leaves the time undetermined.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dsnn.onboard.fixed import constants
from experiments.bench.firmware import clips
from experiments.bench.firmware.build import CORE, MAIN, NATIVE, Built, build, free
from experiments.bench.firmware.emulator import INPUT, STAGES, Emulator
from experiments.bench.firmware.settings import Firmware
from experiments.bench.firmware.toolchain import Compiler, QemuProgram

MOST_WAITS = 5
"""Wait states of the flash at 150 to 180 MHz and 2.7 to 3.6 V (STM32F427: reference manual RM0090, FLASH_ACR)."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Instructions of one stage a frame: the median and the largest number over the frames of all clips."""

    name: str
    median: int
    worst: int


@dataclass(frozen=True, slots=True)
class Budget:
    """Budget of one program on the chip. Sizes are bytes.

    Parameters
    ----------
    point
        The values that tell it from others of a grid: key -> text.
    firmware
        Parameters and chip.
    built
        The linked program: sizes of its sections, where its data lie, by how much it is too large.
    stack_used
        The stack's high-water mark without interrupts: none come in the emulator.
    stages
        Of the camera's luma and of the network.
    whole
        All stages together.
    worst_clip
        The clip that has the frame of the most instructions.
    compiler, emulator
        Versions of what built it and of what counted, as these say themselves.
    """

    point: Mapping[str, str]
    firmware: Firmware
    built: Built
    stack_used: int
    stages: tuple[Stage, ...]
    whole: Stage
    worst_clip: str
    compiler: str
    emulator: str

    @property
    def purposes(self) -> dict[str, int]:
        """RAM by purpose; of the stack what is reserved."""
        sizes = self.built.sections
        return {
            "states": sizes.get(".states", 0) + sizes.get(".second", 0),
            "tables": sizes.get(".tables", 0),
            "camera ring": sizes.get(".ring", 0),
            "stack": sizes.get(".stack", 0),
            "robot": sizes.get(".robot_main", 0) + sizes.get(".robot_core", 0),
            "test program": sizes.get(".data", 0) + sizes.get(".bss", 0),
        }

    @property
    def flash(self) -> int:
        """Code and tables, those of the test program too, and the robot's own code."""
        size = sum(self.built.sections.get(name, 0) for name in (".text", ".ARM.exidx", ".data", ".tables"))
        return size + self.firmware.chip.robot_flash

    @property
    def ram_left(self) -> dict[str, int]:
        """RAM region -> bytes that are left there, the robot's own data taken off too."""
        return free(self.built.sections, self.firmware.chip, self.built.placement)

    @property
    def room(self) -> int:
        """The bytes of both regions that network, camera and stack leave to the rest of the robot's program."""
        return sum(self.ram_left.values()) + self.firmware.chip.robot_ram

    @property
    def regions(self) -> dict[str, str]:
        """Purpose -> the RAM region or regions that it lies in."""
        placement = self.built.placement
        states = f"{placement.states}, {CORE}" if placement.split else placement.states
        robot = CORE if placement.robot_core == self.firmware.chip.robot_ram else f"{MAIN}, {CORE}"
        both = {"states": states, "robot": robot if placement.robot_core else MAIN, "stack": CORE, "tables": CORE}
        return {name: both.get(name, MAIN).lower() for name in self.purposes}

    @property
    def over(self) -> int:
        """The bytes of RAM that are missing; 0 where it fits."""
        return sum(self.built.over.values())

    @property
    def stack_needed(self) -> int:
        """The bytes of stack that the network and the interrupts on top of it take at most; the latter are assumed."""
        return self.stack_used + self.firmware.chip.interrupt_stack

    @property
    def milliseconds(self) -> tuple[float, float]:
        """Time of the frame of the most instructions, at the least and at the most cycles an instruction."""
        chip = self.firmware.chip
        low, high = (
            self.whole.worst * cycles / (1000.0 * chip.clock_mhz) for cycles in (chip.cpi_least, chip.cpi_most)
        )
        return low, high

    @property
    def lookups(self) -> int:
        """Loads a frame from the tables of the delayed signals: two each, the code's next or value, and the value."""
        rows, columns = self.firmware.shape
        fixed = constants(self.firmware.shape, self.firmware.network)
        return 2 * 2 * rows * columns * fixed.spacings if fixed.state_bits == 8 else 0

    def waiting_ms(self, waits: int) -> float:
        """Tell the time a frame that `lookups` would wait, were the tables in flash: each load takes all wait states.

        The chip's flash has a cache of 128 bytes for data, the tables of N_con = 8 have 2,560: none of the loads is
        taken to be in it.
        """
        return self.lookups * waits / (1000.0 * self.firmware.chip.clock_mhz)

    @property
    def lacking(self) -> dict[str, int]:
        """The memories of the chip that are too small -> the bytes that each lacks.

        RAM, by its true regions; flash, which has the robot's code too; the stack, which has room for interrupts.
        """
        chip = self.firmware.chip
        lacks = {"RAM": self.over, "flash": self.flash - chip.flash, "stack": self.stack_needed - chip.stack}
        return {name: size for name, size in lacks.items() if size > 0}

    @property
    def fits_memory(self) -> bool:
        """Tell whether no memory of the chip is too small."""
        return not self.lacking

    @property
    def too_slow(self) -> bool:
        """Tell whether the worst frame is late even at the least cycles an instruction. If not, cycles decide, which
        nobody has measured.
        """
        return self.milliseconds[0] > self.firmware.chip.frame_ms

    @property
    def memory(self) -> str:
        """Memory in words: ``memory fits``, or what is too small by how much."""
        reasons = [
            f"stack {size:,} B too small" if name == "stack" else f"{size:,} B of {name} too large"
            for name, size in self.lacking.items()
        ]
        return ", ".join(reasons) or "memory fits"

    @property
    def time(self) -> str:
        """Time in words: ``undetermined`` until cycles are measured on a board, or ``too slow``."""
        return "too slow" if self.too_slow else "undetermined"

    @property
    def verdict(self) -> str:
        """Memory and time in words."""
        return f"{self.memory}; time {self.time}"


@dataclass(frozen=True, slots=True)
class Tools:
    """Tools that build and emulate."""

    compiler: Compiler
    qemu: QemuProgram


def stage_names() -> tuple[str, ...]:
    """Return the network's stages in their order, as ``onboard.h`` names them."""
    text = (NATIVE / "onboard.h").read_text(encoding="utf-8").replace("\\\n", " ")
    match = re.search(r"#define ONBOARD_STAGE_NAMES\b(.*)", text)
    if match is None:
        raise ValueError("onboard.h names no ONBOARD_STAGE_NAMES")
    return tuple(re.findall(r'"(\w+)"', match[1]))


def measure(
    point: Mapping[str, str], wanted: Firmware, tools: Tools, folder: Path, length: int = clips.COUNTED_FRAMES
) -> Budget:
    """Build a program in ``folder``, run it on clips of ``length`` frames, and read what it takes.

    Raises
    ------
    UsageError
        It cannot be built.
    EmulatorError
        The emulated chip gives no answer.
    """
    built = build(wanted, tools.compiler, folder)
    rows: list[npt.NDArray[np.float64]] = []
    names: list[str] = []
    with Emulator(tools.qemu, built.path, wanted.shape) as chip:
        for name, frames in clips.synthetic(wanted.shape, length).items():
            chip.reset()
            rows += [chip.step(frame).instructions for frame in frames]
            names += [name] * len(frames)
        stack = chip.stack_bytes()
    counts = np.stack(rows)
    sums = counts.sum(axis=1)
    purposes = [("input", INPUT), *((name, place) for place, name in enumerate(stage_names()))]
    unnamed = set(range(STAGES)) - {place for _, place in purposes}
    assert not counts[:, sorted(unnamed)].any(), "a stage without a name ran"
    stages = tuple(_stage(name, counts[:, place]) for name, place in purposes)
    return Budget(
        dict(point), wanted, built, stack, stages, _stage("whole", sums), names[int(sums.argmax())],
        tools.compiler.version, tools.qemu.version,
    )  # fmt: skip


def _stage(name: str, counts: npt.NDArray[np.float64]) -> Stage:
    return Stage(name, round(float(np.median(counts))), round(float(counts.max())))


def measure_all(
    points: Sequence[tuple[Mapping[str, str], Firmware]], tools: Tools, workers: int, done: Callable[[], None]
) -> list[Budget]:
    """Measure every point, ``workers`` at a time; ``done`` is called as each is measured. The order is that of points.

    Threads are enough: compiler and emulator are processes of their own.
    """

    def work(job: tuple[int, tuple[Mapping[str, str], Firmware]]) -> Budget:
        place, (point, wanted) = job
        budget = measure(point, wanted, tools, Path(folder) / str(place))
        done()
        return budget

    with (
        tempfile.TemporaryDirectory(prefix="colias-firmware-") as folder,
        ThreadPoolExecutor(max(workers, 1)) as pool,
    ):
        try:
            return list(pool.map(work, enumerate(points)))
        except BaseException:
            pool.shutdown(wait=True, cancel_futures=True)
            raise


def label(budget: Budget) -> str:
    """Return what a program is called: its values of the grid's keys, or its main parameters where there is no grid."""
    if budget.point:
        return " ".join(f"{key.partition('.')[2]}={value}" for key, value in budget.point.items())
    network = budget.firmware.network
    sizes = f"D={network.state_bits} LA={network.lamina_bits}"
    return f"n_con={network.n_con} d={network.d} {sizes} {budget.firmware.chip.shape}"
