"""The network on the robot's chip: exported, built, emulated and compared; skipped where a tool is missing."""

from __future__ import annotations

import csv
import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from dsnn.onboard.model import OnboardDSNN
from experiments.bench.firmware import budget, build, check, clips, elf, emulator, settings, table, toolchain
from tests.conftest import Colias
from tests.helpers.firmware import needs_tools

SMALL = "33x24"
SET = ("--set", f"chip.shape={SMALL}")


def colias(*arguments: str, folder: Path) -> subprocess.CompletedProcess[str]:
    return Colias(folder)("firmware", *arguments)


def small(*texts: str) -> settings.Firmware:
    return settings.firmware([f"chip.shape={SMALL}", *texts])


@pytest.fixture(scope="module")
def tools() -> budget.Tools:
    return budget.Tools(toolchain.compiler("gcc"), toolchain.qemu())


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder that ``colias firmware export`` writes, with a budget."""
    folder = tmp_path_factory.mktemp("export")
    done = colias("export", "out", *SET, "--set", "dsnn.n_con=6", folder=folder)
    assert done.returncode == 0, done.stderr
    return folder / "out"


def make(folder: Path, *words: str) -> None:
    done = subprocess.run(["make", "-C", str(folder), *words], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "warning" not in done.stderr


@needs_tools
def test_what_is_exported_compiles_clean_and_answers_as_the_host_does_bit_for_bit(exported, tools):
    """For the robot, for QEMU and for this computer; the Makefile has -std=c99 -Wall -Wextra -Werror."""
    make(exported, "all", "qemu", "host")
    wanted = small("dsnn.n_con=6")
    rows, columns = wanted.shape
    sequences = [
        (name, frames) for name, frames in check.sequences(wanted.shape, None) if not name.startswith("golden")
    ]
    sequences = [(name, frames[:50]) for name, frames in sequences]
    model = OnboardDSNN(wanted.shape, wanted.network)
    with emulator.Emulator(tools.qemu, exported / "build" / "qemu.elf", (rows, columns)) as chip:
        counts, spiking, difference = check.compare(model, chip, sequences, lambda: None)
    assert difference is None and sum(counts.values()) >= 400 and spiking > 50
    frames = dict(sequences)["noise"]
    done = subprocess.run([exported / "build" / "host"], input=frames.tobytes(), capture_output=True, check=True)
    answers = [tuple(map(int, line.split())) for line in done.stdout.decode().splitlines()]
    model.reset()
    assert answers == [check.host(model.step(frame)) for frame in frames]


@needs_tools
def test_the_page_has_the_measured_budget_and_the_robots_memory(exported):
    page = (exported / "README.md").read_text()
    assert "Measured with arm-none-eabi-gcc" in page and "--set dsnn.n_con=6" in page and "states" in page
    robot = (exported / "memory.ld").read_text()
    assert "0x08000000, LENGTH = 2097152" in robot and "0x10000000, LENGTH = 65536" in robot
    assert (exported / "main.c").read_text().count("PLACE") >= 4


@needs_tools
def test_the_ziglang_wheel_compiles_the_exported_folder_too(exported):
    if subprocess.run([sys.executable, "-m", "ziglang", "version"], capture_output=True, check=False).returncode:
        pytest.skip("needs the wheel ziglang: pip install ziglang")
    make(exported, "clean")
    make(exported, "CROSS=zig", f"PYTHON={sys.executable}", "all", "qemu")


@needs_tools
def test_two_budgets_of_one_program_are_equal(tools, tmp_path):
    """Sizes and instruction counts: no number depends on the machine's load."""
    budgets = [budget.measure({}, small(), tools, tmp_path / str(i), 2) for i in range(2)]
    assert table.row(budgets[0]) == table.row(budgets[1])
    assert budgets[0].whole.worst > budgets[0].whole.median > 0


@needs_tools
def test_instructions_grow_with_the_pixels_of_the_frame(tools, tmp_path):
    """Taking luma out of a frame is one loop over its pixels: a count is a line, whose slope is that of a loop."""
    counts = []
    for shape in ("32x16", "32x32", "32x48"):
        chip_budget = budget.measure({}, settings.firmware([f"chip.shape={shape}"]), tools, tmp_path / shape, 2)
        (luma,) = [stage for stage in chip_budget.stages if stage.name == "input"]
        assert luma.median == luma.worst, "the same loop in every frame"
        counts.append(luma.worst)
    steps = np.diff(counts)
    assert abs(steps[1] - steps[0]) <= 2, "to the resolution of the counter"
    assert 5 <= 4 * steps[0] / 512 <= 40, "instructions for four pixels"


