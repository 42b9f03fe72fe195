"""Build the chip's program: the network's C, the chip's side, a header of parameters, and a linker script."""

from __future__ import annotations

import dataclasses
import re
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import dsnn.native
from dsnn.onboard.fixed import constants
from dsnn.onboard.header import IN_RAM, TABLES, header
from experiments.bench.firmware import elf
from experiments.bench.firmware.settings import ChipSettings, Firmware
from experiments.bench.firmware.toolchain import Compiler
from experiments.bench.run.errors import UsageError, printable

NATIVE = Path(dsnn.native.__file__).parent
CHIP_SIDE = NATIVE / "firmware"
SECTIONS = "sections.ld"
TEST_PROGRAM = ("startup.c", "memory.c", "camera.c", "semihost.c", "counter.c", "answers.c")
SOURCES = (*(CHIP_SIDE / name for name in TEST_PROGRAM), NATIVE / "onboard.c")
CONFIG = "onboard_config.h"

FLASH, MAIN, CORE = "FLASH", "MAIN", "CORE"
ADDRESSES: Mapping[str, int] = {FLASH: 0x0000_0000, MAIN: 0x2000_0000, CORE: 0x2100_0000}
"""Memories of QEMU's board mps2-an386, whose memories are larger than the chip's."""
LARGE = 4 * 1024 * 1024
"""Bytes of each region of the script by which a program is measured that does not fit the chip."""
ALIGNMENT = 8
"""Bytes that the order of sections may cost."""
TABLE_PLACE = '__attribute__((section(".tables")))'
"""What puts the tables that are looked up at random into RAM (``sections.ld``)."""
VARIABLES = 112
"""Bytes of the test program's own variables (``.bss``), by GCC 12.2.1; none of them has a value (``.data``)."""
LINK_TIMEOUT_S = 300.0


@dataclass(frozen=True, slots=True)
class Placement:
    """Place of the network's states and of the robot's own data.

    Parameters
    ----------
    states
        `MAIN` or `CORE`.
    split
        Whether LA and the adaptation's states are a block of their own, in `CORE`.
    robot_core
        Bytes of the robot's own data in `CORE`; the others are in `MAIN`. They are many variables, so they may be
        divided.
    """

    states: str
    split: bool = False
    robot_core: int = 0

    def words(self) -> str:
        """Tell the placement in words, for a table."""
        both = f" and {CORE.lower()}" if self.split else ""
        return f"states {self.states.lower()}{both}, robot's {self.robot_core} B core"


WHOLE, SPLIT = (Placement(MAIN), Placement(CORE)), (Placement(MAIN, split=True),)


@dataclass(frozen=True, slots=True)
class Built:
    """A linked program.

    Parameters
    ----------
    path
        The ELF file.
    sections
        Name -> bytes, of the sections that take memory of the chip.
    placement
        Where states and the robot's data lie.
    over
        Region -> bytes by which the chip's RAM is too small, of the best placement; empty where it was linked into
        the chip's true regions.
    """

    path: Path
    sections: Mapping[str, int]
    placement: Placement
    over: Mapping[str, int]


def memory_script(
    chip: ChipSettings, placement: Placement, addresses: Mapping[str, int] = ADDRESSES, *, large: bool = False
) -> str:
    """Return the text of ``memory.ld``: regions at these ``addresses``, the stack's reserve, the placement."""
    sizes = {FLASH: chip.flash, MAIN: chip.ram_main, CORE: chip.ram_core}
    reserved = {"STACK": chip.stack, "ROBOT_MAIN": chip.robot_ram - placement.robot_core,
                "ROBOT_CORE": placement.robot_core}  # fmt: skip
    lines = [*(f"CHIP_{name} = {size};" for name, size in reserved.items()), "MEMORY", "{"]
    for name, size in sizes.items():
        rights = "rx" if name == FLASH else "rwx"
        length = LARGE if large else size
        lines.append(f"    {name} ({rights}) : ORIGIN = 0x{addresses[name]:08X}, LENGTH = {length}")
    lines += ["}", f'REGION_ALIAS("STATES", {placement.states})', ""]
    return "\n".join(lines)


