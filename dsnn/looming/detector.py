"""Work that every looming detector of one potential does around its layers: check a frame, spike, count to a
collision.
"""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

import numpy.typing as npt

from dsnn.frames import Channels, checked_shape
from dsnn.model import Model, Response


class Detector(Model):
    """A looming detector: its layers give potential and spikes of a frame, in `_answer`.

    Parameters
    ----------
    shape
        (R, C) of the frames, 2 or more each.
    n_sp
        Spikes without a silent frame between them that mean a collision.

    Raises
    ------
    dsnn.FrameError
        The shape is not two whole numbers from 2 up.
    """

    def __init__(self, shape: tuple[int, int], n_sp: int) -> None:
        self.shape = checked_shape(shape)
        self._n_sp = n_sp
        self._count = 0

    @abstractmethod
    def _answer(self, luminance: npt.NDArray[Any]) -> tuple[float, int]:
        """Return the potential, from 0.5 at rest up to 1, and the spikes of the next frame, (R, C) grey levels."""

    @abstractmethod
    def _forget(self) -> None:
        """Bring the layers to the state before the first frame."""

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._forget()
        self._count = 0

    @property
    def collision(self) -> bool:
        """Tell whether the frames up to the last one mean a collision."""
        return self._count >= self._n_sp

    def step(self, frame: npt.NDArray[Any], *, channels: Channels = "grey", maps: bool = False) -> Response:
        """Answer the next frame.

        Parameters, returns and errors are those of `dsnn.VisionModel.step`. It has no maps.
        """
        potential, spikes = self._answer(self._luma(frame, channels))
        self._count = self._count + spikes if spikes else 0
        return Response(looming=potential, looming_spikes=spikes)
