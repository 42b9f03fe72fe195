"""The program that measures itself: its records in C and Python, its run in the emulator, what a damaged line costs."""

from __future__ import annotations

import csv
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
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
CHECK_OF_NINE_DIGITS = 0x29B1
"""CRC-16/CCITT-FALSE of "123456789", as catalogues of such sums have it."""


def line(kind: str, *fields: int | str | None) -> bytes:
    """A record as ``record.c`` writes it; ``None`` is no value. What that refuses is a ``ValueError``."""
    texts = [serial.NONE if value is None else str(value) for value in (kind, *fields)]
    if not all(map(WORD.fullmatch, texts)):
        raise ValueError(f"record {kind}: a word is empty, or has another character than a-z, 0-9 and -")
    content = ",".join(texts).encode("ascii")
    whole = b"$%b*%04X\r\n" % (content, serial.crc(content))
    if len(whole) > serial.LONGEST:
        raise ValueError(f"record {kind}: {len(whole)} characters: legal is up to {serial.LONGEST}")
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


def test_what_was_sent_is_decoded():
    decoded = serial.decode(b"".join(sent()))
    assert not decoded.problems and decoded.stack == 604
    assert decoded.board == serial.Board("stm32f427", 33, 24, TRIALS, FRAMES, 33_333, 180_000_000, 5, counted=True)
    assert [(a.trial, a.frame, a.hs, a.vs, a.hs_spikes, a.vs_spikes, a.cycles) for a in decoded.answers] == [
        (t, f, 10 * f, -20 * t, f, -t, 4_000_000 + f) for t in range(TRIALS) for f in range(FRAMES)
    ]


DAMAGED = {
    "noise before the first line": (2, b"\xff\x00\xfeboot\r\n", "is no record: legal is $kind,field,...*CRC4"),
    "another checksum": (2, b"$frame,0,0,0,0,0,0,1*0000\r\n", "the checksum is"),
    "a line without an end": (2, b"$" + b"a" * 500 + b"\n", "characters: a record has up to 128"),
    "an unknown record": (2, line("colour", 3), "legal is board, frame, stack, end"),
    "too few fields": (2, line("frame", 0, 0, 1), "has 3 fields: legal is 7"),
    "no number": (2, line("frame", "x", 0, 0, 0, 0, 0, 1), "trial must be a whole number between 0 and"),
    "a zero in front": (2, line("frame", 0, "00", 0, 0, 0, 0, 1), "frame must be"),
    "a potential beyond its range": (2, line("frame", 0, 0, 32768, 0, 0, 0, 1), "hs must be"),
    "spikes of the other sign": (2, line("frame", 0, 0, 5, 0, -1, 0, 1), "with the potential's sign"),
    "a trial that the board does not show": (2, line("frame", 9, 0, 0, 0, 0, 0, 1), "it shows 2 trials of 3"),
    "no cycles": (2, line("frame", 0, 0, 0, 0, 0, 0, None), "no cycles, though the board counts them"),
    "no cycles at all": (2, line("frame", 0, 0, 0, 0, 0, 0, 0), "cycles must be a whole number between 1"),
    "a frame that was there": (3, line("frame", 0, 0, 0, 0, 0, 0, 1), "out of order"),
    "another version": (1, line("board", 2, "a", 1, 1, 1, 1, 1, None, None, "dwt"), "version must be"),
    "another counter": (1, line("board", 1, "a", 1, 1, 1, 1, 1, None, None, "clock"), "counter=clock: legal is"),
}


@pytest.mark.parametrize("what", DAMAGED)
def test_a_damaged_line_is_told_once_with_its_number_and_costs_nothing_else(what):
    number, damaged, reason = DAMAGED[what]
    lines = sent()
    lines.insert(number - 1, damaged)
    decoded = serial.decode(b"".join(lines), "capture.txt")
    (problem,) = decoded.problems
    assert problem.startswith(f"capture.txt, line {number}: ") and reason in problem and problem.isprintable()
    assert decoded.answers == serial.decode(b"".join(sent())).answers


@given(st.integers(0, TRIALS * FRAMES + 2), st.data())
def test_a_flipped_bit_costs_its_own_record_alone(place, data):
    """CRC-16 tells every single flipped bit of a record; one that makes a line's end makes two damaged lines."""
    lines = sent()
    content = bytearray(lines[place])
    content[data.draw(st.integers(0, len(content) - 3))] ^= 1 << data.draw(st.integers(0, 7))
    lines[place] = bytes(content)
    whole, decoded = serial.decode(b"".join(sent())), serial.decode(b"".join(lines))
    assert decoded.problems and any(f"line {place + 1}:" in problem for problem in decoded.problems)
    if place == 0:
        assert decoded.board is None and decoded.answers == whole.answers
    else:
        lost = whole.answers[place - 1 : place]
        assert decoded.answers == [answer for answer in whole.answers if answer not in lost]


@given(st.binary(max_size=600))
def test_any_bytes_are_decoded_to_no_more_than_lines_about_them(data):
    decoded = serial.decode(data)
    assert not decoded.answers and all(problem.isprintable() for problem in decoded.problems)


