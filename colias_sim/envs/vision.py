"""Sight of an agent: the camera's last frame, the vision model's answers, and the observation made of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from colias_sim.envs.models import Model, ModelResponse, build_model
from colias_sim.envs.observations import neural_observation
from colias_sim.envs.options import EnvOptions

if TYPE_CHECKING:
    from colias_sim.camera import Camera


class Vision:
    """The frames of an env's camera, and what its vision model answers to them.

    Parameters
    ----------
    options
        The env's arguments.
    shape
        Rows and columns of the camera.

    Attributes
    ----------
    luma
        The last frame, (R, C) uint8, read-only; zeros before the first.
    model
        The vision model of neural observations; ``None`` with other observations.
    answers
        The model's answers to the frames since the last `forget`.

    Raises
    ------
    ValueError
        If the vision model cannot be built from ``options.model``.
    """

    def __init__(self, options: EnvOptions, shape: tuple[int, int]) -> None:
        model = build_model(options.model, shape)  # built even if unused, so that a wrong name is an error
        self._kind = options.observation
        self.model: Model | None = model if self._kind in ("neural", "both") else None
        self.luma: npt.NDArray[np.uint8] = np.zeros(shape, np.uint8)
        self.luma.flags.writeable = False
        self.answers: list[ModelResponse] = []

    @property
    def answer(self) -> ModelResponse | None:
        """The model's answer to the last frame; ``None`` without a model."""
        return self.answers[-1] if self.answers else None

    def forget(self) -> None:
        """Forget the answers; the last frame stays."""
        self.answers = []

    def begin(self, film: np.random.Generator) -> None:
        """Begin an episode, whose camera draws from ``film``."""
        self._film = film
        if self.model is not None:
            self.model.reset()

    def look(self, camera: Camera, time: float) -> None:
        """Take the frame that the camera has exposed by ``time``, in s, and ask the model."""
        frame = camera.develop(self._film, time)
        self.luma = frame.luma
        if self.model is not None:
            self.answers.append(self.model.step(frame.luma))

    def observation(self) -> Any:
        """Return the observation ``pixels``, ``neural`` or ``both`` of the frames since the last `forget`."""
        if self._kind == "neural":
            return neural_observation(self.answers)
        pixels = self.luma[..., None].copy()  # a copy, which the agent may write to
        return pixels if self._kind == "pixels" else {"pixels": pixels, "neural": neural_observation(self.answers)}
