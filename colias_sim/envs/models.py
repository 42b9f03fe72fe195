"""The vision model behind the neural observations: what an env asks of it, and how it is built from its name."""

from __future__ import annotations

import importlib
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

WIRING = "experiments.wiring"
"""The module that builds models from names. `colias_sim` knows no model, so it imports this one when one is built."""


class ModelResponse(Protocol):
    """The response of a vision model to one frame: membrane potentials, and spikes in that frame."""

    @property
    def hs(self) -> float:
        """Horizontal motion, rightward positive, in (-1, 1)."""
        ...

    @property
    def vs(self) -> float:
        """Vertical motion, downward positive, in (-1, 1)."""
        ...

    @property
    def hs_spikes(self) -> int:
        """Spikes of HS in this frame, with the sign of ``hs``."""
        ...

    @property
    def vs_spikes(self) -> int:
        """Spikes of VS in this frame, with the sign of ``vs``."""
        ...

    @property
    def looming(self) -> float:
        """Potential of the looming detector, from 0.5 at rest up to 1; 0 in a model without one."""
        ...

    @property
    def looming_spikes(self) -> int:
        """Spikes of the looming detector in this frame."""
        ...

    @property
    def azimuth(self) -> float:
        """Horizontal position of the motion in the view, from -1 (left edge) to 1 (right edge)."""
        ...


class Model(Protocol):
    """A vision model as an env uses it. The models of ``dsnn`` satisfy this protocol."""

    def step(self, frame: npt.NDArray[np.uint8]) -> ModelResponse:
        """Respond to the next frame, (R, C) uint8."""
        ...

    def reset(self) -> None:
        """Return to the state before the first frame."""
        ...


def build_model(model: Any, shape: tuple[int, int]) -> Model:
    """Build the vision model of the neural observations. Its answers are checked at every frame.

    Parameters
    ----------
    model
        The name of a registered model, the path of a .py file that declares ``MODEL``, an entry such as that
        ``MODEL``, or a factory that is called with ``shape``, the tuple (rows, columns), as its only argument.
    shape
        Rows and columns of the frames.

    Returns
    -------
    Model
        A new model, before its first frame.

    Raises
    ------
    ValueError
        If the name is unknown, the file declares no model, or ``model`` is none of the above.
    """
    built: Model = importlib.import_module(WIRING).build(model, shape)
    return built
