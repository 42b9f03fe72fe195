"""The model ``dsnn-firmware``: the on-board network as the emulated chip computes it, frame by frame.

It is declared in a file with ``MODEL`` and shown by its path, as a person's own model is: `dsnn` knows no emulator.
"""

from __future__ import annotations

import weakref
from contextlib import ExitStack
from typing import Any

import numpy as np

from dsnn import ModelEntry, Response
from dsnn.model import Model
from dsnn.onboard.params import OnboardParams
from experiments.bench.robot_side.chip import ChipSettings
from experiments.bench.robot_side.firmware import emulated
from experiments.bench.robot_side.qemu import Q15


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
        self._chip, _ = stack.enter_context(emulated((params, ChipSettings(rows=shape[0], columns=shape[1]))))
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
