"""The program that measures itself: its records in C and Python, its run in the emulator, what a damaged line costs."""

import ctypes
import os
import re
import subprocess
from pathlib import Path

import polars as pl
import pytest
from hypothesis import example, given, settings, strategies as st

import experiments
from dsnn.onboard.model import OnboardDSNN
from experiments.cli import main
from experiments.robot import export, firmware
from tests.helpers.firmware import needs_tools
from tests.helpers.native_cases import COMPILER, NATIVE, STRICT

SIDE = NATIVE / "firmware"
SET = {"chip.columns": "33", "chip.rows": "24", "dsnn-onboard.n_con": "6"}
TRIALS, FRAMES = 2, 3
WORD = re.compile(r"[a-z0-9-]+")
LONGEST = 128
"""Characters of a line, its end included: ``RECORD_LONGEST``."""


GUARD = b"beyond the record"


class Record(ctypes.Structure):
    """A ``record`` of ``record.h``, and bytes behind it that are not its."""

    _fields_ = (
        ("text", ctypes.c_ubyte * LONGEST), ("length", ctypes.c_uint32), ("legal", ctypes.c_int),
        ("guard", ctypes.c_char * 32),
    )  # fmt: skip


def line(kind: str, *fields: int | str | None) -> bytes:
    """A record as ``record.c`` writes it; ``None`` is no value. What that refuses is a ``ValueError``."""
    texts = [firmware.NONE if value is None else str(value) for value in (kind, *fields)]
    content = ",".join(texts).encode("ascii")
    whole = b"$%b*%04X\r\n" % (content, firmware.crc(content))
    if not all(map(WORD.fullmatch, texts)) or len(whole) > LONGEST:
        raise ValueError(f"record {kind}: too long, or a word with another character than a-z, 0-9 and -")
    return whole


EXPECTED = [(t, f, 10 * f, -20 * t, f, -t, 4_000_000 + f) for t in range(TRIALS) for f in range(FRAMES)]
"""Rows of what is sent."""


def sent(name: str = "stm32f427") -> list[bytes]:
    """What a board sends: made up."""
    lines = [line("board", 1, name, 33, 24, TRIALS, FRAMES, 40_000, 180_000_000, 5, "dwt")]
    lines += [line("frame", *row) for row in EXPECTED]
    return [*lines, line("stack", 604), line("end", TRIALS * FRAMES)]


def test_the_checksum_is_the_one_of_the_catalogues():
    """CRC-16/CCITT-FALSE."""
    assert firmware.crc(b"123456789") == 0x29B1


@pytest.fixture(scope="module")
def c_record(tmp_path_factory):
    """``record.c`` under the sanitizers."""
    library = tmp_path_factory.mktemp("record") / "record.so"
    options = ("-O1", "-shared", "-fPIC", "-fsanitize=undefined", "-fno-sanitize-recover=all")
    subprocess.run([COMPILER, *STRICT, *options, SIDE / "record.c", "-o", library], check=True)
    return ctypes.CDLL(str(library))


FIELD = st.one_of(
    st.tuples(st.just("none"), st.none()),
    st.tuples(st.just("word"), st.text("az09-", max_size=8) | st.text("az09-A,$*", max_size=8)),
    st.tuples(st.just("signed"), st.integers(-(2**31), 2**31 - 1)),
    st.tuples(st.just("unsigned"), st.integers(0, 2**32 - 1)),
)


@pytest.mark.skipif(COMPILER is None, reason="needs a C compiler")
@settings(deadline=None, max_examples=int(os.environ.get("COLIAS_FUZZ_CASES", "200")))
@given(st.lists(FIELD, max_size=14))
@example([("word", "Ab")])
@example([("signed", -(2**31))] * 9 + [("word", "a" * 6)])  # just fits
@example([("signed", -(2**31))] * 9 + [("word", "a" * 7)])
def test_records_in_c_are_those_in_python_under_the_sanitizers(c_record, fields):
    """Random fields, the extremes, and what does not fit; ``make fuzz`` has more of them."""
    memory = Record(guard=GUARD)
    at = ctypes.byref(memory)
    c_record.record_begin(at, b"frame")
    for kind, value in fields:
        form = {"word": str.encode, "signed": ctypes.c_int32, "unsigned": ctypes.c_uint32}.get(kind)
        getattr(c_record, f"record_{kind}")(at, *([form(value)] if form else []))
    length = c_record.record_end(at)
    try:
        expected = line("frame", *(value for _, value in fields))
    except ValueError:
        expected = b""
    assert bytes(memory.text)[:length] == expected and memory.guard == GUARD


def test_what_was_sent_is_decoded():
    frames, board, damaged = firmware.decode(b"".join(sent()))
    values = (1, "stm32f427", 33, 24, TRIALS, FRAMES, 40_000, 180_000_000, 5, "dwt")
    assert board == {**dict(zip(firmware.BOARD, values, strict=True)), "bytes": 604} and damaged == 0
    assert frames.rows() == EXPECTED


