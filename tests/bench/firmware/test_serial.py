"""The program that measures itself: its records in C and Python, its run in the emulator, what a damaged line costs."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

import experiments
from dsnn.onboard.model import OnboardDSNN
from experiments.bench.cli import main
from experiments.bench.firmware import build, clips, emulator, export, serial, settings, toolchain
from experiments.bench.run.errors import UsageError
from tests.helpers.firmware import needs_tools
from tests.helpers.native_cases import COMPILER, NATIVE, SANITIZED, STRICT

ARM = Path(__file__).parents[2] / "arm"
SIDE = NATIVE / "firmware"
SET = ("chip.shape=33x24", "dsnn.n_con=6")
TRIALS, FRAMES = 2, 3
WORST = 4_000_002
"""The most cycles of what is sent."""
WORD = re.compile(r"[a-z0-9-]+")
LONGEST = 128
"""Characters of a line, its end included: ``RECORD_LONGEST``."""
CHECK_OF_NINE_DIGITS = 0x29B1
"""CRC-16/CCITT-FALSE of "123456789", as catalogues of such sums have it."""


def line(kind: str, *fields: int | str | None) -> bytes:
    """A record as ``record.c`` writes it; ``None`` is no value. What that refuses is a ``ValueError``."""
    texts = [serial.NONE if value is None else str(value) for value in (kind, *fields)]
    content = ",".join(texts).encode("ascii")
    whole = b"$%b*%04X\r\n" % (content, serial.crc(content))
    if not all(map(WORD.fullmatch, texts)) or len(whole) > LONGEST:
        raise ValueError(f"record {kind}: too long, or a word with another character than a-z, 0-9 and -")
    return whole


def sent(counter: str = "dwt", name: str = "stm32f427", clock: int | None = 180_000_000) -> list[bytes]:
    """What a board sends: made up."""
    first = WORST - FRAMES + 1
    lines = [line("board", 1, name, 33, 24, TRIALS, FRAMES, 33_333, clock, 5, counter)]
    lines += [
        line(
            "frame", trial, frame, 10 * frame, -20 * trial, frame, -trial, first + frame if counter == "dwt" else None
        )
        for trial in range(TRIALS) for frame in range(FRAMES)
    ]  # fmt: skip
    return [*lines, line("stack", 604), line("end", TRIALS * FRAMES)]


def test_the_checksum_is_the_one_of_the_catalogues():
    assert serial.crc(b"123456789") == CHECK_OF_NINE_DIGITS


@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
def test_records_in_c_are_those_in_python_under_the_sanitizers(tmp_path):
    """Random fields, the extremes, and what does not fit; ``make fuzz`` has more of them."""
    program = tmp_path / "records"
    sources = [ARM / "record_cases.c", SIDE / "record.c"]
    subprocess.run([COMPILER, *STRICT, *SANITIZED, f"-I{SIDE}", *sources, "-o", program], check=True)
    rng = np.random.default_rng(0)
    steps, expected = [], []
    for _ in range(int(os.environ.get("COLIAS_FUZZ_CASES", "200"))):
        fields: list[int | str | None] = []
        steps.append("begin frame")
        for _ in range(int(rng.integers(0, 14))):
            kind = rng.choice(["signed", "unsigned", "word", "none"])
            if kind == "word":
                value = "".join(
                    rng.choice(list("az09-A,$*" if rng.random() < 0.1 else "az09-"), int(rng.integers(0, 9)))
                )
            else:
                low, high = (-(2**31), 2**31 - 1) if kind == "signed" else (0, 2**32 - 1)
                value = int(rng.choice([low, high, 0, int(rng.integers(low, high, endpoint=True))]))
            fields.append(None if kind == "none" else value)
            steps.append(kind if kind == "none" else f"{kind} {value}")
        steps.append("end")
        try:
            expected.append(line("frame", *fields))
        except ValueError:
            expected.append(b"not legal\n")
    done = subprocess.run([program], input="\n".join(steps).encode(), capture_output=True, check=True)
    assert done.stdout == b"".join(expected)
    assert 0 < expected.count(b"not legal\n") < len(expected)


EXPECTED = [(t, f, 10 * f, -20 * t, f, -t, WORST - FRAMES + 1 + f) for t in range(TRIALS) for f in range(FRAMES)]
"""Rows of what is sent."""


def test_what_was_sent_is_decoded():
    capture = serial.decode(b"".join(sent()))
    assert (capture.damaged, capture.missing, capture.stack) == (0, 0, 604)
    values = (1, "stm32f427", 33, 24, TRIALS, FRAMES, 33_333, 180_000_000, 5, "dwt")
    assert capture.board == dict(zip(serial.BOARD, values, strict=True))
    assert capture.frames.rows() == EXPECTED


DAMAGED = {
    "noise before the first line": b"\xff\x00\xfeboot\r\n",
    "another checksum": b"$frame,0,0,0,0,0,0,1*0000\r\n",
    "no record": b"$" + b"a" * 500 + b"\n",
    "an unknown record": line("colour", 3),
    "too few fields": line("frame", 0, 0, 1),
}


@pytest.mark.parametrize("what", DAMAGED)
def test_a_damaged_line_costs_nothing_else(what):
    lines = sent()
    lines.insert(1, DAMAGED[what])
    capture = serial.decode(b"".join(lines))
    assert capture.damaged == 1 and capture.missing == 0 and capture.frames.rows() == EXPECTED


@given(st.integers(0, TRIALS * FRAMES + 2), st.data())
def test_a_flipped_bit_costs_its_own_record_alone(place, data):
    """CRC-16 tells every single flipped bit of a record; one that makes a line's end makes two damaged lines."""
    lines = sent()
    content = bytearray(lines[place])
    content[data.draw(st.integers(0, len(content) - 3))] ^= 1 << data.draw(st.integers(0, 7))
    lines[place] = bytes(content)
    capture = serial.decode(b"".join(lines))
    assert capture.damaged and bool(capture.board) == (place != 0)
    assert capture.frames.rows() == [row for index, row in enumerate(EXPECTED, 1) if index != place]


