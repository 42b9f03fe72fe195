"""The shape of a robot as simple solids, for viewers other than MuJoCo's."""

from __future__ import annotations

from functools import lru_cache
from typing import Any, Literal

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.scene import COLLISION_GROUP, robot_spec

Kind = Literal["cylinder", "box", "ellipsoid"]
KINDS: dict[int, Kind] = {
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "ellipsoid",
}


SOLID = np.dtype([("half_size", float, 3), ("centre", float, 3), ("turn", float, 4), ("colour", np.uint8, 3)])
"""A solid in the robot's own axes: x ahead, y to the left, z up from the floor.

``half_size``: half its extents along its own axes, in metres; for a cylinder: radius, radius, half the height.
``centre``: in metres. ``turn``: its orientation, a quaternion (x, y, z, w). ``colour``: RGB, 0 to 255.
"""


@lru_cache(maxsize=32)
def robot_shapes(variant: str, scene: SceneConfig) -> dict[Kind, npt.NDArray[np.void]]:
    """List the visible solids of a robot, without transparent and collision-only ones.

    Parameters
    ----------
    variant
        One of `scenes.ROBOTS`.
    scene
        Settings, including the look of the robot's shell.

    Returns
    -------
    dict of str to ndarray
        Kind -> its solids, (N,) with the fields of `SOLID`: those of the body, then of the wheels.
    """
    model = robot_spec(variant, RobotConfig(), CameraConfig(), scene).compile()
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    base = model.body("base").id
    drawn = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] and _visible(model, geom)]
    solids: dict[Kind, list[tuple[Any, ...]]] = {}
    for geom in drawn:
        solid = _solid(model, data, geom, data.xpos[base])
        solids.setdefault(KINDS[int(model.geom_type[geom])], []).append(solid)
    return {kind: np.array(ones, SOLID) for kind, ones in solids.items()}


def _visible(model: mujoco.MjModel, geom: int) -> bool:
    return (
        model.geom_group[geom] != COLLISION_GROUP and _rgba(model, geom)[3] > 0 and int(model.geom_type[geom]) in KINDS
    )


def _rgba(model: mujoco.MjModel, geom: int) -> list[float]:
    material = model.geom_matid[geom]
    return [float(part) for part in (model.mat_rgba[material] if material >= 0 else model.geom_rgba[geom])]


def _solid(model: mujoco.MjModel, data: mujoco.MjData, geom: int, origin: np.ndarray) -> tuple[Any, ...]:
    """Return the fields of a geom as a `SOLID`."""
    half = model.geom_size[geom].copy()
    if model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_CYLINDER):
        half[1:] = half[:2]
    elif model.geom_type[geom] == int(mujoco.mjtGeom.mjGEOM_SPHERE):
        half[:] = half[0]
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, data.geom_xmat[geom])
    colour = [round(255 * part) for part in _rgba(model, geom)[:3]]
    return half, data.geom_xpos[geom] - origin, np.roll(quaternion, -1), colour
