"""The model ``dsnn-firmware``: the on-board network as the emulated chip computes it, frame by frame.

It is declared here, in a file with ``MODEL``, and shown by its path as a person's own model is: `dsnn` knows no
emulator. Each model built has a program of its own, which ends with it.
"""

from __future__ import annotations

import tempfile
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import ModelEntry, Response
from dsnn.model import Model
from dsnn.onboard.params import OnboardParams
from experiments.bench.firmware.build import build
from experiments.bench.firmware.emulator import Q15, Emulator
from experiments.bench.firmware.settings import ChipSettings, Firmware
from experiments.bench.firmware.toolchain import compiler, qemu

NAME = "dsnn-firmware"
ENOUGH = 2**22
"""Bytes of each RAM region: whether a network fits the chip is the budget's matter, not this model's."""


class FirmwareDSNN(Model[OnboardParams]):
    """The on-board network in the emulator.

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
    EmulatorError
        The emulated chip gives no answer.
    """

    def __init__(self, shape: tuple[int, int], params: OnboardParams) -> None:
        super().__init__(shape, params, OnboardParams)
        chip = ChipSettings(shape=f"{shape[1]}x{shape[0]}", ram_main=ENOUGH, ram_core=ENOUGH)
        with tempfile.TemporaryDirectory(prefix="colias-firmware-") as folder:  # read once it has answered
            built = build(Firmware(params, chip), compiler(), Path(folder))
            self._chip = Emulator(qemu(), built.path, shape)
        weakref.finalize(self, self._chip.close)

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        answer = self._chip.step(np.rint(luminance).astype(np.uint8))
        return Response(answer.hs / Q15, answer.vs / Q15, answer.hs_spikes, answer.vs_spikes)

    def reset(self) -> None:
        """Forget every frame."""
        self._chip.reset()


MODEL = ModelEntry(
    NAME,
    "the on-board DSNN as QEMU's Cortex-M4 computes it",
    FirmwareDSNN,
    OnboardParams.robot(),
    offline=OnboardParams.offline(),
)
