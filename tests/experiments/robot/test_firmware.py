"""The network on the robot's chip: exported, built, emulated and compared; skipped where a tool is missing."""

import dataclasses
import subprocess
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from experiments.robot import export, firmware
from tests.helpers.firmware import needs_tools

SMALL = {"chip.columns": "33", "chip.rows": "24"}
GOLDEN = Path(__file__).parents[2] / "golden"

pytestmark = needs_tools


def make(folder: Path, *words: str) -> None:
    done = subprocess.run(["make", "-C", folder, *words], capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0 and "warning" not in done.stderr, done.stderr


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("export") / "out"
    export.export(firmware.program(SMALL), folder, SMALL)
    return folder


def test_what_is_exported_compiles_clean_and_responds_as_the_host_does_bit_for_bit(exported):
    """For the robot, for QEMU and for this computer; the Makefile has -std=c99 -Wall -Wextra -Werror."""
    make(exported, "all", "qemu", "host")
    program = firmware.program(SMALL)
    with closing(firmware.Emulator(exported / "build" / "qemu.elf")) as running:
        table = firmware.compare(program, running, list(firmware.clips((24, 33), 50).items()))
    assert not firmware.differing(table).height and (table["hs_spikes"] != 0).sum() > 50
    noise = table.filter(clip="noise").select(firmware.CHANNELS)
    frames = firmware.clips((24, 33), 50)["noise"]
    done = subprocess.run([exported / "build" / "host"], input=frames.tobytes(), capture_output=True, check=True)
    assert [tuple(map(int, line.split())) for line in done.stdout.decode().splitlines()] == noise.rows()


def test_the_chip_responds_to_golden_clips_as_the_host_does_at_full_size():
    """Tables of 8-bit delay states come from flash into RAM: a start that copied nothing would respond 0."""
    clips = [(path.stem, np.load(path)["frames"][:60]) for path in sorted(GOLDEN.glob("right_*.npz"))]
    clips = [(name, frames) for name, frames in clips if frames.shape[1:] == (72, 99)]
    program = firmware.program()
    with firmware.emulated(program) as (running, sizes):
        table = firmware.compare(program, running, [(name, frames.astype(np.uint8)) for name, frames in clips])
    assert sizes[".tables"] == 2 * 256 + 8 * 256  # the codes' values, and their decays of eight spacings
    assert not firmware.differing(table).height and (table["hs_spikes"] != 0).sum() > 10


def test_a_wrong_response_of_the_chip_is_found():
    """The control: a network with another weight is not equal."""
    with firmware.emulated(firmware.program(SMALL | {"dsnn-onboard.w_i": "0.8"})) as (running, _):
        table = firmware.compare(firmware.program(SMALL), running, list(firmware.clips((24, 33), 20).items()))
    first = firmware.differing(table).row(0, named=True)
    assert any(first[name] != first[f"{name}_host"] for name in firmware.CHANNELS)


def test_two_budgets_of_one_program_are_equal_and_that_of_the_paper_is_the_one_known():
    """Sizes and counts of instructions: none depends on the machine's load. The default has 2,808 B left, as ever."""
    assert firmware.measure(firmware.program(SMALL)) == firmware.measure(firmware.program(SMALL))
    row = firmware.measure(firmware.program(), 2)
    assert row["left"] - firmware.ChipSettings().robot_ram == 2808 and row["memory"] == "fits"
    assert sum(row[name] for name in (*firmware.RAM, "left")) == 256 * 1024
    assert (row["states"], row["ring"]) == (195_464, 3 * 2 * 99 * 72)


def test_a_budget_is_of_the_frame_that_takes_longest():
    program = firmware.program(SMALL)
    with firmware.emulated(program) as (running, _):
        whole = firmware.counts(running, (24, 33), 6)["whole"]
    assert firmware.measure(program, 6)["whole"] == whole.max() > whole.min()


def test_a_budget_says_which_memory_is_too_small_and_by_how_much():
    network, settings = firmware.program(SMALL)
    row = firmware.measure((network, settings), 1)
    left = int(row["left"])
    for more, memory in ((0, "fits"), (8, "lacks RAM")):
        tight = dataclasses.replace(settings, robot_ram=left + more)
        again = firmware.measure((network, tight), 1)
        assert (again["over"], again["memory"]) == (more, memory)
    tight = dataclasses.replace(settings, stack=row["stack_used"] + 943, flash=4096)
    assert firmware.measure((network, tight), 1)["memory"] == "lacks flash, stack"
