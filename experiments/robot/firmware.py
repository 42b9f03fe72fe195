"""The chip's program: built, measured in the emulator, and compared there with the network on this computer.

A cross compiler builds it, and QEMU runs what that has built. What a board sends on its serial line becomes a log:
``dsnn/native/firmware/record.h`` has the form of its records, ``measure_main.c`` the list of them.
"""

import binascii
import re
import struct
import subprocess
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
import numpy.typing as npt
import polars as pl
from polars import selectors as cs
from pydantic import Field

import dsnn.native
from dsnn.field_docs import parameters, unit
from dsnn.onboard.header import header
from dsnn.onboard.model import OnboardDSNN
from dsnn.onboard.params import OnboardParams
from experiments.base.errors import UsageError, as_usage_error
from experiments.base.streams import stream
from experiments.robot.logs import ROBOT, SIMULATION
from experiments.settings.settings import in_sections

GCC, SIZE, QEMU = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
# Freestanding: there is no C library. Even so memcpy of a few bytes is an instruction, by the compiler's own knowledge
# of it (-fbuiltin); what is longer calls memory.c.
COMPILER = (
    GCC, "-O3", "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffreestanding", "-fbuiltin", "-fno-common",
    "-ffunction-sections", "-fdata-sections", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables", "-nostdlib",
    "-Wl,--gc-sections", "-mthumb", "-mfloat-abi=soft", "-mcpu=cortex-m4", "-fno-tree-loop-distribute-patterns",
    "-nostartfiles",
)  # fmt: skip
"""Command of the C compiler for the chip."""

SHIFT = 8
"""``-icount shift=``: an instruction lasts 2^8 ns of the board's time. It changes no count, only how finely the board's
25 MHz timer tells them: at 0 in steps of 40 instructions, at 8 one by one, 6.4 ticks each."""
TICKS_AN_INSTRUCTION = 2**SHIFT / 40.0
_HELLO, _FRAME, _RESET, _STACK = (struct.pack("<I", word) for word in (1, 2, 3, 4))
Q15 = 32768.0
"""A potential of 1 in the chip's answers."""
STAGES = 12
KNOWN, KNOWN_ERROR = 4097, 4
"""Instructions of the test program's known loop, with the one that loads its number, and how far a count may be off."""


class Emulator:
    """The test program in QEMU. It ends with ``close``, or when this process ends, as its input ends then.

    Parameters
    ----------
    elf
        The linked program.

    Raises
    ------
    UsageError
        This QEMU does not count instructions one by one.
    """

    def __init__(self, elf: Path) -> None:
        command = [
            QEMU, "-M", "mps2-an386", "-nodefaults", "-display", "none", "-serial", "none", "-monitor", "none",
            "-icount", f"shift={SHIFT},sleep=off", "-semihosting-config", "enable=on,target=native",
            "-kernel", str(elf),
        ]  # fmt: skip
        pipe = subprocess.PIPE
        self._process: Any = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe)
        *_, self._cost, known = self._ask(_HELLO, "<7I")
        counted = (known - self._cost) / TICKS_AN_INSTRUCTION
        if abs(counted - KNOWN) > KNOWN_ERROR:
            self.close()
            raise UsageError(f"this {QEMU} counts {counted:.0f} instructions of {KNOWN}: no count can be had of it")

    def step(self, frame: npt.NDArray[np.uint8]) -> tuple[list[int], npt.NDArray[np.float64]]:
        """Show the next frame, (R, C).

        Returns
        -------
        list of int
            hs and vs in Q15, and their spikes.
        ndarray
            Instructions of each stage, (STAGES,), the cost of counting taken off; 0 where a stage did not run.
        """
        numbers = self._ask(_FRAME + frame.tobytes(), f"<4i{2 * STAGES}I")
        ticks, calls = np.array(numbers[4:], np.float64).reshape(2, STAGES)
        return list(numbers[:4]), np.maximum((ticks - self._cost * calls) / TICKS_AN_INSTRUCTION, 0.0)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._ask(_RESET, "<I")

    def stack_bytes(self) -> int:
        """Return the bytes of the stack used so far: its high-water mark, by a painted pattern."""
        return self._ask(_STACK, "<I")[0]

    def close(self) -> None:
        """End the program and its process."""
        self._process.kill()
        self._process.communicate()

    def _ask(self, message: bytes, form: str) -> tuple[int, ...]:
        self._process.stdin.write(message)
        self._process.stdin.flush()
        answer = self._process.stdout.read(struct.calcsize(form))
        if len(answer) < struct.calcsize(form):
            raise RuntimeError(f"{QEMU} has ended: {self._process.stderr.read().decode(errors='replace')}")
        return struct.unpack(form, answer)