@given(st.binary(max_size=600))
def test_any_bytes_are_decoded(data):
    assert not serial.decode(data).frames.height


def test_missing_frames_are_counted_and_of_several_runs_the_fullest_is_taken():
    begun, whole = b"".join(sent()[:3]), b"".join(sent())
    assert serial.decode(begun + whole).frames.rows() == EXPECTED
    assert serial.decode(whole + begun).frames.rows() == EXPECTED
    assert (serial.decode(begun).frames.height, serial.decode(begun).missing) == (2, 4)


def test_cycles_decide_about_the_time_and_none_are_made_up(tmp_path):
    """4,000,002 cycles are 22.22 ms at 180 MHz and 66.67 ms at 60 MHz; a frame has 33.33 ms."""
    for clock, verdict in ((180_000_000, "22.22 ms of 33.33 at 180 MHz: in time"),
                           (60_000_000, "66.67 ms of 33.33 at 60 MHz: late")):  # fmt: skip
        text = "\n".join(serial.summary(serial.decode(b"".join(sent(clock=clock)))))
        assert "4,000,002 in the worst frame, 2 of trial 0" in text and verdict in text
    capture = serial.decode(b"".join(sent("none", "qemu-mps2-an386", None)))
    assert "cycles: not measured; time undetermined" in serial.summary(capture)
    serial.write(capture, tmp_path)
    assert pl.read_csv(tmp_path / serial.CYCLES)["cycles"].null_count() == TRIALS * FRAMES


