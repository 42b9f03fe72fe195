"""The serial line of the program that measures itself: its records, decoded into a robot's log and a table of cycles.

``dsnn/native/firmware/record.h`` has the form of a record, ``measure_main.c`` the list of them. A damaged line costs
what it says and no more: each is told in a line of its own, and what other lines say is kept.
"""

from __future__ import annotations

import binascii
import csv
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from dsnn.onboard.fixed import HALF, MOST_SPIKES
from experiments.bench.firmware.emulator import Q15
from experiments.bench.firmware.settings import MODEL, WIDEST
from experiments.bench.measured.columns import ROBOT, SIMULATION
from experiments.bench.run.errors import short
from experiments.bench.store.places import replacing

LONGEST = 128
"""Characters of a line, its end included: ``RECORD_LONGEST``."""
VERSION = 1
COUNTED, UNCOUNTED = "dwt", "none"
EMULATOR = "qemu-"
"""Beginning of the name of a board that is none."""
NONE = "-"
MOST_TRIALS, MOST_FRAMES = 100, 10_000
LOG, CYCLES = "log.csv", "cycles.csv"
_RECORD = re.compile(rb"\$([a-z0-9,-]*)\*([0-9A-F]{4})")
_WHOLE = re.compile(r"-?(0|[1-9][0-9]{0,9})")
WORDS_SHOWN = 5


def crc(content: bytes) -> int:
    """CRC-16 of a record's content: polynomial 0x1021, from 0xFFFF."""
    return binascii.crc_hqx(content, 0xFFFF)


@dataclass(frozen=True, slots=True)
class Board:
    """A program's record of its board, its trials and its frames; ``None`` where a board cannot tell.

    Parameters
    ----------
    name
        Of the board.
    columns, rows
        Of the frames, px.
    trials, frames
        How many trials it shows, and frames of each.
    frame_us
        Time from frame to frame, us.
    clock_hz
        The processor's clock, 1/s.
    waits
        Wait states that the flash was set to.
    counted
        Whether cycles were counted.
    """

    name: str
    columns: int
    rows: int
    trials: int
    frames: int
    frame_us: int
    clock_hz: int | None
    waits: int | None
    counted: bool

    @property
    def emulated(self) -> bool:
        """Tell whether it is an emulator."""
        return self.name.startswith(EMULATOR)


@dataclass(frozen=True, slots=True)
class Answered:
    """The answer to one frame: potentials in Q15, spikes, and cycles, ``None`` where none were counted."""

    trial: int
    frame: int
    hs: int
    vs: int
    hs_spikes: int
    vs_spikes: int
    cycles: int | None


@dataclass(slots=True)
class Decoded:
    """The records of one run of the program, decoded from a capture of the line.

    Parameters
    ----------
    board
        ``None`` where that record is lost.
    answers
        In order.
    stack
        Bytes used; ``None`` where that record is lost.
    problems
        What is wrong, a line each, with the number of the line in the capture.
    """

    board: Board | None = None
    answers: list[Answered] = field(default_factory=list)
    stack: int | None = None
    problems: list[str] = field(default_factory=list)

    @property
    def worst(self) -> Answered | None:
        """The frame of the most cycles; ``None`` where none were counted."""
        counted = [answer for answer in self.answers if answer.cycles is not None]
        return max(counted, key=lambda answer: answer.cycles or 0, default=None)


def decode(data: bytes, name: str = "serial data") -> Decoded:
    """Decode a capture of the serial line.

    Parameters
    ----------
    data
        The bytes as they came. Anything may be in them.
    name
        Of the capture, for the problems.

    Returns
    -------
    Decoded
        Of the run of the program with the most frames, where the capture has several, as after a reset.
    """
    runs = [_Run(name)]
    number = 0
    for number, text in enumerate(_lines(data), 1):
        if not text.strip():
            continue
        try:
            kind, fields = _record(text)
            if kind == "board" and runs[-1].begun:
                runs.append(_Run(name))
            runs[-1].take(number, kind, fields)
        except ValueError as error:
            runs[-1].refuse(number, str(error))
    best = max(reversed(runs), key=lambda run: len(run.decoded.answers))
    problems = []
    for run in runs:
        if run is best:
            run.conclude()
            problems += run.decoded.problems
        else:
            frames = len(run.decoded.answers)
            reason = f"a run of the program with {frames} frames is left out: another one has as many or more"
            problems.append(f"{name}, line {run.first}: {reason}")
    best.decoded.problems = problems
    return best.decoded


