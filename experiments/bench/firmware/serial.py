"""The serial line of the program that measures itself, decoded into a robot's log and a table of cycles.

``dsnn/native/firmware/record.h`` has the form of a record, ``measure_main.c`` the list of them. A line that is damaged
is skipped and counted.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench.firmware.emulator import Q15
from experiments.bench.firmware.settings import MODEL
from experiments.bench.sources.log import ROBOT, SIMULATION

NONE = "-"
"""What stands where a board cannot tell."""
LOG, CYCLES = "log.csv", "cycles.csv"
FRAME_US = 33_333
"""Time from frame to frame where no record tells it: 30 frames a second."""
BOARD = ("version", "board", "columns", "rows", "trials", "frames", "frame_us", "clock_hz", "flash_waits", "counter")
FRAME = ("trial", "frame", "hs", "vs", "hs_spikes", "vs_spikes", "cycles")
FIELDS = {"board": BOARD, "frame": FRAME, "stack": ("bytes",), "end": ("frames",)}
"""Record -> its fields."""
_RECORD = re.compile(rb"\$([a-z0-9,-]*)\*([0-9A-F]{4})")
Values = Mapping[str, Any]


def crc(content: bytes) -> int:
    """CRC-16 of a record's content: polynomial 0x1021, from 0xFFFF."""
    return binascii.crc_hqx(content, 0xFFFF)


@dataclass(frozen=True, slots=True)
class Capture:
    """What one run of the program sent.

    Attributes
    ----------
    board
        Its record of the board and of what it shows, by `BOARD`; empty where that line is lost.
    frames
        The answers, a row each: potentials in Q15, spikes, and cycles, null where none were counted.
    stack
        Bytes used; ``None`` where that line is lost.
    damaged
        Lines of the capture that are no record, or one with another checksum.
    """

    board: Values
    frames: pl.DataFrame
    stack: int | None
    damaged: int

    @property
    def missing(self) -> int:
        """Frames that the board says it shows, and that are not there; 0 where its record is lost."""
        return int(self.board["trials"]) * int(self.board["frames"]) - self.frames.height if self.board else 0

    @property
    def emulated(self) -> bool:
        """Whether the board is an emulator's."""
        return str(self.board.get("board", "")).startswith("qemu-")


def decode(data: bytes) -> Capture:
    """Decode a capture of the serial line.

    Parameters
    ----------
    data
        The bytes as they came. Anything may be in them.

    Returns
    -------
    Capture
        Of the run of the program with the most frames, the last of these, where the capture has several, as after a
        reset of the board.
    """
    runs: list[dict[str, list[Values]]] = [{}]
    damaged = 0
    for line in filter(None, data.replace(b"\r", b"").split(b"\n")):
        record = _record(line)
        if record is None:
            damaged += 1
            continue
        kind, values = record
        if kind == "board" and runs[-1]:
            runs.append({})
        runs[-1].setdefault(kind, []).append(values)
    best = max(reversed(runs), key=lambda run: len(run.get("frame", ())))
    frames = pl.DataFrame(best.get("frame", []), dict.fromkeys(FRAME, pl.Int64))
    stack = best.get("stack", [{}])[-1].get("bytes")
    return Capture(best.get("board", [{}])[0], frames, None if stack is None else int(stack), damaged)


def _record(line: bytes) -> tuple[str, Values] | None:
    """Return kind and fields of a line; ``None`` where it is damaged."""
    match = _RECORD.fullmatch(line)
    if match is None or int(match[2], 16) != crc(match[1]):
        return None
    kind, *texts = match[1].decode().split(",")
    if len(FIELDS.get(kind, ())) != len(texts):
        return None
    values = (None if text == NONE else int(text) if text.lstrip("-").isdigit() else text for text in texts)
    return kind, dict(zip(FIELDS[kind], values, strict=True))


def write(capture: Capture, folder: Path) -> None:
    """Write ``log.csv``, which ``colias import`` reads, and ``cycles.csv``, which is blank where none were counted.

    A log is the robot's where a board says so that is none in an emulator.
    """
    frame_s = int(capture.board.get("frame_us", FRAME_US)) / 1e6
    origin = ROBOT if capture.board and not capture.emulated else SIMULATION
    folder.mkdir(parents=True, exist_ok=True)
    capture.frames.select(
        "trial", model=pl.lit(MODEL), origin=pl.lit(origin), time_s=((pl.col("frame") + 1) * frame_s).round(6),
        hs=pl.col("hs") / Q15, hs_spikes="hs_spikes", vs=pl.col("vs") / Q15, vs_spikes="vs_spikes",
    ).write_csv(folder / LOG)  # fmt: skip
    capture.frames.select("trial", "frame", "cycles").write_csv(folder / CYCLES)


def summary(capture: Capture) -> list[str]:
    """Return what was measured, a line each: frames, cycles and what they mean for the time, stack."""
    board, frames = capture.board, capture.frames
    lines = [f"{frames.height} frames of {board.get('board', 'an unknown board')}"]
    if not frames["cycles"].count():
        lines.append("cycles: not measured; time undetermined")
    else:
        worst = frames.row(int(frames["cycles"].arg_max() or 0), named=True)
        text = f"cycles: {worst['cycles']:,} in the worst frame, {worst['frame']} of trial {worst['trial']}"
        if clock := board.get("clock_hz"):
            took, frame_ms = 1e3 * worst["cycles"] / int(clock), int(board["frame_us"]) / 1e3
            verdict = "in time" if took <= frame_ms else "late"
            text += f": {took:.2f} ms of {frame_ms:.2f} at {int(clock) / 1e6:g} MHz: {verdict}"
        lines.append(text)
    if capture.stack is not None:
        lines.append(f"stack: {capture.stack:,} B used, without interrupts")
    return lines
