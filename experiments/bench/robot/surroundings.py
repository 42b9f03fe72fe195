"""An arena around the robots of trials: its files, and whether robots fit into it and the camera sees the stimulus."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from colias_sim import Pose, bearing
from colias_sim.arena import Arena
from colias_sim.config import SceneConfig
from experiments.bench.robot.experiment import Condition, Settings
from experiments.bench.robot.trajectory import ROBOT_RADIUS_CM, body_cm, nominal
from experiments.bench.run.errors import UsageError
from scenes import ARENAS

if TYPE_CHECKING:
    import mujoco

    from colias_sim.obstacles import Obstacle

EVERY_S = 0.02
"""Time between two moments at which places are checked."""
SIGHT_EVERY = 5
"""Every so many of these moments it is asked whether the camera sees the stimulus."""
SIGHT_GROUPS = np.array([1, 1, 1, 0, 0, 0], np.uint8)
"""Groups of geoms that the camera renders."""

Vectors = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """A compiled arena without robots.

    Parameters
    ----------
    source
        Its name, or the path of its file.
    model, data
        As MuJoCo has it.
    obstacles
        What stands in the way of hulls.
    """

    source: str
    model: mujoco.MjModel
    data: mujoco.MjData
    obstacles: tuple[Obstacle, ...]

    def hides(self, eye: Vectors, point: Vectors) -> str:
        """Name the geom that stands between two points, (3,) each in metres; empty if none does."""
        import mujoco

        from colias_sim.obstacles import called

        geom = np.full(1, -1, np.int32)
        far = mujoco.mj_ray(self.model, self.data, eye, point - eye, SIGHT_GROUPS, 1, -1, geom)
        return called(self.model, int(geom[0])) if 0.0 <= far < 1.0 else ""


def files(scene: SceneConfig) -> list[str]:
    """List the user's own files that a scene is made of.

    Parameters
    ----------
    scene
        The scene's settings.

    Returns
    -------
    list of str
        Absolute paths: of the arena with what it names, and of the pictures on wall and shell.

    Raises
    ------
    UsageError
        The arena cannot be read.
    """
    pictures = [str(Path(path).resolve()) for path in (scene.wall, scene.shell_picture) if path]
    return [*map(str, read(scene.arena).files if scene.arena not in ARENAS else ()), *pictures]


def read(source: str) -> Arena:
    """Read an arena; `UsageError` where it is refused."""
    try:
        return Arena.read(source)
    except ValueError as error:
        raise UsageError(str(error)) from error


def surroundings(source: str) -> Surroundings:
    """Compile an arena without robots, once for each of its contents.

    Raises
    ------
    UsageError
        The arena is refused, in one line.
    """
    return _surroundings(source, tuple(read(source).files.items()))


@functools.lru_cache(maxsize=4)
def _surroundings(source: str, _digests: tuple[object, ...]) -> Surroundings:
    import mujoco

    from colias_sim.obstacles import obstacles as standing
    from colias_sim.scene import compile_arena

    try:
        model = compile_arena(source)
    except ValueError as error:
        raise UsageError(str(error)) from error
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    return Surroundings(source, model, data, standing(model))


def obstacles(source: str) -> tuple[Obstacle, ...]:
    """List what stands in an arena, by its name or the path of its file; those that ship are empty rooms."""
    return () if source in ARENAS else surroundings(source).obstacles


def check(conditions: Iterable[Condition], settings: Settings) -> None:
    """Hold the trials of conditions against the arena of their settings.

    The arenas that ship are empty rooms, whose wall is checked elsewhere.

    Raises
    ------
    UsageError
        The arena is refused, a robot would stand in an obstacle or drive into one, or the camera cannot see the
        stimulus. In one line.
    """
    if settings.scene.arena in ARENAS:
        return
    around = surroundings(settings.scene.arena)
    for condition in conditions:
        _check_condition(condition, settings, around)


def _check_condition(condition: Condition, settings: Settings, around: Surroundings) -> None:
    course = nominal(condition, settings)
    schedules = {"stimulus": course.stimulus.schedule()}
    schedules |= {name: script.schedule() for name, script in course.others.items()}
    moments = [i * EVERY_S for i in range(math.ceil(schedules["stimulus"].seconds / EVERY_S) + 1)]
    places = {name: [schedule.pose(time) for time in moments] for name, schedule in schedules.items()}
    for name, poses in places.items():
        _check_fit(condition, name, poses, moments, settings, around)
    _check_sight(condition, places, moments, settings, around)


def _check_fit(
    condition: Condition, name: str, poses: Sequence[Pose], moments: Sequence[float], settings: Settings,
    around: Surroundings,
) -> None:  # fmt: skip
    """Refuse a robot that stands in an obstacle, or drives into one, counting 3 sd of the errors of a stimulus."""
    at = np.array([(pose.x, pose.y) for pose in poses])
    radius_cm, errors_cm = ROBOT_RADIUS_CM if name == "observer" else body_cm(settings), np.zeros(len(at))
    if name == "stimulus":
        skew = math.sin(math.radians(3 * settings.heading_sd_deg))
        errors_cm = 0.3 * settings.pose_sd_mm + 100 * skew * np.hypot(*(at - at[0]).T)
    for obstacle in around.obstacles:
        room_cm = 100 * obstacle.distances(at) - radius_cm - errors_cm
        index = int(np.argmax(room_cm <= 0.0)) if (room_cm <= 0.0).any() else -1
        if index < 0:
            continue
        x, y = 100 * at[index]
        where = "starts in" if index == 0 else f"drives into, {moments[index]:.2f} s after it starts,"
        counting = ", counting 3 sd of the start pose's errors" if name == "stimulus" else ""
        raise UsageError(
            f"{condition.label()}: the {name} {where} the obstacle {obstacle.name} of the arena {around.source}: there"
            f" its body, at ({x:.1f}, {y:.1f}) cm, {_overlap(-room_cm[index])}{counting};"
            " move the obstacle, or lead the robot elsewhere"
        )


def _overlap(depth_cm: float) -> str:
    return f"reaches {depth_cm:.2f} cm into it" if depth_cm > 0.0 else "touches it"


def _check_sight(
    condition: Condition, places: Mapping[str, Sequence[Pose]], moments: Sequence[float], settings: Settings,
    around: Surroundings,
) -> None:  # fmt: skip
    """Refuse a stimulus that is hidden where it starts in view, or all the time that it is in view."""
    half, forward = settings.camera.hfov_deg / 2, settings.camera.forward_cm / 100
    hidden_by = ""
    for index in range(0, len(moments), SIGHT_EVERY):
        observer, stimulus = places["observer"][index], places["stimulus"][index]
        if abs(math.degrees(bearing(observer, stimulus, forward))) > half:
            continue
        hidden_by = _hidden(observer, stimulus, settings, around)
        if not hidden_by:
            return
        if index == 0:
            break
    if hidden_by:
        when = "where it starts" if index == 0 else "all the time that it is in view"
        raise UsageError(
            f"{condition.label()}: the camera does not see the stimulus {when}: {hidden_by} of the arena"
            f" {around.source} stands between them; move it, or make it lower or narrower"
        )


def _hidden(observer: Pose, stimulus: Pose, settings: Settings, around: Surroundings) -> str:
    """Name what hides the whole stimulus; empty if a part of it is seen."""
    camera, scene = settings.camera, settings.scene
    forward = camera.forward_cm / 100
    eye = np.array([
        observer.x + forward * math.cos(observer.heading), observer.y + forward * math.sin(observer.heading),
        camera.up_cm / 100,
    ])  # fmt: skip
    height = (scene.shell_width_cm if scene.shell_shape == "sphere" else scene.shell_height_cm) / 100
    away = np.array([stimulus.x, stimulus.y]) - eye[:2]
    aside = np.array([-away[1], away[0]]) / np.hypot(*away)
    by = ""
    for share in (0.0, -0.8, 0.8):
        for level in (0.5, 0.9):
            x, y = np.array([stimulus.x, stimulus.y]) + share * scene.shell_width_cm / 200 * aside
            by = around.hides(eye, np.array([x, y, level * height]))
            if not by:
                return ""
    return by