def test_missing_frames_are_named_and_of_several_runs_the_fullest_is_taken():
    lines = sent()
    begun, whole = b"".join(lines[:3]), b"".join(lines)
    (problem,) = serial.decode(begun + whole).problems
    assert problem.endswith("line 1: a run of the program with 2 frames is left out: another one has as many or more")
    assert serial.decode(begun + whole).answers == serial.decode(whole).answers
    decoded = serial.decode(begun)
    assert len(decoded.answers) == 2
    assert decoded.problems[-1].endswith(
        "4 of 6 frames are missing: 2 of trial 0, 0 of trial 1, 1 of trial 1, 2 of trial 1"
    )


def test_cycles_decide_about_the_time_and_none_are_made_up(tmp_path):
    """4,000,002 cycles are 22.22 ms at 180 MHz and 66.67 ms at 60 MHz; a frame has 33.33 ms."""
    worst = "4,000,002 in the worst frame, 2 of trial 0"
    for clock, verdict in ((180_000_000, "22.22 ms of 33.33 at 180 MHz, 5 wait states: in time"),
                           (60_000_000, "66.67 ms of 33.33 at 60 MHz, 5 wait states: late")):  # fmt: skip
        text = "\n".join(serial.words(serial.decode(b"".join(sent(clock=clock)))))
        assert worst in text and verdict in text
    decoded = serial.decode(b"".join(sent("none", "qemu-mps2-an386", None)))
    assert not decoded.problems and decoded.worst is None
    assert "cycles: not measured (an emulator counts none); time undetermined" in serial.words(decoded)
    _, cycles = serial.write(decoded, tmp_path)
    with cycles.open() as file:
        assert {row["cycles"] for row in csv.DictReader(file)} == {""}


@pytest.mark.parametrize(("lost", "name", "origin"), [
    (False, "stm32f427", "robot"), (False, "qemu-mps2-an386", "simulation"), (True, "stm32f427", "simulation"),
])  # fmt: skip
def test_a_log_is_the_robots_only_where_a_board_says_so(lost, name, origin, tmp_path):
    log, _ = serial.write(serial.decode(b"".join(sent(name=name)[lost:])), tmp_path)
    with log.open() as file:
        assert {row["origin"] for row in csv.DictReader(file)} == {origin}


def test_the_command_tells_each_damaged_line_and_writes_what_is_whole(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lines = sent()
    lines[3] = lines[3].replace(b"frame", b"frbme")
    Path("serial.txt").write_bytes(b"".join(lines))
    assert main.command(["firmware", "decode", "serial.txt", "--out", "out"]) == 1
    captured = capsys.readouterr()
    first, second = captured.err.splitlines()
    assert first.startswith("serial.txt, line 4: the checksum is") and "1 of 6 frames are missing: 2 of" in second
    assert len(Path("out/log.csv").read_text().splitlines()) == TRIALS * FRAMES
    with pytest.raises(UsageError, match="out: is not empty"):
        main.command(["firmware", "decode", "serial.txt", "--out", "out"])
    for name, content, reason in (("empty", b"", "no frame is whole"), ("gone", None, "cannot be read")):
        if content is not None:
            Path(name).write_bytes(content)
        with pytest.raises(UsageError, match=f"{name}: {reason}"):
            main.command(["firmware", "decode", name, "--out", "other"])
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
def test_the_program_that_measures_itself_answers_as_the_host_does_bit_for_bit(tmp_path, monkeypatch, capsys):
    """Exported, built, run in the emulator; its serial line decoded and imported beside the host's network."""
    monkeypatch.chdir(tmp_path)
    wanted = settings.firmware(SET)
    export.export(wanted, Path("out"), SET, "not asked")
    done = subprocess.run(["make", "-C", "out", "measure", "serial"], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert main.command(["firmware", "decode", "out/build/serial.txt", "--out", "decoded"]) == 0
    assert "cycles: not measured (an emulator counts none)" in capsys.readouterr().out
    decoded = serial.decode(Path("out/build/serial.txt").read_bytes())
    assert not decoded.problems and decoded.worst is None
    model, expected = OnboardDSNN(wanted.shape, wanted.network), []
    for trial, frames in enumerate(clips.worst(wanted).values()):
        model.reset()
        answers = [model.step(frame) for frame in frames]
        expected += [(trial, i, a.hs, a.vs, a.hs_spikes, a.vs_spikes) for i, a in enumerate(answers)]
    assert [
        (a.trial, a.frame, a.hs / 32768, a.vs / 32768, a.hs_spikes, a.vs_spikes) for a in decoded.answers
    ] == expected
    page = Path("out/README.md").read_text()
    (command,) = [text for text in page.splitlines() if text.startswith("colias import ")]
    folder = Path("out")
    shutil.move("decoded", folder / "measured")
    monkeypatch.chdir(folder)
    assert main.command([*command.split()[1:], "--out", "run", "--no-recordings", "--quiet"]) == 0
    rows: dict[str, list[tuple[object, ...]]] = {}
    for row in experiments.load("run").frames.to_dicts():
        values = row["trial"], row["frame"], row["hs"], row["vs"], row["hs_spikes"], row["vs_spikes"]
        rows.setdefault(row["model"], []).append(values)
    assert rows["dsnn-onboard"] == rows["dsnn-onboard@frames"] == expected
    assert sum(bool(answer[4]) for answer in expected) > 20, "spikes are among them"