def build(wanted: Firmware, compiler: Compiler, folder: Path, *, counting: bool = True) -> Built:
    """Compile the test program with a network's parameters, and link it into the chip's memory.

    Parameters
    ----------
    wanted
        Parameters and chip.
    compiler
        From `experiments.bench.firmware.toolchain.compiler`.
    folder
        Where it is built; it is made.
    counting
        Whether instructions are counted stage by stage. Without it the network is as on the robot.

    Returns
    -------
    Built
        Where the RAM is too small, it is linked into larger regions, and says by how much it is over.

    Raises
    ------
    UsageError
        The compiler refuses the sources, or the parameters have no fixed-point form.
    """
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CONFIG).write_text(config(wanted), encoding="ascii")
    problems = []
    for layout in (WHOLE, SPLIT):
        split = layout[0].split
        objects = [_compile(source, wanted.chip, compiler, folder, counting=counting, split=split)
                   for source in SOURCES]  # fmt: skip
        measured = _link(objects, wanted.chip, compiler, folder, layout[0], large=True)
        assert measured is not None
        sizes = elf.sections(measured)
        placement, over = _best(sizes, wanted.chip, layout)
        linked = _link(objects, wanted.chip, compiler, folder, placement, large=False)
        if linked is not None:
            return Built(linked, elf.sections(linked), placement, {})
        problems.append(Built(measured, sizes, placement, over))
    return min(problems, key=lambda problem: sum(problem.over.values()))


def config(wanted: Firmware) -> str:
    """Return the text of `CONFIG`; `UsageError` where the parameters have no fixed-point form."""
    try:
        return header(wanted.shape, wanted.network)
    except ValueError as error:
        raise UsageError(printable(str(error))) from None


def computed(wanted: Firmware) -> tuple[Placement, Mapping[str, int]]:
    """Place a program by sizes that are computed, where there is no compiler to measure them.

    Parameters
    ----------
    wanted
        Parameters and chip.

    Returns
    -------
    Placement
        The one that `build` ends with.
    dict
        Region -> bytes by which the chip's RAM is too small; empty where the program fits.

    Raises
    ------
    ValueError
        The parameters have no fixed-point form.
    """
    problems = []
    for layout in (WHOLE, SPLIT):
        placement, over = _best(computed_sizes(wanted, layout[0].split), wanted.chip, layout)
        if not over:
            return placement, over
        problems.append((placement, over))
    return min(problems, key=lambda problem: sum(problem[1].values()))


