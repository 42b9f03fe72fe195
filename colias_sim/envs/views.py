"""Places that pictures of an env are taken from, and things drawn in them for people alone: markers, ground, insets."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.envs.geometry import ARENA_RADIUS, HULL_RADIUS
from colias_sim.envs.world import OBSERVER, TARGET
from colias_sim.pose import Pose

Vector = npt.NDArray[np.float64]
FOVY_DEG = 32.0
"""Vertical field of view of the views on the whole arena, in degrees."""
ELEVATIONS_DEG: Mapping[str, float] = {"arena": -42.0, "top": -90.0}
WALL_SHOWN = 0.13
"""Least height of the wall that a view on the whole arena has in it, in metres."""
MARGIN = 0.97
"""The share of the picture that the arena fills in its tighter direction."""
LEAST_INSET_WIDTH = 200
"""Width of a picture, in pixels, from which the view ``arena`` has insets."""
INSET_SHARE, LEAST_INSET_SHARE = 0.26, 0.1
"""Width of an inset, as a share of the picture's: as large as it may be, and so small that it is left out."""
ROBOT_SHOWN = 0.035
"""Height over the floor, in metres, below which nothing is covered by an inset: that of a robot."""
SCALE_M = 0.10
"""Length of the scale."""
FRAME = 60
"""Grey level of the line around an inset."""
CLOSE_M, CLOSE_ELEVATION_DEG = 0.13, -32.0
"""Distance and elevation of the close view on the observer."""

GROUND_RGBA = (0.42, 0.44, 0.47, 1.0)
MARKERS: Mapping[str, tuple[float, float, float]] = {OBSERVER: (0.05, 0.60, 0.30), TARGET: (0.95, 0.45, 0.0)}
OTHER_MARKER = 0.25, 0.35, 0.75
MARKER_RADIUS, MARKER_ALPHA = 0.036, 0.45
"""A marker is a disc on the floor under a robot; radius in metres."""
ARROW_LENGTH, ARROW_WIDTH = 0.07, 0.005


@dataclass(frozen=True, slots=True)
class View:
    """A camera and the rectangle of the picture that it fills.

    Parameters
    ----------
    eye
        The camera.
    rect
        Left, bottom, width and height, in pixels.
    people
        Whether markers and ground are drawn; the robot's own eye sees neither.
    """

    eye: mujoco.MjvCamera
    rect: tuple[int, int, int, int]
    people: bool


def views(model: mujoco.MjModel, view: str, width: int, height: int) -> tuple[View, ...]:
    """Lay out a picture of an env.

    Parameters
    ----------
    model
        The compiled scene.
    view
        ``arena``: all of it from above at an angle, with insets of the observer and of what its eye sees where the
        picture is wide enough; they cover neither floor nor robots. ``top``: all of it from straight above.
        ``observer``: the observer's eye alone.
    width, height
        Size of the picture, in pixels.

    Returns
    -------
    tuple of View
        In the order in which they are drawn.
    """
    whole = 0, 0, width, height
    if view == "observer":
        return (View(_own_eye(model), whole, False),)
    model.vis.global_.fovy = FOVY_DEG  # that of free cameras; the robot's own eye has another
    candidates = [View(_whole_arena(ELEVATIONS_DEG[view], width / height), whole, True)]
    if view == "arena" and width >= LEAST_INSET_WIDTH:
        for size in _inset_sizes(candidates[0].eye, width, height):
            top = height - size[1]
            candidates.append(View(_close(), (0, top, *size), True))
            candidates.append(View(_own_eye(model), (width - size[0], top, *size), False))
    return tuple(candidates)


def scale_of(view: View) -> tuple[float, float, float]:
    """Return where the scale is in the picture: its left and right end, and its row from the top, px.

    It lies on the ground beside the floor, at the depth of the floor's nearest point.

    Parameters
    ----------
    view
        On the whole arena.
    """
    _, _, width, height = view.rect
    _, up, depth = _seen_at(view.eye, np.array([[0.0, -ARENA_RADIUS, 0.0]]))
    per_metre = height / 2 / float(depth[0]) / math.tan(math.radians(FOVY_DEG / 2))
    left = max(0.03 * width, width / 2 - ARENA_RADIUS * per_metre)
    return left, left + SCALE_M * per_metre, (1 - float(up[0])) * height / 2


