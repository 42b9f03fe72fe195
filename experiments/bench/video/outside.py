"""The robots of a trial seen from outside: its arena, posed by its recording and drawn with shadows."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import mujoco
import numpy as np

from colias_sim import CameraConfig, GLUnavailable, Pose, SceneConfig, Simulation
from colias_sim.offscreen import Offscreen
from experiments.bench.streams import stream
from experiments.bench.video.pictures import Floats, Picture
from experiments.bench.video.reading import Reel, Track
from scenes import ARENAS

ASPECT = 11 / 8
"""Width over height of the view, that of the robot's camera."""
LOOKS = ("shell_grey", "wall_contrast")
"""The settings of a scene that a condition of a trial sets."""
LIGHT, AMBIENT, SIDE = 0.62, 0.42, (0.35, 0.45, -0.82)
"""Lamps of the view: those of the arena cast no shadow and light all sides equally, which shows no shape."""
SIGHT_M, SIGHT = 0.30, (1.0, 0.86, 0.35, 0.28)
"""How far the field of view is drawn on the floor, and its colour."""
TURN_DEG, DOWN_DEG, OPENING_DEG, ROOM_M = 24.0, -27.0, 45.0, 0.055
"""The view: its angle to the side of the observer's heading, and downward; its opening; the room about the robots."""


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
            model.light_castshadow[light], model.light_dir[light] = first, SIDE
        model.vis.quality.shadowsize, model.vis.quality.offsamples = 4096, 8
        model.vis.global_.fovy = OPENING_DEG
        self._screen = Offscreen(model, height, round(ASPECT * height))
        self._camera = _camera(reel.tracks)

    def at(self, time_s: float) -> Picture:
        """Draw the robots where they were at a time, (height, width, 3) uint8, RGB."""
        simulation = self._simulation
        for track in self._tracks:
            simulation.everyone[track.name].place(_pose(track, time_s))
        mujoco.mj_forward(simulation.model, simulation.data)
        observer = _pose(self._tracks[0], time_s)
        height, width, _ = self._screen.read_all().shape
        self._screen.draw_into(
            (0, 0, width, height), simulation.data, self._camera, mujoco.MjvOption(),
            lambda scene: _draw_sight(scene, observer, self._view_deg),
        )  # fmt: skip
        return self._screen.read_all()[::-1].copy()


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
    row = max(int(np.searchsorted(track.time_s, time_s + 1e-6)) - 1, 0)
    x, y, heading = track.poses[row]
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
    camera.distance = half / math.tan(math.radians(OPENING_DEG) * ASPECT / 2) + 0.3 * half
    return camera


def _draw_sight(scene: mujoco.MjvScene, observer: Pose, view_deg: float) -> None:
    """Add the observer's field of view to a scene, as a fan of triangles on the floor."""
    lens = CameraConfig().forward_cm / 100
    start = np.array([observer.x + lens * math.cos(observer.heading), observer.y + lens * math.sin(observer.heading)])
    angles = observer.heading + np.radians(np.linspace(-view_deg / 2, view_deg / 2, 13))
    ends = start + SIGHT_M * np.column_stack([np.cos(angles), np.sin(angles)])
    for one, other in zip(ends[:-1], ends[1:], strict=True):
        if scene.ngeom >= scene.maxgeom:
            return
        edges = np.column_stack([np.append(one - start, 0.0), np.append(other - start, 0.0), [0.0, 0.0, 1.0]])
        mujoco.mjv_initGeom(
            scene.geoms[scene.ngeom], mujoco.mjtGeom.mjGEOM_TRIANGLE, np.ones(3), np.array([*start, 0.0012]),
            edges.flatten(), np.array(SIGHT, np.float32),
        )  # fmt: skip
        scene.ngeom += 1
