"""Firmware in the loop: a run whose observer has the emulated chip, beside the host's form on the same frames.

The model ``dsnn-firmware`` is declared here with ``MODEL`` and shown by this file's path, as a person's own model is:
`dsnn` knows no emulator.
"""

from __future__ import annotations

import weakref
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from dsnn import ModelEntry, Response
from dsnn.model import Model
from dsnn.onboard.params import OnboardParams
from experiments.bench.robot_side import chip, qemu
from experiments.bench.robot_side.firmware import CHANNELS, differing, emulated
from experiments.bench.robot_side.qemu import Q15
from experiments.bench.run.errors import UsageError
from experiments.bench.run.folder import read_table


class FirmwareDSNN(Model[OnboardParams]):
    """The on-board network in the emulator: a process of its own for each.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    params
        Of the model ``dsnn-onboard``.

    Raises
    ------
    UsageError
        The compiler or the emulator is missing.
    """

    def __init__(self, shape: tuple[int, int], params: OnboardParams) -> None:
        super().__init__(shape, params, OnboardParams)
        stack = ExitStack()
        self._chip, _ = stack.enter_context(emulated((params, chip.ChipSettings(rows=shape[0], columns=shape[1]))))
        weakref.finalize(self, stack.close)

    def _respond(self, luminance: Any, maps: bool) -> Response:
        hs, vs, hs_spikes, vs_spikes = self._chip.step(np.rint(luminance).astype(np.uint8))[0]
        return Response(hs / Q15, vs / Q15, hs_spikes, vs_spikes)

    def reset(self) -> None:
        """Forget every frame."""
        self._chip.reset()


MODEL = ModelEntry(
    "dsnn-firmware", "the on-board DSNN as QEMU's Cortex-M4 computes it", FirmwareDSNN, OnboardParams.robot(),
    offline=OnboardParams.offline(),
)  # fmt: skip


def assignments(given: Iterable[str]) -> list[str]:
    """Return ``--set`` texts of a trial, each of the network's for both forms."""
    texts = []
    for text in map(chip.full_key, given):
        if text.startswith(f"{chip.CHIP}."):
            raise UsageError(f"--set {text}: the chip's memory changes no response; it goes with budget and export")
        texts.append(text)
        if text.startswith(f"{chip.MODEL}."):
            texts.append(text.replace(chip.MODEL, MODEL.name, 1))
    return texts


def models() -> list[str]:
    """Return the models to show: the host's form and the chip. `UsageError` where a tool is missing."""
    qemu.compiler()
    qemu.emulator()
    return [chip.MODEL, __file__]


def compare(folder: Path) -> tuple[pl.DataFrame, pl.DataFrame]:
    """Return the frames of a finished run with the responses of chip and host, and those in which they differ."""
    table = read_table(folder, "frames", ["trial", "model", "frame", *CHANNELS])
    emulated_chip, host = (table.filter(model=name).drop("model") for name in (MODEL.name, chip.MODEL))
    both = emulated_chip.join(host, on=["trial", "frame"], how="full", coalesce=True, suffix="_host")
    return both, differing(both)
