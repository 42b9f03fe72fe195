"""Find an arena's obstacles: the geoms that hulls collide with, as outlines on the floor."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

Vectors = npt.NDArray[np.float64]

HULL_BOTTOM, HULL_TOP = 0.003, 0.030
"""Lower and upper height of a robot's hull, in metres."""
FENCE = "fence/"
"""Prefix of the names of the geoms that stop hulls at the wall."""
ROUND = 48
"""Number of corners in the outline of a round geom."""
FARTHEST_CM = 64.0
"""Greatest distance of anything from the arena's middle: the corners of a square around the room."""
HIGHEST_CM, DEEPEST_CM = 100.0, -10.0
"""Highest and lowest height of anything in an arena."""


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """A geom that robots' hulls collide with.

    Parameters
    ----------
    name
        The geom's name, or its kind and place.
    outline
        Its convex outline on the floor, (N, 2) in metres, counter-clockwise.
    height
        Height of its top, in metres.
    """

    name: str
    outline: Vectors
    height: float

    @property
    def closed_cm(self) -> Vectors:
        """The outline as a closed line, (N + 1, 2) in cm."""
        return 100 * np.vstack([self.outline, self.outline[:1]])

    def nearest(self, x: float, y: float) -> tuple[float, float, float]:
        """Find the point of the outline that is nearest to a place.

        Parameters
        ----------
        x, y
            The place, in metres.

        Returns
        -------
        distance : float
            Distance to that point, in metres; negative inside the outline.
        there_x, there_y : float
            The point.
        """
        (distance,), ((there_x, there_y),) = self._nearest(np.array([[x, y]]))
        return float(distance), float(there_x), float(there_y)

    def distances(self, places: Vectors) -> Vectors:
        """Measure the distances to several places.

        Parameters
        ----------
        places
            x and y of each, (P, 2) in metres.

        Returns
        -------
        ndarray
            (P,) in metres, negative inside of the outline.
        """
        return self._nearest(places)[0]

    def _nearest(self, places: Vectors) -> tuple[Vectors, Vectors]:
        """Return distances (P,) and nearest points (P, 2)."""
        edges = np.roll(self.outline, -1, axis=0) - self.outline
        way = places[:, None, :] - self.outline
        share = np.clip((way * edges).sum(2) / np.maximum((edges**2).sum(1), 1e-18), 0.0, 1.0)
        points = self.outline + share[:, :, None] * edges
        lengths = np.hypot(*np.moveaxis(places[:, None, :] - points, 2, 0))
        inside = (edges[:, 0] * way[:, :, 1] - edges[:, 1] * way[:, :, 0] > 0.0).all(1)
        which = np.arange(len(places)), lengths.argmin(1)
        return np.where(inside, -lengths[which], lengths[which]), points[which]


def obstacles(model: mujoco.MjModel) -> tuple[Obstacle, ...]:
    """List the obstacles of a compiled scene.

    Parameters
    ----------
    model
        The scene.

    Returns
    -------
    tuple of Obstacle
        Every geom of the arena that collides and is as low as a hull, except the floor and the wall's fence.
    """
    at_hull_height = []
    for geom, points in _placed(model):
        if not model.geom_contype[geom] or model.geom(geom).name == "floor":
            continue
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        if low < HULL_TOP and high > HULL_BOTTOM:
            at_hull_height.append(Obstacle(called(model, geom), outline(points), high))
    return tuple(at_hull_height)


def check_room(model: mujoco.MjModel, source: str, size: float = 1.0) -> None:
    """Check that an arena fits into the room.

    Parameters
    ----------
    model
        The compiled scene.
    source
        The arena, for the message.
    size
        Size of the room as a share of the usual one.

    Raises
    ------
    ValueError
        A geom reaches beyond the room, or is an infinite plane.
    """
    farthest, highest = size * FARTHEST_CM, size * HIGHEST_CM
    for geom, points in _placed(model):
        name = called(model, geom)
        reach = 100 * float(np.hypot(points[:, 0], points[:, 1]).max())
        low, high = 100 * float(points[:, 2].min()), 100 * float(points[:, 2].max())
        inside = reach <= farthest and DEEPEST_CM <= low <= high <= highest
        endless = model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_PLANE
        if name != "floor" and (endless or not inside):
            raise ValueError(
                f"arena {source}: geom {name} must be within {farthest:g} cm of the middle, and {DEEPEST_CM:g} to"
                f" {highest:g} cm high, no plane (MJCF is in metres: 0.05 is 5 cm), got {reach:.4g} cm, and"
                f" {low:.4g} to {high:.4g} cm"
            )


def called(model: mujoco.MjModel, geom: int) -> str:
    """Name a geom for messages: by its name, or by its kind and place."""
    name = str(model.geom(geom).name)
    if name:
        return name
    kind = mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()
    x, y, _ = 100 * model.geom_pos[geom]
    return f"{kind} at ({x:.3g}, {y:.3g}) cm"


def outline(points: Vectors) -> Vectors:
    """Compute the convex outline on the floor of points (N, 3): (M, 2), counter-clockwise."""
    scale = 1e4  # float32 has seven digits: to the micron
    hull = cv2.convexHull((scale * points[:, :2]).astype(np.float32)).reshape(-1, 2).astype(np.float64) / scale
    following = np.roll(hull, -1, axis=0)
    area = (hull[:, 0] * following[:, 1] - hull[:, 1] * following[:, 0]).sum()
    return hull if area >= 0 else hull[::-1].copy()


def _placed(model: mujoco.MjModel) -> Iterator[tuple[int, Vectors]]:
    """Yield the arena's own geoms, each with points of its surface in the room, (N, 3) in metres.

    Names of robots' and the fence's parts contain a ``/``.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for geom in range(model.ngeom):
        if "/" not in model.body(model.geom_bodyid[geom]).name and not model.geom(geom).name.startswith(FENCE):
            points = _surface(model, geom)
            yield geom, points @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom]


def _surface(model: mujoco.MjModel, geom: int) -> Vectors:
    """Return points with the same convex hull as a geom, in its own frame, (N, 3)."""
    kind, size = mujoco.mjtGeom(model.geom_type[geom]), model.geom_size[geom]
    turn = np.linspace(0.0, 2 * math.pi, ROUND, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(ROUND)])
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        return np.asarray(model.mesh_vert[first : first + model.mesh_vertnum[mesh]], np.float64)
    if kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        return np.concatenate([ring * size[0] + [0.0, 0.0, z] for z in (-size[1], size[1])])
    if kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID, mujoco.mjtGeom.mjGEOM_CAPSULE):
        levels = np.linspace(-math.pi / 2, math.pi / 2, ROUND // 2 + 1)
        ball = np.concatenate([ring * math.cos(level) + [0.0, 0.0, math.sin(level)] for level in levels])
        if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
            return np.asarray(ball * size)
        if kind == mujoco.mjtGeom.mjGEOM_SPHERE:
            return np.asarray(ball * size[0])
        return np.concatenate([ball * size[0] + [0.0, 0.0, z] for z in (-size[1], size[1])])
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return np.array(list(itertools.product(*((-half, half) for half in size))))
    return np.zeros((1, 3))
