"""Render an env for people: pictures of the scene, or MuJoCo's viewer on the screen."""

from __future__ import annotations

import atexit
import copy
import math
import threading
import weakref
from collections.abc import Collection, Mapping
from typing import Any

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.envs.geometry import ARENA_RADIUS, HULL_RADIUS
from colias_sim.envs.options import EnvOptions
from colias_sim.envs.world import OBSERVER, TARGET
from colias_sim.gl import GLUnavailable, has_screen
from colias_sim.offscreen import Offscreen
from colias_sim.pose import Pose
from colias_sim.simulation import Simulation

Picture = npt.NDArray[np.uint8]
Vector = npt.NDArray[np.float64]
View = tuple[mujoco.MjvCamera, tuple[int, int, int, int]]
"""A camera, and the rectangle of the picture that it fills: left, bottom, width and height, in pixels."""

FOVY_DEG = 32.0
"""Vertical field of view of the views on the whole arena, in degrees."""
HALF = math.tan(math.radians(FOVY_DEG / 2))
"""Half the height of the picture at a depth of 1."""
ELEVATIONS_DEG: Mapping[str, float] = {"arena": -42.0, "top": -90.0}
WALL_SHOWN = 0.13
"""Least visible height of the wall in a view of the whole arena, in metres."""
MARGIN = 0.97
"""The share of the picture that the arena fills in its tighter direction."""
LEAST_INSET_WIDTH = 200
"""Least width of a picture, in pixels, for insets in the view ``arena`` and for the scale bar."""
INSET_SHARE, LEAST_INSET_SHARE = 0.26, 0.1
"""Largest and smallest width of an inset, as a share of the picture's width. Smaller insets are omitted."""
ROBOT_SHOWN = 0.035
"""Height of a robot over the floor, in metres. Insets cover nothing below it."""
SCALE_M, SCALE_GREY = 0.10, 245
"""Length of the scale bar, and its grey level."""
FRAME = 60
"""Grey level of the line around an inset."""
CLOSE_M, CLOSE_ELEVATION_DEG = 0.13, -32.0
"""Distance and elevation of the close view of the observer."""

GROUND_RGBA = (0.42, 0.44, 0.47, 1.0)
MARKERS: Mapping[str, tuple[float, float, float]] = {OBSERVER: (0.05, 0.60, 0.30), TARGET: (0.95, 0.45, 0.0)}
OTHER_MARKER = 0.25, 0.35, 0.75
MARKER_RADIUS, MARKER_ALPHA = 0.036, 0.45
"""Radius, in metres, and opacity of a marker, a disc on the floor under a robot."""
ARROW_LENGTH, ARROW_WIDTH = 0.07, 0.005


class Renderer:
    """Shows a simulation as pictures or in a window, which opens with the first episode (``options.render_mode``).

    Parameters
    ----------
    sim
        The simulation to show.
    options
        The env's options; ``render_mode`` is not ``None``.
    name
        Name of the robot that is the observer.

    Raises
    ------
    colias_sim.GLUnavailable
        No OpenGL backend works, or mode ``human`` has no screen.
    """

    def __init__(self, sim: Simulation, options: EnvOptions, name: str) -> None:
        self._sim, self._name = sim, name
        self._viewer: Any = None
        self._shut: Any = None
        self._offscreen: Offscreen | None = None
        if options.render_mode == "human":
            if not has_screen():
                raise GLUnavailable("no screen to open a window on (DISPLAY is not set): use render_mode='rgb_array'")
            return
        self._views = views(sim.model, name, options.render_view, options.render_width, options.render_height)
        self._floor = sim.model.geom("floor").id
        self._offscreen = Offscreen(sim.model, options.render_height, options.render_width)

    def copy(self, sim: Simulation) -> Renderer:
        """Make a twin that shows a copy of the simulation: it shares the OpenGL context, or opens its own window."""
        twin = copy.copy(self)
        twin._sim, twin._viewer, twin._shut = sim, None, None
        twin._offscreen = None if self._offscreen is None else self._offscreen.copy(sim.model)
        return twin

    def show(self) -> None:
        """Show the state after a reset or a step in the window, if there is one."""
        if self._offscreen is not None:
            return
        if self._viewer is None:
            import mujoco.viewer

            before = set(threading.enumerate())
            self._viewer = mujoco.viewer.launch_passive(
                self._sim.model, self._sim.data, show_left_ui=False, show_right_ui=False
            )
            # Also at exit, before GLFW ends: a viewer's thread that is alive after that is a segmentation fault.
            self._shut = weakref.finalize(self, _shut, self._viewer, set(threading.enumerate()) - before)
            self._shut.atexit = False
            atexit.register(self._shut)
        self._viewer.sync()

    def picture(self) -> Picture | None:
        """Draw the scene.

        Returns
        -------
        ndarray or None
            A picture, (H, W, 3) uint8; ``None`` if the window shows the scene.
        """
        if self._offscreen is None:
            return None
        mujoco.mj_kinematics(self._sim.model, self._sim.data)
        mujoco.mj_camlight(self._sim.model, self._sim.data)
        poses = self._sim.poses

        def dressed(scene: mujoco.MjvScene) -> None:
            dress(scene, self._floor, poses, self._sim.robots)

        (whole, _), *insets = self._views
        if insets:
            close, _ = insets[0]
            here = poses[self._name]
            close.lookat[:] = here.x, here.y, 0.012
            close.azimuth = math.degrees(here.heading)
        for eye, rect in self._views:
            dressing = dressed if _for_people(eye) else None
            self._offscreen.draw_into(rect, self._sim.data, eye, dressing)
        picture = np.flipud(self._offscreen.read_all()).copy()
        for _, rect in insets:
            _draw_frame(picture, rect)
        if _for_people(whole) and picture.shape[1] >= LEAST_INSET_WIDTH:
            _draw_scale(picture, whole)
        return picture

    def retexture(self, texture: int) -> None:
        """Upload the model's texture of this index again after a change."""
        if self._offscreen is not None:
            self._offscreen.retexture(texture)
        if self._viewer is not None:
            self._viewer.update_texture(texture)

    def close(self) -> None:
        """Free the context, or close the window."""
        if self._offscreen is not None:
            self._offscreen.close()
        if self._shut is not None:
            self._shut()
            atexit.unregister(self._shut)