@needs_tools
def test_counting_changes_no_answer_and_little_of_the_program(tools, tmp_path):
    wanted = small()
    frames = clips.synthetic(wanted.shape, 8)["noise"]
    answers, text = [], []
    for counting in (True, False):
        built = build.build(wanted, tools.compiler, tmp_path / str(counting), counting=counting)
        text.append(built.sections[".text"])
        with emulator.Emulator(tools.qemu, built.path, wanted.shape) as chip:
            chip_answers = [chip.step(frame) for frame in frames]
        answers.append([answer.values for answer in chip_answers])
    assert answers[0] == answers[1]
    assert abs(text[0] - text[1]) < 2000


@needs_tools
def test_ram_is_that_of_the_linked_program_and_says_by_how_much_it_is_too_small(tools, tmp_path):
    wanted = small()
    built = build.build(wanted, tools.compiler, tmp_path / "fits")
    rows, columns = wanted.shape
    assert built.sections[".ring"] == 3 * 2 * rows * columns and not built.over
    assert built.sections == elf.sections(built.path)
    used = build.ram(built.sections, built.placement)
    main = used["MAIN"] + wanted.chip.robot_ram
    tight = dataclasses.replace(wanted.chip, ram_main=main, ram_core=used["CORE"])
    exact = build.build(settings.Firmware(wanted.network, tight), tools.compiler, tmp_path / "exact")
    assert not exact.over
    short = dataclasses.replace(tight, ram_main=main - 8)
    over = build.build(settings.Firmware(wanted.network, short), tools.compiler, tmp_path / "over")
    assert sum(over.over.values()) == 8
    assert emulator.Emulator(tools.qemu, over.path, wanted.shape).close() is None, "what does not fit is still measured"


@needs_tools
def test_a_wrong_answer_of_the_chip_is_found_and_named(tools, tmp_path):
    """The control: a network with another weight is not equal."""
    wanted = small()
    built = build.build(small("dsnn.w_i=0.8"), tools.compiler, tmp_path)
    with emulator.Emulator(tools.qemu, built.path, wanted.shape) as chip:
        model = OnboardDSNN(wanted.shape, wanted.network)
        _, _, difference = check.compare(model, chip, check.sequences(wanted.shape, None), lambda: None)
    assert difference is not None and difference.host != difference.chip
    assert difference.clip in difference.words() and difference.channel in check.CHANNELS


@needs_tools
def test_a_chip_that_gives_no_answer_is_told_in_one_line(tools, tmp_path):
    wanted = small()
    built = build.build(wanted, tools.compiler, tmp_path)
    with pytest.raises(emulator.EmulatorError, match="built for 33x24 px, not 32x24"):
        emulator.Emulator(tools.qemu, built.path, (24, 32))
    with emulator.Emulator(tools.qemu, built.path, wanted.shape) as chip:
        chip._process.kill()
        chip._process.wait()
        with pytest.raises(emulator.EmulatorError, match="QEMU ended with status"):
            chip.reset()


