"""Firmware in the loop: a run whose observer has the emulated chip, beside the host's form on the same frames."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import polars as pl

from experiments.bench.robot_side import emulated, qemu
from experiments.bench.robot_side.chip import CHIP, MODEL, full_key
from experiments.bench.robot_side.firmware import CHANNELS, differing
from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import read_table


def assignments(given: Iterable[str]) -> list[str]:
    """Return ``--set`` texts of a trial, each of the network's for both forms."""
    texts = []
    for text in map(full_key, given):
        if text.startswith(f"{CHIP}."):
            raise UsageError(f"--set {text}: the chip's memory changes no response; it goes with budget and export")
        texts.append(text)
        if text.startswith(f"{MODEL}."):
            texts.append(text.replace(MODEL, emulated.MODEL.name, 1))
    return texts


def models() -> list[str]:
    """Return the models to show: the host's form and the chip. `UsageError` where a tool is missing."""
    qemu.compiler()
    qemu.emulator()
    return [MODEL, emulated.__file__]


def compare(folder: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the frames of a finished run with the responses of chip and host, and those in which they differ."""
    table = read_table(folder, "frames", ["trial", "model", "frame", *CHANNELS])
    chip, host = (table.filter(model=name).drop("model") for name in (emulated.MODEL.name, MODEL))
    both = chip.join(host, on=["trial", "frame"], how="full", coalesce=True, suffix="_host")
    return both, differing(both)