NATIVE = Path(dsnn.native.__file__).parent
CHIP_SIDE = NATIVE / "firmware"
SOURCES = (
    *(CHIP_SIDE / f"{name}.c" for name in ("startup", "memory", "camera", "semihost", "counter", "answers")),
    NATIVE / "onboard.c",
)
CONFIG = "onboard_config.h"
TABLE_PLACE = '__attribute__((section(".tables")))'
"""What puts the tables that are looked up at random into RAM (``sections.ld``): each load from flash would wait."""
QEMU_MEMORY = {"FLASH": (0x0000_0000, 2**22), "MAIN": (0x2000_0000, 2**22), "CORE": (0x2100_0000, 2**22)}
"""Region -> address and bytes on QEMU's board mps2-an386. It has more than the chip: what is too large runs too."""
PURPOSES = {".states": "MAIN", ".ring": "MAIN", ".data": "MAIN", ".bss": "MAIN", ".second": "CORE", ".tables": "CORE",
            ".stack": "CORE"}  # fmt: skip
"""Section of the linked program -> the RAM region that it lies in. LA and the adaptation's states are ``.second``."""
CHANNELS = ("hs", "vs", "hs_spikes", "vs_spikes")
COUNTED, COMPARED = 16, 143
"""Frames of each clip that instructions are counted in, and that are compared: over 1,000 in all clips. The slowest
state of the network's work, the adaptation, is at its level after 10."""
Frames = npt.NDArray[np.uint8]


MODEL, CHIP = "dsnn-onboard", "chip"
RAM = ("states", "tables", "ring", "variables", "stack")
"""Parts of a budget's RAM."""
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


def program(values: Mapping[str, Any] = MappingProxyType({})) -> Program:
    """Return a program with ``values`` by key; `UsageError` for what is not legal."""
    network, chip = in_sections(values, sections()).values()
    return network, chip


def memory_script(chip: ChipSettings, memory: Mapping[str, tuple[int, int]] = QEMU_MEMORY) -> str:
    """Return the text of ``memory.ld``: the regions with their addresses and sizes, and the stack's reserve."""
    regions = [f"    {name} ({'rx' if name == 'FLASH' else 'rwx'}) : ORIGIN = 0x{address:08X}, LENGTH = {size}"
               for name, (address, size) in memory.items()]  # fmt: skip
    return "\n".join([f"CHIP_STACK = {chip.stack};", "MEMORY", "{", *regions, "}", ""])


def config(program: Program) -> str:
    """Return the text of `CONFIG`; `UsageError` where the parameters have no fixed-point form."""
    network, chip = program
    with as_usage_error():
        return header(chip.shape, network)