def _shut(viewer: Any, threads: set[threading.Thread]) -> None:
    """Close the window and wait until its threads have ended."""
    viewer.close()
    for thread in threads:
        thread.join(timeout=5.0)


# Views: where a picture is taken from.


def _for_people(eye: mujoco.MjvCamera) -> bool:
    """Whether markers and ground are drawn, which the robot's camera never sees."""
    return bool(eye.type == mujoco.mjtCamera.mjCAMERA_FREE.value)


def views(model: mujoco.MjModel, name: str, view: str, width: int, height: int) -> tuple[View, ...]:
    """Lay out a picture of an env.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the robot that is the observer.
    view
        ``arena``: the whole arena from above at an angle. A wide picture has insets with the observer and its camera's
        view, which cover neither floor nor robots. ``top``: the whole arena from straight above. ``observer``: only the
        observer's camera.
    width, height
        Size of the picture, in pixels.

    Returns
    -------
    tuple of View
        The views in the order of drawing: the whole picture, then the two insets: the
        one that follows the observer, and its camera's.
    """
    own = mujoco.MjvCamera()
    own.type, own.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera(f"{name}/eye").id
    whole = 0, 0, width, height
    if view == "observer":
        return ((own, whole),)
    model.vis.global_.fovy = FOVY_DEG  # for free cameras; the robot's own camera has another
    arena = _whole_arena(ELEVATIONS_DEG[view], width / height)
    size = _inset_size(arena, width, height) if view == "arena" and width >= LEAST_INSET_WIDTH else None
    if size is None:
        return ((arena, whole),)
    top = height - size[1]
    close = _free_eye(CLOSE_ELEVATION_DEG, CLOSE_M)
    return (arena, whole), (close, (0, top, *size)), (own, (width - size[0], top, *size))


def _free_eye(elevation_deg: float, distance: float) -> mujoco.MjvCamera:
    """Make a free camera that looks along +y from above."""
    eye = mujoco.MjvCamera()
    eye.type, eye.azimuth = mujoco.mjtCamera.mjCAMERA_FREE.value, 90.0
    eye.elevation, eye.distance = elevation_deg, distance
    return eye


def _projected(eye: mujoco.MjvCamera, points: Vector) -> tuple[Vector, Vector, Vector]:
    """Project points (N, 3) to a free camera's picture: right and up in halves of its height, and depth in m."""
    down = math.radians(-eye.elevation)
    upward = np.array([0.0, math.sin(down), math.cos(down)])
    forward = np.array([0.0, math.cos(down), -math.sin(down)])
    rays = points - (np.array([0.0, eye.lookat[1], 0.0]) - eye.distance * forward)
    depth = rays @ forward
    return rays[:, 0] / depth / HALF, rays @ upward / depth / HALF, depth


def _rim(height: float) -> Vector:
    """Sample points around the arena at a height, (N, 3), in metres."""
    turn = np.linspace(0.0, 2 * np.pi, 361)
    return np.column_stack([ARENA_RADIUS * np.cos(turn), ARENA_RADIUS * np.sin(turn), np.full_like(turn, height)])