@settings(deadline=None)  # no time is measured here
@given(st.integers(0, TRIALS * FRAMES + 2), st.data())
def test_a_flipped_bit_costs_its_own_record_alone(place, data):
    """CRC-16 tells every single flipped bit of a record; one that makes a line's end makes two damaged lines."""
    lines = sent()
    content = bytearray(lines[place])
    content[data.draw(st.integers(0, len(content) - 3))] ^= 1 << data.draw(st.integers(0, 7))
    lines[place] = bytes(content)
    frames, board, damaged = firmware.decode(b"".join(lines))
    assert damaged and ("board" in board) == (place != 0)
    assert frames.rows() == [row for index, row in enumerate(EXPECTED, 1) if index != place]


FOREIGN = (
    "status,3,ok", "", "frame,0,3", "frame,0,1,99,99,9,9,9,9,9", "frame,0,1,a,b,1,1,1", "frame,0,1,--5,1,1,1,1",
    "frame,0,1,99999999999999999999,1,1,1,1", "frame,0,1,-,1,1,1,1", "board,1,stm32f427,33,24,-,-,-,180000000,5,dwt",
    "board,1,other", "board,1,427,33,24,1,3,40000,180000000,5,dwt", "stack,lots", "end,x",
)  # fmt: skip
"""Records of another firmware: whole, and none of ours."""


@pytest.mark.parametrize("content", FOREIGN)
def test_a_record_of_another_firmware_is_skipped_and_counted(content):
    foreign = b"$%b*%04X\r\n" % (content.encode(), firmware.crc(content.encode()))
    frames, board, skipped = firmware.decode(b"".join([*sent(), foreign]))
    assert frames.rows() == EXPECTED and board["board"] == "stm32f427" and skipped == 1
    assert firmware.log_of(frames, board)["time_s"][0] == 0.04


def test_what_one_run_of_the_board_lost_another_has():
    lines = sent()
    assert firmware.decode(b"".join(lines[:3] + lines))[0].rows() == EXPECTED
    earlier = line("frame", *EXPECTED[0][:-1], 7)
    assert firmware.decode(b"".join([lines[0], earlier, *lines]))[0].rows() == EXPECTED, "a frame counts as sent last"
    other = [*sent("another")[:1], line("frame", TRIALS, *EXPECTED[0][1:])]
    assert firmware.decode(b"".join(other + lines))[0].rows() == EXPECTED, "frames of another program do not"


@pytest.mark.parametrize(("lost", "name", "origin"), [
    (False, "stm32f427", "robot"), (False, "qemu-mps2-an386", "simulation"), (True, "stm32f427", "simulation"),
])  # fmt: skip
def test_a_log_is_the_robots_only_where_a_board_says_so(lost, name, origin):
    frames, board, _ = firmware.decode(b"".join(sent(name=name)[lost:]))
    log = firmware.log_of(frames, board)
    assert set(log["origin"]) == {origin}
    assert log["time_s"][0] == (0.033333 if lost else 0.04), "the board says how long a frame takes"


@needs_tools
def test_the_program_that_measures_itself_responds_as_the_host_does_bit_for_bit(tmp_path, monkeypatch):
    """Exported, built, run in the emulator; its serial line decoded and imported beside the host's network."""
    monkeypatch.chdir(tmp_path)
    program = firmware.program(SET)
    export.export(program, Path("out"), SET)
    done = subprocess.run(["make", "-C", "out", "measure", "serial"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    monkeypatch.chdir("out")
    assert main.command(["firmware", "decode", "build/serial.txt", "--out", "measured"]) == 0
    frames, _, damaged = firmware.decode(Path("build/serial.txt").read_bytes())
    assert damaged == frames["cycles"].count() == 0
    model, expected = OnboardDSNN(program[1].shape, program[0]), []
    for trial, name in enumerate(export.SHOWN):
        responses = model.run(firmware.clips(program[1].shape, firmware.COUNTED)[name])
        for frame in range(firmware.COUNTED):
            expected.append((trial, frame, *(getattr(responses, channel)[frame] for channel in firmware.CHANNELS)))
    assert frames.drop("cycles").with_columns(pl.col("hs", "vs") / 32768).rows() == expected
    assert sum(bool(row[4]) for row in expected) > 20, "spikes are among them"
    (command,) = [text for text in Path("README.md").read_text().splitlines() if text.startswith("colias import ")]
    assert main.command([*command.split()[1:], "--out", "run", "--quiet"]) == 0
    of_run = experiments.load("run").frames
    for label in ("dsnn-onboard", "dsnn-onboard@frames"):
        assert of_run.filter(model=label).select("trial", "frame", *firmware.CHANNELS).rows() == expected
