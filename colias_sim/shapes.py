"""The shape of a robot as simple solids, for viewers other than MuJoCo's."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import mujoco
import numpy as np

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.scene import COLLISION_GROUP, robot_spec

Vector = tuple[float, float, float]
Kind = Literal["cylinder", "box", "ellipsoid"]
KINDS: dict[int, Kind] = {
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "ellipsoid",
}


@dataclass(frozen=True, slots=True)
class Shape:
    """A solid of a robot, in the robot's own axes: x ahead, y to the left, z up from the floor.

    Parameters
    ----------
    kind
        The kind of solid.
    half_size
        Half its extents along its own axes, in metres. For a cylinder: radius, radius, half the height.
    centre
        Its centre, in metres.
    turn
        Its orientation, a quaternion (x, y, z, w).
    colour
        Its colour, RGB, 0 to 255.
    """

    kind: Kind
    half_size: Vector
    centre: Vector
    turn: tuple[float, float, float, float]
    colour: tuple[int, int, int]


@lru_cache(maxsize=32)
def robot_shapes(variant: str, scene: SceneConfig) -> tuple[Shape, ...]:
    """List the visible solids of a robot, without transparent and collision-only ones.

    Parameters
    ----------
    variant
        One of `scenes.ROBOTS`.
    scene
        Settings, including the look of the robot's shell.

    Returns
    -------
    tuple of Shape
        The solids of the body, then of the wheels.
    """
    model = robot_spec(variant, RobotConfig(), CameraConfig(), scene).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = model.body("base").id
    drawn = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] and _visible(model, geom)]
    return tuple(_shape(model, data, geom, data.xpos[base]) for geom in drawn)


def _visible(model: mujoco.MjModel, geom: int) -> bool:
    return (
        model.geom_group[geom] != COLLISION_GROUP and _rgba(model, geom)[3] > 0 and int(model.geom_type[geom]) in KINDS
    )


def _rgba(model: mujoco.MjModel, geom: int) -> list[float]:
    material = model.geom_matid[geom]
    return [float(part) for part in (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])]


def _shape(model: mujoco.MjModel, data: mujoco.MjData, geom: int, origin: np.ndarray) -> Shape:
    kind = KINDS[int(model.geom_type[geom])]
    x, y, z = (float(part) for part in model.geom_size[geom])
    if kind == "cylinder":
        half = x, x, y
    else:
        half = (x, x, x) if model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_SPHERE) else (x, y, z)
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, data.geom_xmat[geom])
    w, *turn = (float(part) for part in quaternion)
    centre = [float(part) for part in data.geom_xpos[geom] - origin]
    red, green, blue = (round(255 * part) for part in _rgba(model, geom)[:3])
    return Shape(kind, half, (centre[0], centre[1], centre[2]), (turn[0], turn[1], turn[2], w), (red, green, blue))