def build(program: Program, folder: Path) -> Path:
    """Compile and link the test program in a folder, and return the ELF file.

    Raises
    ------
    UsageError
        The compiler refuses the sources, or the parameters have no fixed-point form.
    """
    _, chip = program
    (folder / CONFIG).write_text(config(program), encoding="ascii")
    sections = (CHIP_SIDE / "sections.ld").read_text(encoding="ascii")
    (folder / "chip.ld").write_text(memory_script(chip) + sections, encoding="ascii")
    done = subprocess.run(
        [*COMPILER, "-isystem", str(CHIP_SIDE / "include"), f"-I{folder}", f"-I{CHIP_SIDE}", f"-I{NATIVE}",
         f'-DONBOARD_CONFIG_HEADER="{CONFIG}"', f"-DONBOARD_IN_RAM={TABLE_PLACE}", "-DONBOARD_SPLIT",
         f"-DCAMERA_FRAMES={chip.ring_frames}", "-include", "counter.h", "-DONBOARD_STAGE(i)=counter_stage(i)",
         "-T", "chip.ld", *map(str, SOURCES), "-lgcc", "-o", "chip.elf"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode:
        raise UsageError(f"the compiler refuses the program: {done.stderr}")
    return folder / "chip.elf"


def elf_sections(path: Path) -> dict[str, int]:
    """Return the bytes of each section of an ELF file."""
    listed = subprocess.run([SIZE, "-A", path], capture_output=True, text=True, check=True).stdout
    return {name: int(size) for name, size in re.findall(r"^(\.\S+) +(\d+) ", listed, re.MULTILINE)}


@contextmanager
def emulated(program: Program) -> Iterator[tuple[Emulator, dict[str, int]]]:
    """Build a program and start it in QEMU; yield it with the sizes of its sections."""
    with tempfile.TemporaryDirectory(prefix="colias-firmware-") as folder:
        elf = build(program, Path(folder))
        with closing(Emulator(elf)) as chip:
            yield chip, elf_sections(elf)


def clips(shape: tuple[int, int], length: int) -> dict[str, Frames]:
    """Return clips that drive the network from no work at all to all that it may have.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    length
        Frames of each clip.

    Returns
    -------
    dict of str to ndarray
        Name -> (T, R, C) uint8. ``still``: nothing changes. ``noise``: every pixel is drawn anew. ``pixel flicker``:
        every pixel is 0 or 255, drawn anew. ``field flicker`` and ``board flicker``: all pixels, or the two halves of
        a chequerboard, change from 0 to 255 at every frame. ``grating``: black and white bars of 4 px, moving by 2 px
        a frame. ``crossing``: a dark square passes on noise of 8 grey levels.
    """
    rows, columns = shape
    draw = stream("firmware.clips", 0)
    times = np.arange(length)[:, None, None]
    y, x = np.mgrid[:rows, :columns]
    white = np.uint8(255)
    crossing = draw.integers(180, 188, (length, rows, columns), dtype=np.uint8)
    side = max(rows // 3, 2)
    for time in range(length):
        left = (2 * time) % columns
        crossing[time, side : 2 * side, left : left + side] = 20
    return {
        "still": np.full((length, rows, columns), 128, np.uint8),
        "noise": draw.integers(0, 256, (length, rows, columns), dtype=np.uint8),
        "pixel flicker": draw.integers(0, 2, (length, rows, columns), dtype=np.uint8) * white,
        "field flicker": np.broadcast_to((times % 2).astype(np.uint8), (length, rows, columns)) * white,
        "board flicker": ((times + x + y) % 2).astype(np.uint8) * white,
        "grating": (((x + 0 * y - 2 * times) // 4) % 2).astype(np.uint8) * white,
        "crossing": crossing,
    }


def counts(chip: Emulator, shape: tuple[int, int], length: int = COUNTED) -> pl.DataFrame:
    """Count instructions: a row per frame of the clips, a column per stage and one for the ``whole`` frame."""
    text = (NATIVE / "onboard.h").read_text(encoding="utf-8").replace("\\\n", " ")
    names, rows = re.findall(r'"(\w+)"', text.partition("#define ONBOARD_STAGE_NAMES")[2].splitlines()[0]), []
    for clip, frames in clips(shape, length).items():
        chip.reset()
        for frame in frames:
            counted = chip.step(frame)[1]
            rows.append((clip, *counted[: len(names)], counted[-1]))
    table = pl.DataFrame(rows, ["clip", *names, "camera's luma"], orient="row")
    return table.with_columns(whole=pl.sum_horizontal(pl.exclude("clip"))).with_columns(cs.float().round().cast(int))


def measure(program: Program, length: int = COUNTED) -> dict[str, Any]:
    """Build a program and measure what it takes of the chip.

    Parameters
    ----------
    program
        The program.
    length
        Frames of each clip.

    Returns
    -------
    dict
        A row of the budget: parameters, bytes by purpose, what is ``over`` and what is ``left`` for the robot, the
        instructions of the worst frame, and the interval of its time.
    """
    network, chip = program
    with emulated(program) as (running, sizes):
        table, used = counts(running, chip.shape, length), running.stack_bytes()
    regions = {"MAIN": chip.ram_main, "CORE": chip.ram_core}
    for section, region in PURPOSES.items():
        regions[region] -= sizes.get(section, 0)
    room = sum(max(left, 0) for left in regions.values())
    over = sum(max(-left, 0) for left in regions.values()) + max(chip.robot_ram - room, 0)
    flash = sum(sizes.get(name, 0) for name in (".text", ".ARM.exidx", ".data", ".tables"))
    stack = used + chip.interrupt_stack
    worst = table.row(int(table["whole"].arg_max() or 0), named=True)
    least, most = (round(worst["whole"] * cycles / (1000.0 * chip.clock_mhz), 2) for cycles in CYCLES)
    missing = {"RAM": over, "flash": flash - chip.flash, "stack": stack - chip.stack}
    short = [name for name, size in missing.items() if size > 0]
    return {
        "n_con": network.n_con, "d": network.d, "state_bits": network.state_bits, "lamina_bits": network.lamina_bits,
        "states": sizes[".states"] + sizes[".second"], "tables": sizes.get(".tables", 0), "ring": sizes[".ring"],
        "variables": sizes.get(".data", 0) + sizes.get(".bss", 0),
        "stack": sizes[".stack"], "stack_used": used, "left": sum(regions.values()), "over": over, "flash": flash,
        "memory": f"lacks {', '.join(short)}" if short else "fits", **worst, "ms_least": least, "ms_most": most,
    }  # fmt: skip


def groups(row: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the columns of a budget that are numbers by what they count, with its unit."""
    network, memory = ["n_con", "d", "state_bits", "lamina_bits"], [*RAM, "stack_used", "left", "over"]
    time = ["ms_least", "ms_most"]
    rest = [name for name in row if name not in (*network, *memory, *time, "flash", "memory", "clip")]
    return {"network": network, "RAM (B)": memory, "flash (B)": ["flash"], "instructions": rest, "time (ms)": time}


def compare(program: Program, chip: Emulator, shown: Sequence[tuple[str, Frames]]) -> pl.DataFrame:
    """Show clips to the chip and to the network on this computer, each after a reset.

    Returns
    -------
    polars.DataFrame
        A row per frame: clip, frame, the chip's HS and VS in Q15 and their spikes, and the host's as ``hs_host``, ...
    """
    network, settings = program
    model = OnboardDSNN(settings.shape, network)
    rows = []
    for name, frames in shown:
        model.reset()
        chip.reset()
        for place, frame in enumerate(frames):
            host = model.step(frame)
            values = round(host.hs * Q15), round(host.vs * Q15), host.hs_spikes, host.vs_spikes
            rows.append((name, place, *chip.step(frame)[0], *values))
    return pl.DataFrame(rows, ["clip", "frame", *CHANNELS, *(f"{name}_host" for name in CHANNELS)], orient="row")


def differing(table: pl.DataFrame) -> pl.DataFrame:
    """Return the rows of `compare` in which chip and host differ."""
    return table.filter(pl.any_horizontal(pl.col(name) != pl.col(f"{name}_host") for name in CHANNELS))


def check(program: Program, length: int = COMPARED) -> pl.DataFrame:
    """Build a program and `compare` it on all clips, the noise once more at the end."""
    _, chip = program
    shown = clips(chip.shape, length)
    with emulated(program) as (running, _):
        return compare(program, running, [*shown.items(), ("noise again", shown["noise"])])


NONE = "-"
"""What stands where a board cannot tell."""
BOARD = ("version", "board", "columns", "rows", "trials", "frames", "frame_us", "clock_hz", "flash_waits", "counter")
FRAME = ("trial", "frame", "hs", "vs", "hs_spikes", "vs_spikes", "cycles")
FIELDS = {"board": BOARD, "frame": FRAME, "stack": ("bytes",), "end": ("sent",)}
"""Record -> its fields."""
KINDS = {**dict.fromkeys(("board", "counter"), str), **dict.fromkeys(("clock_hz", "flash_waits", "cycles"), int | None)}
"""Field -> what it is; the others are whole numbers."""
_WHOLE = re.compile(r"-?\d{1,10}")
_SERIAL = re.compile(rb"\$([a-z0-9,-]*)\*([0-9A-F]{4})\r?")


def crc(content: bytes) -> int:
    """CRC-16 of a record's content: polynomial 0x1021, from 0xFFFF."""
    return binascii.crc_hqx(content, 0xFFFF)


def decode(data: bytes) -> tuple[pl.DataFrame, Mapping[str, Any], int]:
    """Decode a capture of the serial line. A line that is damaged, or of another firmware, is skipped.

    Parameters
    ----------
    data
        The bytes as they came. Where the program ran several times, as after a reset of the board, a frame counts as it
        was sent last; where another program ran, the frames before it are dropped.

    Returns
    -------
    polars.DataFrame
        A row per frame: potentials in Q15, spikes, and cycles, null where none were counted.
    dict
        Fields of the records ``board`` and ``stack``; empty where these are lost.
    int
        Number of lines that were skipped.
    """
    frames, board, skipped = [], dict[str, Any](), 0
    for line in filter(bytes.strip, data.split(b"\n")):
        match = _SERIAL.fullmatch(line)
        kind, *texts = match[1].decode().split(",") if match else [""]
        values = [None if text == NONE else int(text) if _WHOLE.fullmatch(text) else text for text in texts]
        record = dict(zip(names := FIELDS.get(kind, ()), values, strict=False))
        ours = 0 < len(names) == len(values) and all(isinstance(record[name], KINDS.get(name, int)) for name in names)
        if match is None or int(match[2], 16) != crc(match[1]) or not ours:
            skipped += 1
        elif kind == "frame":
            frames.append(record)
        elif kind != "end":
            if kind == "board" and any(board.get(name, value) != value for name, value in record.items()):
                frames, board = [], {}  # another program was flashed meanwhile
            board |= record
    table = pl.DataFrame(frames, dict.fromkeys(FRAME, pl.Int64))
    return table.unique(["trial", "frame"], keep="last").sort("trial", "frame"), board, skipped


def log_of(frames: pl.DataFrame, board: Mapping[str, Any]) -> pl.DataFrame:
    """Return the frames as a log that ``colias import`` reads: the robot's where a board says so that is no emulator.

    Where the board's record is lost, frames came 30 a second.
    """
    origin = SIMULATION if board.get("board", "qemu-").startswith("qemu-") else ROBOT
    time_s = (pl.col("frame") + 1) * board.get("frame_us", 33_333) / 1e6
    return frames.select(
        "trial", model=pl.lit(MODEL), origin=pl.lit(origin), time_s=time_s.round(6),
        hs=pl.col("hs") / Q15, hs_spikes="hs_spikes", vs=pl.col("vs") / Q15, vs_spikes="vs_spikes",
    )  # fmt: skip