def _seen_at(eye: mujoco.MjvCamera, points: Vector) -> tuple[Vector, Vector, Vector]:
    """Project points (N, 3): to the right and up of a free camera's middle, halves of the picture's height; depth, m.

    The camera looks along +y, from above.
    """
    back = math.radians(-eye.elevation)
    upward = np.array([0.0, math.sin(back), math.cos(back)])
    forward = np.array([0.0, math.cos(back), -math.sin(back)])
    rays = points - (np.array([0.0, eye.lookat[1], 0.0]) - eye.distance * forward)
    depth, half = rays @ forward, math.tan(math.radians(FOVY_DEG / 2))
    return rays[:, 0] / depth / half, rays @ upward / depth / half, depth


def _inset_sizes(eye: mujoco.MjvCamera, width: int, height: int) -> list[tuple[int, int]]:
    """Return the largest size of insets in the upper corners that cover neither floor nor robot; none: no room."""
    turn = np.linspace(0.0, 2 * np.pi, 361)
    ring = np.column_stack([ARENA_RADIUS * np.cos(turn), ARENA_RADIUS * np.sin(turn), np.zeros_like(turn)])
    across, up, _ = _seen_at(eye, np.vstack([ring, ring + np.array([0.0, 0.0, ROBOT_SHOWN])]))
    columns, rows = (width + across * height) / 2, (1 - up) * height / 2  # from the upper left corner
    for wide in range(round(INSET_SHARE * width), round(LEAST_INSET_SHARE * width), -1):
        high = min(round(wide * 72 / 99), round(0.3 * height))
        if not ((np.minimum(columns, width - columns) < wide + 1) & (rows < high + 1)).any():
            return [(wide, high)]
    return []


def follow(view: View, observer: Pose) -> None:
    """Turn the close view to where the observer is now; other views stay."""
    eye = view.eye
    if eye.type == mujoco.mjtCamera.mjCAMERA_FREE.value and eye.distance == CLOSE_M:
        eye.lookat[:] = observer.x, observer.y, 0.012
        eye.azimuth = math.degrees(observer.heading)


def dress(scene: mujoco.MjvScene, floor: int, poses: Mapping[str, Pose], driven: Collection[str]) -> None:
    """Add to a scene what people need: ground around the round floor, and a marker under each robot.

    Parameters
    ----------
    scene
        The scene, updated for its camera. The square floor is replaced by a round one and ground around it.
    floor
        Index of the floor's geom.
    poses
        The pose of every robot, by name.
    driven
        The robots with wheels: their markers have an arrow along the heading.
    """
    for geom in scene.geoms[: scene.ngeom]:
        if geom.objtype == mujoco.mjtObj.mjOBJ_GEOM.value and geom.objid == floor:
            colour = np.array(geom.rgba)
            geom.type = mujoco.mjtGeom.mjGEOM_NONE.value
            _disc(scene, (0.0, 0.0, -0.002), ARENA_RADIUS, colour)
            break
    _add(scene, mujoco.mjtGeom.mjGEOM_PLANE, (30.0, 30.0, 0.1), (0.0, 0.0, -0.006), np.eye(3), np.array(GROUND_RGBA))
    for name, pose in poses.items():
        tint = np.array([*MARKERS.get(name, OTHER_MARKER), MARKER_ALPHA])
        _disc(scene, (pose.x, pose.y, 0.0006), MARKER_RADIUS, tint)
        tint[3] = 1.0
        if name in driven:
            _arrow(scene, pose, tint)


def framed(picture: npt.NDArray[np.uint8], insets: Sequence[View]) -> npt.NDArray[np.uint8]:
    """Draw a line around each inset into a picture (H, W, 3), bottom row first; return the picture."""
    for left, bottom, width, height in (view.rect for view in insets):
        rows, columns = slice(bottom, bottom + height), slice(left, left + width)
        picture[rows, [left, left + width - 1]] = FRAME
        picture[[bottom, bottom + height - 1], columns] = FRAME
    return picture


