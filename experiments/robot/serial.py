"""What a board sends on its serial line, as a log.

``dsnn/native/firmware/record.h`` has the form of its records, ``measure_main.c`` the list of them.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Mapping
from typing import Any

import polars as pl

from experiments.robot.firmware import MODEL, Q15
from experiments.robot.logs import ROBOT, SIMULATION

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
