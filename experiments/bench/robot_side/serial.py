"""The serial line of the program that measures itself, decoded into a robot's log and a table of cycles.

``dsnn/native/firmware/record.h`` has the form of a record, ``measure_main.c`` the list of them.
"""

from __future__ import annotations

import binascii
import re
from collections.abc import Mapping
from typing import Any

import polars as pl

from experiments.bench.robot_side.chip import MODEL
from experiments.bench.robot_side.qemu import Q15
from experiments.bench.sources.log import ROBOT, SIMULATION

NONE = "-"
"""What stands where a board cannot tell."""
BOARD = ("version", "board", "columns", "rows", "trials", "frames", "frame_us", "clock_hz", "flash_waits", "counter")
FRAME = ("trial", "frame", "hs", "vs", "hs_spikes", "vs_spikes", "cycles")
FIELDS = {"board": BOARD, "frame": FRAME, "stack": ("bytes",), "end": ()}
"""Record -> its fields."""
_RECORD = re.compile(rb"\$([a-z0-9,-]*)\*([0-9A-F]{4})\r?")


def crc(content: bytes) -> int:
    """CRC-16 of a record's content: polynomial 0x1021, from 0xFFFF."""
    return binascii.crc_hqx(content, 0xFFFF)


def decode(data: bytes) -> tuple[pl.DataFrame, Mapping[str, Any], int]:
    """Decode a capture of the serial line. A line that is damaged is skipped.

    Parameters
    ----------
    data
        The bytes as they came. Where the program ran several times, as after a reset of the board, a frame counts as it
        was sent last.

    Returns
    -------
    polars.DataFrame
        A row per frame: potentials in Q15, spikes, and cycles, null where none were counted.
    dict
        Fields of the records ``board`` and ``stack``; empty where these are lost.
    int
        Number of damaged lines.
    """
    frames, board, damaged = [], dict[str, Any](), 0
    for line in filter(bytes.strip, data.split(b"\n")):
        match = _RECORD.fullmatch(line)
        if match is None or int(match[2], 16) != crc(match[1]):
            damaged += 1
            continue
        kind, *texts = match[1].decode().split(",")
        values = [None if text == NONE else int(text) if text.lstrip("-").isdigit() else text for text in texts]
        record = dict(zip(FIELDS[kind], values, strict=False))
        if kind == "frame":
            frames.append(record)
        else:
            board |= record
    table = pl.DataFrame(frames, dict.fromkeys(FRAME, pl.Int64))
    return table.unique(["trial", "frame"], keep="last").sort("trial", "frame"), board, damaged


def log(frames: pl.DataFrame, board: Mapping[str, Any]) -> pl.DataFrame:
    """Return the frames as a log that ``colias import`` reads: the robot's where a board says so that is no emulator.

    Where the board's record is lost, frames came 30 a second.
    """
    origin = SIMULATION if board.get("board", "qemu-").startswith("qemu-") else ROBOT
    time_s = (pl.col("frame") + 1) * board.get("frame_us", 33_333) / 1e6
    return frames.select(
        "trial", model=pl.lit(MODEL), origin=pl.lit(origin), time_s=time_s.round(6),
        hs=pl.col("hs") / Q15, hs_spikes="hs_spikes", vs=pl.col("vs") / Q15, vs_spikes="vs_spikes",
    )  # fmt: skip