def _whole_arena(elevation_deg: float, aspect: float) -> mujoco.MjvCamera:
    """Return the nearest free camera that has the whole floor in the picture, and some of the wall."""
    eye = mujoco.MjvCamera()
    eye.type = mujoco.mjtCamera.mjCAMERA_FREE.value
    eye.azimuth, eye.elevation = 90.0, elevation_deg
    turn = np.linspace(0.0, 2 * np.pi, 73)
    floor = np.column_stack([ARENA_RADIUS * np.cos(turn), ARENA_RADIUS * np.sin(turn), np.zeros_like(turn)])
    raised = floor + np.array([0.0, 0.0, WALL_SHOWN if elevation_deg > -90.0 else 0.04])
    seen = np.vstack([floor, raised[raised[:, 1] > 0.0] if elevation_deg > -90.0 else raised])
    near, far = 0.5, 20.0
    for _ in range(40):
        eye.distance = (near + far) / 2
        fits, eye.lookat[1] = _fit(seen, elevation_deg, eye.distance, aspect)
        near, far = (near, eye.distance) if fits else (eye.distance, far)
    eye.distance = far
    return eye


def _fit(points: Vector, elevation_deg: float, distance: float, aspect: float) -> tuple[bool, float]:
    """Tell whether points (N, 3) are in the picture from there, and the y to look at that centres them vertically."""
    up, back = math.radians(90.0 + elevation_deg), math.radians(-elevation_deg)
    upward = np.array([0.0, math.cos(up), math.sin(up)])
    forward = np.array([0.0, math.cos(back), -math.sin(back)])
    half, look = math.tan(math.radians(FOVY_DEG / 2)), 0.0
    for _ in range(12):
        rays = points - (np.array([0.0, look, 0.0]) - distance * forward)
        depth = rays @ forward
        if depth.min() <= 0.0:
            return False, look
        vertical, horizontal = rays @ upward / depth / half, rays[:, 0] / depth / half / aspect
        middle = (vertical.max() + vertical.min()) / 2
        look += middle * half * distance / max(math.cos(up), 0.2)
    return max(np.abs(vertical).max(), np.abs(horizontal).max()) <= MARGIN, look


def _own_eye(model: mujoco.MjModel) -> mujoco.MjvCamera:
    eye = mujoco.MjvCamera()
    eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera(f"{OBSERVER}/eye").id
    return eye


def _close() -> mujoco.MjvCamera:
    eye = mujoco.MjvCamera()
    eye.type = mujoco.mjtCamera.mjCAMERA_FREE.value
    eye.distance, eye.elevation = CLOSE_M, CLOSE_ELEVATION_DEG
    return eye


def _disc(scene: mujoco.MjvScene, place: tuple[float, float, float], radius: float, rgba: Vector) -> None:
    _add(scene, mujoco.mjtGeom.mjGEOM_CYLINDER, (radius, 0.0004, 0.0), place, np.eye(3), rgba)


def _arrow(scene: mujoco.MjvScene, pose: Pose, rgba: Vector) -> None:
    """Add an arrow on the floor from the rim of the hull along the heading."""
    ahead = np.array([math.cos(pose.heading), math.sin(pose.heading), 0.0])
    start = np.array([pose.x, pose.y, 0.005]) + HULL_RADIUS * ahead
    geom = _next(scene)
    if geom is not None:
        mujoco.mjv_initGeom(geom, mujoco.mjtGeom.mjGEOM_ARROW.value, np.zeros(3), np.zeros(3), np.zeros(9),
                            rgba.astype(np.float32))  # fmt: skip
        mujoco.mjv_connector(geom, mujoco.mjtGeom.mjGEOM_ARROW.value, ARROW_WIDTH, start, start + ARROW_LENGTH * ahead)


def _add(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, size: tuple[float, float, float],
    place: tuple[float, float, float], turn: Vector, rgba: Vector,
) -> None:  # fmt: skip
    geom = _next(scene)
    if geom is not None:
        mujoco.mjv_initGeom(geom, kind.value, np.array(size), np.array(place), turn.ravel(), rgba.astype(np.float32))


def _next(scene: mujoco.MjvScene) -> mujoco.MjvGeom | None:
    """Return the scene's next free geom, counted as used; ``None`` when the scene is full."""
    if scene.ngeom >= scene.maxgeom:
        return None
    scene.ngeom += 1
    return scene.geoms[scene.ngeom - 1]
