"""The robots of a trial seen from outside: its arena, posed by its recording, drawn with shading."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import cv2
import mujoco
import numpy as np

from colias_sim import CameraConfig, GLUnavailable, Pose, SceneConfig, Simulation
from colias_sim.offscreen import Offscreen
from experiments.bench.run.streams import stream
from experiments.bench.video.pictures import Floats, Picture
from experiments.bench.video.reading import Reel, Track
from scenes import ARENAS

ASPECT = 11 / 8
"""Width over height of the view, that of the robot's camera."""
LOOKS = ("shell_grey", "wall_contrast")
"""The settings of a scene that a condition of a trial sets."""
LIGHT, AMBIENT, SIDE = 0.62, 0.45, (0.35, 0.45, -0.82)
"""The view's one lamp: those of the arena light all sides equally, which shows no shape."""
DARKEST = 0.13
"""Least reflectance of a surface: a black hull would show no shape either."""
SIGHT_M, SIGHT = 0.24, (1.0, 0.83, 0.25, 0.45)
"""How far the field of view is drawn on the floor, and its colour."""
SHADOW = (0.0, 0.0, 0.0, 0.09)
"""Colour of each of the discs on the floor that are a robot's shadow."""
TURN_DEG, DOWN_DEG, OPENING_DEG, ROOM_M = 24.0, -30.0, 45.0, 0.03
"""The view: its angle to the side of the observer's heading, and downward; its opening; the room about the robots."""
FINER = 2
"""Pixels drawn along each side of a pixel shown, for smooth edges."""


class Outside:
    """The view of a trial's robots from outside, behind the observer, so that left and right are those of its camera.

    Parameters
    ----------
    reel
        A recording for which `can_show` holds.
    height
        Of the pictures, in pixels; their width is `ASPECT` times that.

    Raises
    ------
    colias_sim.GLUnavailable
        Nothing can render.
    ValueError
        The recorded poses are those of no two robots on this floor.
    """

    def __init__(self, reel: Reel, height: int) -> None:
        self._tracks, self._view_deg = reel.tracks, reel.view_deg
        variants = {track.name: "colias" if track.name == "observer" else "colias_black" for track in reel.tracks}
        self._simulation = Simulation(scene=_scene(reel.properties), robots=variants, seeing=False)
        model = self._simulation.model
        starts = {track.name: _pose(track, float(reel.time_s[0])) for track in reel.tracks}
        self._simulation.reset(starts, stream("trial.scenery", int(reel.properties["seed"])))
        for light in range(model.nlight):
            first = light == 0
            model.light_ambient[light], model.light_diffuse[light] = AMBIENT * first, LIGHT * first
            model.light_dir[light] = SIDE
        model.geom_rgba[:, :3] = np.maximum(model.geom_rgba[:, :3], DARKEST)
        model.mat_rgba[:, :3] = np.maximum(model.mat_rgba[:, :3], DARKEST)
        model.vis.global_.fovy = OPENING_DEG
        self._size = round(ASPECT * height), height
        self._screen = Offscreen(model, FINER * height, FINER * self._size[0])
        self._camera = _camera(reel.tracks)

    def at(self, time_s: float) -> Picture:
        """Draw the robots where they were at a time, (height, width, 3) uint8, RGB."""
        simulation = self._simulation
        poses = {track.name: _pose(track, time_s) for track in self._tracks}
        for name, pose in poses.items():
            simulation.everyone[name].place(pose)
        mujoco.mj_forward(simulation.model, simulation.data)
        width, height = (FINER * length for length in self._size)
        self._screen.draw_into(
            (0, 0, width, height), simulation.data, self._camera, mujoco.MjvOption(),
            lambda scene: _dress(scene, list(poses.values()), self._view_deg),
        )  # fmt: skip
        picture = cv2.resize(self._screen.read_all()[::-1], self._size, interpolation=cv2.INTER_AREA)
        return np.asarray(picture, np.uint8)


def outside(reel: Reel, height: int) -> Outside | None:
    """Return the view from outside, or ``None`` where it cannot be drawn.

    It can for trials in an arena that ships, where something can render. An arena of a user's own is a file, which a
    recording that was handed to somebody must not open.
    """
    if reel.properties.get("arena") not in ARENAS or len(reel.tracks) < 2:
        return None
    if not all(np.isfinite(track.poses).all() for track in reel.tracks):
        return None
    try:
        return Outside(reel, height)
    except (GLUnavailable, ValueError):
        return None


def _scene(properties: Mapping[str, Any]) -> SceneConfig:
    looks = {name: properties[name] for name in LOOKS if properties.get(name) is not None}
    return SceneConfig(arena=properties["arena"], **looks)


def _pose(track: Track, time_s: float) -> Pose:
    x, y, heading = track.pose_at(time_s)
    return Pose(float(x) / 100, float(y) / 100, float(heading))


def _camera(tracks: tuple[Track, ...]) -> mujoco.MjvCamera:
    """Place a camera from which all places of all robots are seen."""
    places: Floats = np.concatenate([track.poses[:, :2] for track in tracks]) / 100
    low, high = places.min(0), places.max(0)
    camera = mujoco.MjvCamera()
    camera.lookat[:] = *((low + high) / 2), 0.01
    camera.azimuth = math.degrees(tracks[0].poses[0, 2]) + TURN_DEG
    camera.elevation = DOWN_DEG
    half = float(np.linalg.norm(high - low)) / 2 + ROOM_M
    camera.distance = half / math.tan(math.radians(OPENING_DEG) / 2) / ASPECT
    return camera


def _dress(scene: mujoco.MjvScene, robots: Sequence[Pose], view_deg: float) -> None:
    """Add the field of view of the first robot to a scene, and the shadow of each, flat on the floor."""
    observer, lens = robots[0], CameraConfig().forward_cm / 100
    start = np.array([observer.x + lens * math.cos(observer.heading), observer.y + lens * math.sin(observer.heading)])
    angles = observer.heading + np.radians(np.linspace(view_deg / 2, -view_deg / 2, 13))
    ends = start + SIGHT_M * np.column_stack([np.cos(angles), np.sin(angles)])
    for one, other in pairwise(ends):
        edges = np.column_stack([np.append(other - start, 0.0), np.append(one - start, 0.0), [0.0, 0.0, 1.0]])
        _add(scene, mujoco.mjtGeom.mjGEOM_TRIANGLE, (1.0, 1.0, 1.0), (*start, 0.0008), edges, SIGHT)
    for robot in robots:
        for ring in range(4):  # each a little larger, for a soft edge
            place = robot.x + 0.006, robot.y + 0.008, 0.001 + 0.0002 * ring
            size = 0.0185 + 0.002 * ring, 0.0185 + 0.002 * ring, 0.0001
            _add(scene, mujoco.mjtGeom.mjGEOM_CYLINDER, size, place, np.eye(3), SHADOW)


def _add(
    scene: mujoco.MjvScene, kind: mujoco.mjtGeom, size: Sequence[float], place: Sequence[float], axes: Floats,
    colour: Sequence[float],
) -> None:  # fmt: skip
    geom = scene.geoms[scene.ngeom]
    mujoco.mjv_initGeom(geom, kind, np.array(size), np.array(place), axes.flatten(), np.array(colour, np.float32))
    scene.ngeom += 1
