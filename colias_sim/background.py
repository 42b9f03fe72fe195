"""The part of a picture that has to be rendered anew, where a camera and all that stands behind the robots are
still.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig

STILL = 1e-6
"""Largest distance of a camera at rest from the picture's, in m and in rotation: a robot at rest is never quite so."""
NEAR_M = 0.005
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True, slots=True)
class Box:
    """A part of the picture in camera pixels, rows counted from the *bottom*."""

    rows: range
    columns: range

    def around(self, other: Box) -> Box:
        """Return the smallest box around both."""
        return Box(_around(self.rows, other.rows), _around(self.columns, other.columns))

    def times(self, down: int, across: int) -> tuple[range, range]:
        """Return its rows and columns in a render with ``down`` x ``across`` pixels for each of the camera's."""
        rows, columns = self.rows, self.columns
        return range(rows.start * down, rows.stop * down), range(columns.start * across, columns.stop * across)


def from_above(rows: range, height: int) -> slice:
    """Index the same rows in a picture whose first row is the uppermost."""
    return slice(height - rows.stop, height - rows.start)


def slice_of(columns: range) -> slice:
    """Index the columns in a picture."""
    return slice(columns.start, columns.stop)


class Background:
    """Tells what has to be rendered anew since the last picture.

    Parameters
    ----------
    model
        The compiled scene.
    camera
        Index of the camera in the scene.
    config
        The camera's settings.
    option
        What is drawn.
    """

    def __init__(self, model: mujoco.MjModel, camera: int, config: CameraConfig, option: mujoco.MjvOption) -> None:
        self._model, self._camera, self._config = model, camera, config
        drawn = np.array([bool(option.geomgroup[group]) for group in model.geom_group])
        moves = model.body_weldid[model.geom_bodyid] != 0
        self._moving, self._still = np.flatnonzero(drawn & moves), np.flatnonzero(drawn & ~moves)
        aabb = model.geom_aabb[self._moving]
        self._corners = aabb[:, None, :3] + _CORNERS * aabb[:, None, 3:]
        self._seen: npt.NDArray[np.float64] | None = None
        self._box = self._whole = Box(range(config.height), range(config.width))

    def forget(self) -> None:
        """Have everything rendered anew the next time."""
        self._seen = None

    def changed(self, data: mujoco.MjData) -> Box:
        """Find a box around all that may have changed since the last call.

        Parameters
        ----------
        data
            State of the scene.

        Returns
        -------
        Box
            Around the robots that can move, where they are and where they were; the whole picture where camera, lamps
            or background are not as they were.
        """
        now, box = self._view(data), self._around_robots(data)
        before, self._box = self._box, box
        if self._seen is None or np.abs(now - self._seen).max() > STILL:
            self._seen = now
            return self._whole
        return box.around(before)

    def _view(self, data: mujoco.MjData) -> npt.NDArray[np.float64]:
        """Return all that the picture depends on, but for the robots that can move."""
        model, still = self._model, self._still
        parts = (
            data.cam_xpos[self._camera], data.cam_xmat[self._camera], data.geom_xpos[still], data.geom_xmat[still],
            data.light_xdir, model.light_ambient, model.light_diffuse, model.light_specular, model.geom_rgba,
            model.mat_rgba,
        )  # fmt: skip
        return np.concatenate([np.ravel(part) for part in parts])

    def _around_robots(self, data: mujoco.MjData) -> Box:
        turned = np.einsum("gij,gkj->gki", data.geom_xmat[self._moving].reshape(-1, 3, 3), self._corners)
        away = (turned + data.geom_xpos[self._moving, None] - data.cam_xpos[self._camera]).reshape(-1, 3)
        right, up, back = (away @ data.cam_xmat[self._camera].reshape(3, 3)).T
        config = self._config
        ahead = back < -NEAR_M
        if not ahead.any():
            return Box(range(0), range(0))
        if not ahead.all():
            corners_ahead = ahead.reshape(len(self._moving), -1)
            if (corners_ahead.any(1) & ~corners_ahead.all(1)).any():
                return self._whole  # beside the lens
            right, up, back = right[ahead], up[ahead], back[ahead]
        scale = config.focal_px / -back
        return Box(_span(up * scale, config.height), _span(right * scale, config.width))


def _span(off_axis: npt.NDArray[np.float64], size: int) -> range:
    """Return the pixels from the least to the greatest distance from the axis, and one more at either side."""
    low, high = np.floor(off_axis.min() + size / 2) - 1, np.ceil(off_axis.max() + size / 2) + 1
    return range(int(np.clip(low, 0, size)), int(np.clip(high, 0, size)))


def _around(one: range, other: range) -> range:
    if not one or not other:
        return one or other
    return range(min(one.start, other.start), max(one.stop, other.stop))