@needs_tools
def test_the_command_budget_writes_table_and_figure(tmp_path):
    done = colias("budget", *SET, "--over", "dsnn.n_con=4,8", "--out", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "budget.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [row["n_con"] for row in rows] == ["4", "8"]
    assert int(rows[1]["states_bytes"]) > int(rows[0]["states_bytes"])
    assert (tmp_path / "out" / "budget.png").exists()
    assert "arm-none-eabi-gcc" in done.stdout and "time undetermined" in done.stdout
    assert {row["verdict"] for row in rows} == {"memory fits; time undetermined"}


PLACED = {
    (): "two blocks", ("dsnn.n_con=4",): "one block", ("dsnn.n_con=6", "chip.robot_ram=40000"): "two blocks",
    ("dsnn.lamina_bits=16",): "too large", ("dsnn.lamina_bits=16", "chip.ring_frames=2"): "two blocks",
    ("dsnn.state_bits=16",): "too large", ("chip.shape=33x25", "dsnn.n_p=0", "chip.stack=516"): "one block",
    ("chip.ram_main=131072", "chip.ram_core=204800"): "one block",
}  # fmt: skip
"""``--set`` texts -> how the program's states lie in the chip's RAM."""


@pytest.mark.parametrize("texts", PLACED, ids=lambda texts: " ".join(texts) or "defaults")
def test_states_are_placed_without_a_compiler(texts):
    placement, over = build.computed(settings.firmware(texts))
    assert PLACED[texts] == ("too large" if over else "two blocks" if placement.split else "one block")


@needs_tools
@pytest.mark.parametrize("texts", [("dsnn.n_con=4",), ("dsnn.lamina_bits=16",)], ids=" ".join)
def test_computed_sizes_and_places_are_those_of_the_linked_program(texts, tools, tmp_path):
    wanted = settings.firmware(texts)
    built = build.build(wanted, tools.compiler, tmp_path / "build", counting=False)
    assert build.computed(wanted) == (built.placement, built.over)
    computed = build.computed_sizes(wanted, built.placement.split)
    sizes = {name: size for name, size in computed.items() if size or name == ".tables"}
    assert sizes == {name: built.sections.get(name, 0) for name in sizes}
    assert ".data" not in built.sections, "or it would have to be computed too"


@needs_tools
def test_the_tables_lie_in_ram_and_come_there_from_flash(tools, tmp_path):
    """Codes' values are 2 bytes, codes' decays 1 byte of each spacing. A start that copied nothing would answer 0."""
    built = build.build(settings.default(), tools.compiler, tmp_path)
    assert built.sections[".tables"] == 2 * 256 + 8 * 256
    dump = subprocess.run(["arm-none-eabi-objdump", "-h", built.path], capture_output=True, text=True, check=True)
    (line,) = [line.split() for line in dump.stdout.splitlines() if " .tables " in line]
    at, load = int(line[3], 16), int(line[4], 16)
    core = build.ADDRESSES[build.CORE]
    assert core <= at < core + settings.ChipSettings().ram_core and load < settings.ChipSettings().flash


def test_waits_for_tables_in_flash_are_a_load_each(tmp_path):
    """Two look-ups of each of 8 delayed signals of each pixel and pathway; 5 waits of 1 / 180 us."""
    built = build.Built(tmp_path, {}, build.WHOLE[0], {})
    whole = budget.Stage("whole", 10**6, 10**6)

    def budget_with(*texts: str, stack: int = 492) -> budget.Budget:
        return budget.Budget({}, settings.firmware(texts), built, stack, (), whole, "noise", "gcc", "qemu")

    assert budget_with().lookups == 2 * 8 * 2 * 99 * 72
    assert (
        budget_with().waiting_ms(5) == pytest.approx(5 * 228_096 / 180e6 * 1e3) and budget_with().waiting_ms(0) == 0.0
    )
    assert budget_with("dsnn.state_bits=16").waiting_ms(5) == 0.0, "delay states of 16 bits have no tables"
    assert budget_with().verdict == "memory fits; time undetermined"
    assert budget_with("chip.clock_mhz=39").verdict == "memory fits; time too slow", "1.3 million cycles are 33.3 ms"
    assert budget_with("chip.clock_mhz=40").verdict == "memory fits; time undetermined"
    assert budget_with("chip.stack=1440").fits_memory, "492 B, and 4 interrupts of 108 + 128 B: 1,436 B"
    assert budget_with("chip.stack=1432").verdict == "stack 4 B too small; time undetermined"


STACKED_LD = """
MEMORY { F (rx) : ORIGIN = 0, LENGTH = 64K
 R (rwx) : ORIGIN = 0x20000000, LENGTH = 64K }
SECTIONS { .text : { KEEP(*(.vectors)) *(.text*) *(.rodata*) } > F
 .bss : { *(.bss*) . = ALIGN(8); . += 4096; top = .; } > R }
"""


@needs_tools
def test_an_interrupt_stacks_what_the_budget_says(tools, tmp_path):
    """26 words where the stack is at a multiple of 8, and one more where it is not: counted in the emulator."""
    (tmp_path / "s.ld").write_text(STACKED_LD)
    source, program = Path(__file__).parents[2] / "arm" / "stacked.c", tmp_path / "stacked.elf"
    stacked = []
    for misaligned in (0, 4):
        flags = (*tools.compiler.flags, *tools.compiler.linking, "-O1", f"-DMISALIGNED={misaligned}")
        subprocess.run([*tools.compiler.command, *flags, "-T", tmp_path / "s.ld", source, "-o", program], check=True)
        run = [tools.qemu.path, "-M", emulator.BOARD, "-nodefaults", "-display", "none", "-monitor", "none",
               "-semihosting-config", "enable=on,target=native", "-kernel", program]  # fmt: skip
        stacked.append(subprocess.run(run, check=False, timeout=60, capture_output=True).returncode)
    assert stacked == [4 * 26, 4 * 26 + 4] and max(stacked) == settings.STACKED


@needs_tools
def test_an_export_without_tools_links_where_one_with_them_does(tmp_path, monkeypatch):
    """The paper's N_con = 8 has room in two blocks alone."""
    with monkeypatch.context() as patched:
        patched.setenv("PATH", "")
        done = colias("export", "out", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "out" / "README.md").read_text()
    assert "Not measured" in page and "-DONBOARD_SPLIT" in page and "does not fit" not in page
    make(tmp_path / "out", "all")
    sizes = elf.sections(tmp_path / "out" / "build" / "robot.elf")
    assert sizes[".second"] == build.computed_sizes(settings.default(), split=True)[".second"]


def test_an_export_without_tools_says_what_does_not_fit(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    done = colias("export", "out", "--set", "dsnn.state_bits=16", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "the program does not fit the RAM" in (tmp_path / "out" / "README.md").read_text()
