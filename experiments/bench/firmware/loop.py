"""Firmware in the loop: a run whose observer has the emulated chip, beside the host's form on the same frames."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.bench.firmware import toolchain
from experiments.bench.firmware.check import CHANNELS, Difference
from experiments.bench.firmware.emulated import NAME
from experiments.bench.firmware.settings import ALIAS, CHIP, MODEL, plain_key
from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import read_table

SOURCE = str(Path(__file__).with_name("emulated.py"))
"""The file that declares the model of the chip."""


@dataclass(frozen=True, slots=True)
class Loop:
    """Answers of the two forms in a run.

    Parameters
    ----------
    trials, frames
        Compared.
    difference
        The first in words; empty where every HS, VS and spike is equal.
    """

    trials: int
    frames: int
    difference: str


def assignments(given: Sequence[str]) -> list[str]:
    """``--set`` texts of the robot's trial, each of the network's for both forms.

    The chip's program has a section of its own name, or that of the model's family.
    """
    texts = []
    for text in map(plain_key, given):
        if text.startswith(f"{CHIP}."):
            raise UsageError(
                f"--set {text}: the chip's memory changes no answer; it goes with budget, check and export"
            )
        texts.append(text)
        if text.startswith(f"{MODEL}."):
            texts.append(f"{ALIAS}{text[len(MODEL) :]}")
    return texts


def models() -> list[str]:
    """Return the models to show: the host's form and the chip. `UsageError` where a tool is missing."""
    toolchain.compiler()
    toolchain.qemu()
    return [MODEL, SOURCE]


def compare(folder: Path) -> Loop:
    """Compare the two forms' answers in ``frames.parquet`` of a finished run, every frame of every trial."""
    table = read_table(folder, "frames", ["trial", "model", "frame", *CHANNELS])
    rows: dict[str, dict[tuple[int, int], tuple[float, ...]]] = {MODEL: {}, NAME: {}}
    for row in table.to_dicts():
        rows[row["model"]][row["trial"], row["frame"]] = tuple(row[name] for name in CHANNELS)
    host, chip = rows[MODEL], rows[NAME]
    trials = len({trial for trial, _ in host})
    if host.keys() != chip.keys():
        missing = sorted(host.keys() ^ chip.keys())[0]
        return Loop(trials, len(host), f"trial {missing[0]}, frame {missing[1]}: one of the two has no answer")
    for (trial, frame), values in sorted(host.items()):
        for name, mine, theirs in zip(CHANNELS, values, chip[trial, frame], strict=True):
            if mine != theirs:
                difference = Difference(f"trial {trial}", frame, name, mine, theirs)
                return Loop(trials, len(host), difference.words())
    return Loop(trials, len(host), "")