def _whole_arena(elevation_deg: float, aspect: float) -> mujoco.MjvCamera:
    """Find the nearest free camera with the whole floor and some of the wall in the picture."""
    wall = _rim(WALL_SHOWN if elevation_deg > -90.0 else 0.04)
    shown = np.vstack([_rim(0.0), wall[wall[:, 1] > 0.0] if elevation_deg > -90.0 else wall])
    near, far = 0.5, 20.0
    for _ in range(40):
        eye = _free_eye(elevation_deg, (near + far) / 2)
        for _ in range(12):
            across, up, depth = _projected(eye, shown)
            if depth.min() <= 0.0:
                break
            middle = (up.max() + up.min()) / 2
            eye.lookat[1] += middle * HALF * eye.distance / max(math.sin(math.radians(-elevation_deg)), 0.2)
        fits = depth.min() > 0.0 and max(np.abs(up).max(), np.abs(across).max() / aspect) <= MARGIN
        near, far = (near, eye.distance) if fits else (eye.distance, far)
    return eye


def _inset_size(eye: mujoco.MjvCamera, width: int, height: int) -> tuple[int, int] | None:
    """Find the largest insets in the upper corners that cover neither floor nor robot; ``None`` without room."""
    across, up, _ = _projected(eye, np.vstack([_rim(0.0), _rim(ROBOT_SHOWN)]))
    columns, rows = (width + across * height) / 2, (1 - up) * height / 2  # from the upper left corner
    for wide in range(round(INSET_SHARE * width), round(LEAST_INSET_SHARE * width), -1):
        high = min(round(wide * 72 / 99), round(0.3 * height))
        if not ((np.minimum(columns, width - columns) < wide + 1) & (rows < high + 1)).any():
            return wide, high
    return None


# What is drawn for people alone.


def dress(scene: mujoco.MjvScene, floor: int, poses: Mapping[str, Pose], driven: Collection[str]) -> None:
    """Add ground around the round floor, and a marker under each robot, for people.

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
    _add(scene, mujoco.mjtGeom.mjGEOM_PLANE, (30.0, 30.0, 0.1), (0.0, 0.0, -0.006), np.array(GROUND_RGBA))
    for name, pose in poses.items():
        tint = np.array([*MARKERS.get(name, OTHER_MARKER), MARKER_ALPHA])
        _disc(scene, (pose.x, pose.y, 0.0006), MARKER_RADIUS, tint)
        if name in driven:
            ahead = np.array([math.cos(pose.heading), math.sin(pose.heading), 0.0])
            start = np.array([pose.x, pose.y, 0.005]) + HULL_RADIUS * ahead  # from the rim of the hull
            arrow = _add(scene, mujoco.mjtGeom.mjGEOM_ARROW, (0.0,) * 3, (0.0,) * 3, np.array([*tint[:3], 1.0]))
            end = start + ARROW_LENGTH * ahead
            mujoco.mjv_connector(arrow, mujoco.mjtGeom.mjGEOM_ARROW.value, ARROW_WIDTH, start, end)


def _disc(scene: mujoco.MjvScene, place: tuple[float, float, float], radius: float, rgba: Vector) -> None:
    _add(scene, mujoco.mjtGeom.mjGEOM_CYLINDER, (radius, 0.0004, 0.0), place, rgba)


def _add(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, size: tuple[float, ...], place: tuple[float, ...], rgba: Vector
) -> mujoco.MjvGeom:
    """Add a geom to a scene."""
    geom = scene.geoms[scene.ngeom]
    scene.ngeom += 1
    turn = np.eye(3).ravel()
    mujoco.mjv_initGeom(geom, kind.value, np.array(size), np.array(place), turn, rgba.astype(np.float32))
    return geom


def _draw_frame(picture: Picture, rect: tuple[int, int, int, int]) -> None:
    """Draw a line around an inset into a picture (H, W, 3), top row first."""
    left, bottom, width, height = rect
    top = picture.shape[0] - bottom - height
    cv2.rectangle(picture, (left, top), (left + width - 1, top + height - 1), (FRAME,) * 3)


def _draw_scale(picture: Picture, eye: mujoco.MjvCamera) -> None:
    """Draw a bar of `SCALE_M` and its length into a picture (H, W, 3) of the whole arena.

    It lies on the ground outside the floor, at the depth of the floor's nearest point.
    """
    height, width, _ = picture.shape
    _, up, depth = _projected(eye, np.array([[0.0, -ARENA_RADIUS, 0.0]]))
    per_metre = height / 2 / float(depth[0]) / HALF
    start = max(0.03 * width, width / 2 - ARENA_RADIUS * per_metre)
    left, right, row = round(start), round(start + SCALE_M * per_metre), round((1 - float(up[0])) * height / 2)
    for grey, extra in ((FRAME, 2), (SCALE_GREY, 0)):  # with an outline, to be visible on any ground
        tint, rim = (grey, grey, grey), extra // 2
        cv2.rectangle(picture, (left - rim, row - 2 - rim), (right + rim, row + rim), tint, -1)
        font, place = cv2.FONT_HERSHEY_SIMPLEX, (left, max(row - 6, 0))
        cv2.putText(picture, f"{100 * SCALE_M:g} cm", place, font, width / 1000, tint, 1 + extra, cv2.LINE_AA)