def _lines(data: bytes) -> Iterator[bytes]:
    """Yield the lines; only a line feed ends one, and the last may have none."""
    lines = data.split(b"\n")
    yield from lines[:-1] if not lines[-1] else lines


def _record(text: bytes) -> tuple[str, list[str]]:
    """Kind and fields of a line; ``ValueError`` says what is wrong with it."""
    stripped = text.removesuffix(b"\r")
    if len(stripped) + 2 > LONGEST:
        raise ValueError(f"{len(stripped) + 2} characters: a record has up to {LONGEST}")
    match = _RECORD.fullmatch(stripped)
    if match is None:
        line = short(stripped.decode("ascii", "replace"))
        raise ValueError(f"{line} is no record: legal is $kind,field,...*CRC4")
    content, given = match[1], match[2].decode()
    if int(given, 16) != crc(content):
        raise ValueError(f"the checksum is {crc(content):04X}, the line says {given}: it is damaged")
    kind, *fields = content.decode().split(",")
    return kind, fields


class _Run:
    """One run of the program in a capture."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.decoded = Decoded()
        self.first = 0
        self.begun = False
        self.end: int | None = None

    def refuse(self, number: int, reason: str) -> None:
        """Keep a problem."""
        self.first = self.first or number
        self.decoded.problems.append(f"{self.name}, line {number}: {reason}")

    def take(self, number: int, kind: str, fields: Sequence[str]) -> None:
        """Take a record; ``ValueError`` says what is wrong with it."""
        self.first = self.first or number
        takers: dict[str, tuple[int, Callable[[_Fields], None]]] = {
            "board": (10, self._board), "frame": (7, self._frame), "stack": (1, self._stack), "end": (1, self._end),
        }  # fmt: skip
        if kind not in takers:
            raise ValueError(f"record {short(kind)}: legal is {', '.join(takers)}")
        count, taker = takers[kind]
        if len(fields) != count:
            raise ValueError(f"record {kind} has {len(fields)} fields: legal is {count}")
        taker(_Fields(fields))
        self.begun = True

    def _board(self, given: _Fields) -> None:
        given.whole("version", VERSION, VERSION)
        name = given.text("board")
        columns, rows = given.whole("columns", 1, WIDEST), given.whole("rows", 1, WIDEST)
        trials, frames = given.whole("trials", 1, MOST_TRIALS), given.whole("frames", 1, MOST_FRAMES)
        frame_us = given.whole("us from frame to frame", 1, 10**7)
        clock, waits = given.perhaps("clock", 1, 10**9), given.perhaps("wait states", 0, 15)
        counter = given.text("counter")
        if counter not in (COUNTED, UNCOUNTED):
            raise ValueError(f"counter={counter}: legal is {COUNTED}, {UNCOUNTED}")
        counted = counter == COUNTED
        self.decoded.board = Board(name, columns, rows, trials, frames, frame_us, clock, waits, counted)

    def _frame(self, given: _Fields) -> None:
        trial, frame = given.whole("trial", 0, MOST_TRIALS - 1), given.whole("frame", 0, MOST_FRAMES - 1)
        hs, vs = (given.whole(channel, -2 * HALF, 2 * HALF) for channel in ("hs", "vs"))
        hs_spikes, vs_spikes = (given.whole(f"{channel}_spikes", -MOST_SPIKES, MOST_SPIKES) for channel in ("hs", "vs"))
        cycles = given.perhaps("cycles", 1, 2**32 - 1)
        for channel, potential, spikes in (("hs", hs, hs_spikes), ("vs", vs, vs_spikes)):
            if potential * spikes < 0 or (spikes and not potential):
                problem = f"{channel}_spikes={spikes}, but {channel}={potential}"
                raise ValueError(f"{problem}: legal are spikes with the potential's sign")
        board, before = self.decoded.board, self.decoded.answers[-1:]
        if board and (trial >= board.trials or frame >= board.frames):
            there = f"{board.trials} trials of {board.frames} frames"
            raise ValueError(f"frame {frame} of trial {trial}: the program said that it shows {there}")
        if board and board.counted != (cycles is not None):
            problem = (
                "no cycles, though the board counts them" if board.counted else f"cycles={cycles} of a board without"
            )
            raise ValueError(problem if board.counted else f"{problem} a counter: nobody measured them")
        if before and (trial, frame) <= (before[0].trial, before[0].frame):
            raise ValueError(
                f"frame {frame} of trial {trial} after frame {before[0].frame} of trial {before[0].trial}: out of order"
            )
        self.decoded.answers.append(Answered(trial, frame, hs, vs, hs_spikes, vs_spikes, cycles))

    def _stack(self, given: _Fields) -> None:
        self.decoded.stack = given.whole("stack", 0, 2**24)

    def _end(self, given: _Fields) -> None:
        self.end = given.whole("frames", 0, MOST_TRIALS * MOST_FRAMES)

    def _missing(self, reason: str) -> None:
        self.decoded.problems.append(f"{self.name}: {reason}")

    def conclude(self) -> None:
        """Keep what is missing."""
        answers, board = self.decoded.answers, self.decoded.board
        if board is None:
            self._missing("no record board is whole: what ran the program, and at which clock, is not known")
        if self.end is None:
            self._missing("no record end is whole: the program had not ended, or its last line is damaged")
        wanted = board.trials * board.frames if board else self.end
        if wanted is not None and wanted > len(answers):
            there = {(answer.trial, answer.frame) for answer in answers}
            named = []
            if board:
                every = ((t, f) for t in range(board.trials) for f in range(board.frames))
                named = [f"{f} of trial {t}" for t, f in every if (t, f) not in there]
            first = f": {', '.join(named[:WORDS_SHOWN])}{', ...' if len(named) > WORDS_SHOWN else ''}" if named else ""
            self._missing(f"{wanted - len(answers)} of {wanted} frames are missing{first}")


class _Fields:
    """The fields of a record, taken one after the other."""

    def __init__(self, texts: Sequence[str]) -> None:
        self._left = list(texts)

    def text(self, name: str) -> str:
        """Take a word."""
        text = self._left.pop(0)
        if not text:
            raise ValueError(f"{name} is blank")
        return text

    def perhaps(self, name: str, low: int, high: int) -> int | None:
        """Take a whole number, or none."""
        return None if self._left[0] == NONE and self._left.pop(0) else self.whole(name, low, high)

    def whole(self, name: str, low: int, high: int) -> int:
        """Take a whole number of a range."""
        text = self.text(name)
        if not _WHOLE.fullmatch(text) or not low <= int(text) <= high:
            raise ValueError(f"{name} must be a whole number between {low} and {high}, got {short(text)}")
        return int(text)


FRAME_US = 33_333
"""Time from frame to frame where no record tells it: 30 frames a second."""


def write(decoded: Decoded, folder: Path) -> tuple[Path, Path]:
    """Write ``log.csv``, which ``colias import`` reads, and ``cycles.csv``, which is blank where none were counted.

    A log is the robot's where a board says so that is none in an emulator.
    """
    board = decoded.board
    frame_s = (board.frame_us if board else FRAME_US) / 1e6
    origin = ROBOT if board and not board.emulated else SIMULATION
    log: list[tuple[object, ...]] = [
        (a.trial, MODEL, origin, round((a.frame + 1) * frame_s, 6), a.hs / Q15, a.hs_spikes, a.vs / Q15, a.vs_spikes)
        for a in decoded.answers
    ]
    cycles: list[tuple[object, ...]] = [
        (a.trial, a.frame, "" if a.cycles is None else a.cycles) for a in decoded.answers
    ]
    header = ("trial", "model", "origin", "time_s", "hs", "hs_spikes", "vs", "vs_spikes")
    tables = {LOG: (header, log), CYCLES: (("trial", "frame", "cycles"), cycles)}
    folder.mkdir(parents=True, exist_ok=True)
    for name, (columns, rows) in tables.items():
        with replacing(folder / name) as partial, partial.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(rows)
    return folder / LOG, folder / CYCLES


def words(decoded: Decoded) -> list[str]:
    """Say what was measured, a line each: frames, cycles and what they mean for the time, stack."""
    board, worst = decoded.board, decoded.worst
    ran = board.name if board else "an unknown board"
    lines = [f"{len(decoded.answers)} frames of {ran}"]
    if worst is None or worst.cycles is None:
        why = "an emulator counts none" if board and board.emulated else "no cycle counter"
        lines.append(f"cycles: not measured ({why}); time undetermined")
    else:
        text = f"cycles: {worst.cycles:,} in the worst frame, {worst.frame} of trial {worst.trial}"
        if board and board.clock_hz:
            took, frame_ms = 1000.0 * worst.cycles / board.clock_hz, board.frame_us / 1000.0
            waits = "" if board.waits is None else f", {board.waits} wait states"
            verdict = "in time" if took <= frame_ms else "late"
            text += f": {took:.2f} ms of {frame_ms:.2f} at {board.clock_hz / 1e6:g} MHz{waits}: {verdict}"
        lines.append(text)
    if decoded.stack is not None:
        lines.append(f"stack: {decoded.stack:,} B used, without interrupts")
    return lines