def computed_sizes(wanted: Firmware, split: bool) -> dict[str, int]:
    """Return the bytes of the sections that take RAM, as the C files of ``dsnn/native/firmware`` have them.

    ``split`` says whether the states are two blocks (``split.h``).
    """
    rows, columns = wanted.shape
    cells, whole = rows * columns, constants(wanted.shape, wanted.network).state_bytes
    second = sum(_aligned(size) for size in (wanted.network.lamina_bits // 4 * cells, 4 * cells)) if split else 0
    ring = wanted.chip.ring_frames * -(-2 * cells // 4) * 4
    return {".ring": ring, ".tables": table_bytes(wanted), ".states": whole - second, ".second": second,
            ".stack": _aligned(wanted.chip.stack), ".bss": VARIABLES}  # fmt: skip


def table_bytes(wanted: Firmware) -> int:
    """Return the bytes of the tables that lie in RAM: those of 8-bit delayed signals; others are not looked up."""
    fixed = constants(wanted.shape, wanted.network)
    sizes = {"uint8_t": 1, "uint16_t": 2}
    return sum(sizes[TABLES[name]] * len(getattr(fixed, name)) for name in IN_RAM) if fixed.state_bits == 8 else 0


def _aligned(size: int) -> int:
    """Return the bytes of a part of memory, each of which begins at a multiple of 8."""
    return -(-size // 8) * 8


def _best(
    sizes: Mapping[str, int], chip: ChipSettings, among: Sequence[Placement]
) -> tuple[Placement, Mapping[str, int]]:
    """Find the placement that lacks the fewest bytes, with the robot's own data divided, and what each region lacks."""
    divided = [_with_robot(sizes, chip, placement) for placement in among]
    overs = [(placement, {region: -left for region, left in free(sizes, chip, placement).items() if left < 0})
             for placement in divided]  # fmt: skip
    return min(overs, key=lambda problem: sum(problem[1].values()))


def _compile(
    source: Path, chip: ChipSettings, compiler: Compiler, folder: Path, *, counting: bool, split: bool
) -> Path:
    """Return one object file, in which instructions are counted, or the states are two blocks."""
    output = folder / f"{source.stem}.o"
    stages = ("-include", "counter.h", "-DONBOARD_STAGE(i)=counter_stage(i)") if counting else ()
    command = [
        *compiler.command, *compiler.flags, f"-O{chip.optimise}", "-isystem", str(CHIP_SIDE / "include"),
        f"-I{folder}", f"-I{CHIP_SIDE}", f"-I{NATIVE}", f'-DONBOARD_CONFIG_HEADER="{CONFIG}"',
        f"-DONBOARD_IN_RAM={TABLE_PLACE}", f"-DCAMERA_FRAMES={chip.ring_frames}", *stages,
        *(("-DONBOARD_SPLIT",) if split else ()), "-c", str(source), "-o", str(output),
    ]  # fmt: skip
    done = _run(command, folder)
    if done.returncode:
        raise UsageError(f"{compiler.version} refuses {source.name}: {_first_error(done.stderr)}")
    return output


def _link(
    objects: Sequence[Path], chip: ChipSettings, compiler: Compiler, folder: Path, placement: Placement, *, large: bool
) -> Path | None:
    """Return the linked program; ``None`` where a RAM region is too small."""
    output = folder / f"{'large' if large else 'chip'}{'-split' if placement.split else ''}.elf"
    sections = (CHIP_SIDE / SECTIONS).read_text(encoding="ascii")
    script_path = output.with_suffix(".ld")
    script_path.write_text(memory_script(chip, placement, large=large) + sections, encoding="ascii")
    target = [flag for flag in compiler.flags if not flag.startswith(("-W", "-std"))]
    command = [*compiler.command, *target, *compiler.linking, f"-O{chip.optimise}", "-T", str(script_path),
               *map(str, objects), *compiler.libraries, "-o", str(output)]  # fmt: skip
    done = _run(command, folder)
    if done.returncode == 0:
        return output
    if not large and re.search(r"overflowed|will not fit", done.stderr):
        return None
    raise UsageError(f"{compiler.version} does not link: {_first_error(done.stderr)}")


def _with_robot(sizes: Mapping[str, int], chip: ChipSettings, placement: Placement) -> Placement:
    """Return a placement with as much of the robot's own data in the core-coupled RAM as it has room for."""
    left = chip.ram_core - ram(sizes, placement)[CORE] - ALIGNMENT
    return dataclasses.replace(placement, robot_core=max(min(chip.robot_ram, left // 4 * 4), 0))


def free(sizes: Mapping[str, int], chip: ChipSettings, placement: Placement) -> dict[str, int]:
    """Region -> bytes of RAM that sections and the robot's own data leave there; below 0 where it is too small."""
    used = ram(sizes, placement)
    return {MAIN: chip.ram_main - used[MAIN] - (chip.robot_ram - placement.robot_core),
            CORE: chip.ram_core - used[CORE] - placement.robot_core}  # fmt: skip


def ram(sizes: Mapping[str, int], placement: Placement) -> dict[str, int]:
    """Region -> bytes of RAM that the sections take there, the robot's own data aside."""
    used = {MAIN: sizes.get(".data", 0) + sizes.get(".bss", 0) + sizes.get(".ring", 0),
            CORE: sizes.get(".stack", 0) + sizes.get(".second", 0) + sizes.get(".tables", 0)}  # fmt: skip
    used[placement.states] += sizes.get(".states", 0)
    return used


def _run(command: Sequence[str], folder: Path) -> subprocess.CompletedProcess[str]:
    try:
        return subprocess.run(
            command,
            cwd=folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=LINK_TIMEOUT_S,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired:
        raise UsageError(f"{command[0]} did not end within {LINK_TIMEOUT_S:g} s") from None


def _first_error(text: str) -> str:
    lines = [line for line in text.splitlines() if "error" in line] or text.splitlines() or ["it says nothing"]
    return printable(lines[0])