@pytest.mark.parametrize(("lost", "name", "origin"), [
    (False, "stm32f427", "robot"), (False, "qemu-mps2-an386", "simulation"), (True, "stm32f427", "simulation"),
])  # fmt: skip
def test_a_log_is_the_robots_only_where_a_board_says_so(lost, name, origin, tmp_path):
    serial.write(serial.decode(b"".join(sent(name=name)[lost:])), tmp_path)
    assert set(pl.read_csv(tmp_path / serial.LOG)["origin"]) == {origin}


def test_the_command_counts_damaged_lines_and_writes_what_is_whole(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = sent()
    lines[3] = lines[3].replace(b"frame", b"frbme")
    Path("serial.txt").write_bytes(b"".join(lines))
    assert main.command(["firmware", "decode", "serial.txt", "--out", "out"]) == 1
    assert pl.read_csv("out/log.csv").height == TRIALS * FRAMES - 1
    Path("empty").write_bytes(b"")
    with pytest.raises(UsageError, match="no frame is whole"):
        main.command(["firmware", "decode", "empty", "--out", "other"])
    assert not Path("other").exists()


@needs_tools
def test_the_frames_shown_have_the_most_instructions_of_all_golden_frames(tmp_path):
    """Cells with an F stand for the work; the emulator counts it. Within 1 % of the golden clips' worst frame."""
    wanted = settings.firmware(SET)
    built = build.build(wanted, toolchain.compiler("gcc"), tmp_path)
    worst_clips, most = clips.worst(wanted), {}
    assert len(worst_clips) == 3 and sum(name.startswith("golden") for name in worst_clips) == 2
    with emulator.Emulator(toolchain.qemu(), built.path, wanted.shape) as chip:
        for name, frames in {**clips.golden(wanted.shape), **{f"shown {n}": f for n, f in worst_clips.items()}}.items():
            chip.reset()
            most[name] = max(chip.step(frame).instructions.sum() for frame in frames)
    golden, chosen = (max(most[name] for name in most if name.startswith(kind)) for kind in ("golden", "shown golden"))
    assert chosen >= 0.99 * golden


@needs_tools
def test_the_program_that_measures_itself_answers_as_the_host_does_bit_for_bit(tmp_path, monkeypatch):
    """Exported, built, run in the emulator; its serial line decoded and imported beside the host's network."""
    monkeypatch.chdir(tmp_path)
    wanted = settings.firmware(SET)
    export.export(wanted, Path("out"), SET, "not asked")
    done = subprocess.run(["make", "-C", "out", "measure", "serial"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert main.command(["firmware", "decode", "out/build/serial.txt", "--out", "decoded"]) == 0
    decoded = serial.decode(Path("out/build/serial.txt").read_bytes())
    assert (decoded.damaged, decoded.missing, decoded.frames["cycles"].count()) == (0, 0, 0)
    model, expected = OnboardDSNN(wanted.shape, wanted.network), []
    for trial, frames in enumerate(clips.worst(wanted).values()):
        model.reset()
        answers = [model.step(frame) for frame in frames]
        expected += [(trial, i, a.hs, a.vs, a.hs_spikes, a.vs_spikes) for i, a in enumerate(answers)]
    answers = decoded.frames.drop("cycles").with_columns(pl.col("hs", "vs") / 32768)
    assert answers.rows() == expected
    page = Path("out/README.md").read_text()
    (command,) = [text for text in page.splitlines() if text.startswith("colias import ")]
    folder = Path("out")
    shutil.move("decoded", folder / "measured")
    monkeypatch.chdir(folder)
    assert main.command([*command.split()[1:], "--out", "run", "--quiet"]) == 0
    rows: dict[str, list[tuple[object, ...]]] = {}
    for row in experiments.load("run").frames.to_dicts():
        values = row["trial"], row["frame"], row["hs"], row["vs"], row["hs_spikes"], row["vs_spikes"]
        rows.setdefault(row["model"], []).append(values)
    assert rows["dsnn-onboard"] == rows["dsnn-onboard@frames"] == expected
    assert sum(bool(answer[4]) for answer in expected) > 20, "spikes are among them"
