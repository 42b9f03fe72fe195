"""All lamps of a scene, for a camera that sees them stronger or weaker than they are."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import mujoco
import numpy as np
import numpy.typing as npt


class Lamps:
    """The lamps of a model and its headlight.

    A camera's gain and exposure time scale the light before OpenGL rounds it to 8 bits. What materials emit is not
    scaled; the materials of this package's scenes emit nothing.

    Parameters
    ----------
    model
        The compiled scene.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        headlight = model.vis.headlight
        self._every: tuple[npt.NDArray[np.float32], ...] = (
            model.light_ambient, model.light_diffuse, model.light_specular,
            headlight.ambient, headlight.diffuse, headlight.specular,
        )  # fmt: skip
        self.look()

    def look(self) -> None:
        """Notice which of the lamps' colours are not black: the others need no scaling."""
        self._lit = [colours for colours in self._every if colours.any()]

    @contextmanager
    def scaled(self, factor: float) -> Iterator[None]:
        """Make the light ``factor`` times what it is, and afterwards what it was, to the bit."""
        before = [colours.copy() for colours in self._lit]
        for colours in self._lit:
            colours *= np.float32(factor)
        try:
            yield
        finally:
            for colours, plain in zip(self._lit, before, strict=True):
                colours[:] = plain
