"""One trial, from its specification to its result."""

from __future__ import annotations

import dataclasses
import math
import threading
import time
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim import Frame, Line, PathFollower, Pose, Simulation, bearing
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from dsnn import Response, model_entry
from experiments.bench.declaration import Condition, Settings, TrialSpec, half_crossing
from experiments.bench.media import Media, collect

ROBOT_RADIUS_CM = 2.0
MARGIN_CM = 0.6
"""How far beyond the edge of the view a crossing starts and ends: room for the errors of the start pose."""

OBSERVER = Pose(0.0, 0.0, 0.0)


class TrialError(RuntimeError):
    """A trial that could not be completed: it names the trial and what went wrong."""


@dataclass(frozen=True, slots=True)
class FrameColumns:
    """What is kept of every frame, one entry each; poses at the end of the frame's exposure."""

    sim_time_s: npt.NDArray[np.float64]
    hs: npt.NDArray[np.float64]
    vs: npt.NDArray[np.float64]
    hs_spikes: npt.NDArray[np.int64]
    vs_spikes: npt.NDArray[np.int64]
    stimulus_bearing_deg: npt.NDArray[np.float64]
    """Left of the optical axis positive."""
    stimulus_x_cm: npt.NDArray[np.float64]
    stimulus_y_cm: npt.NDArray[np.float64]
    stimulus_heading_deg: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TrialResult:
    """A finished trial: per-trial numbers with their units in the names, and per-frame columns."""

    spec: TrialSpec
    spikes: int
    firing_rate_hz: float
    peak_hs: float
    trough_hs: float
    peak_vs: float
    trough_vs: float
    achieved_speed_cm_s: float
    path_error_mm: float
    closest_cm: float
    frames: int
    wall_s: float
    columns: FrameColumns
    media: Media | None


@dataclass(frozen=True, slots=True)
class Course:
    """Where the stimulus is asked to go: ``line`` from rest, the crossing from ``enter`` to ``leave`` (m along it)."""

    line: Line
    enter: float
    leave: float
    speed: float


def reach_cm(condition: Condition, settings: Settings) -> float:
    """How far from the arena's centre the stimulus's edge gets, which has to stay inside the wall."""
    nominal = dataclasses.replace(settings, pose_sd_mm=0.0, heading_sd_deg=0.0)
    line = course(condition, nominal, np.random.default_rng(0)).line
    ends = (line.start, line.point(line.length))
    return 100 * max(math.hypot(end.x, end.y) for end in ends) + ROBOT_RADIUS_CM


class _Kept(threading.local):
    """The scene each thread compiled last, which holds an OpenGL context of that thread."""

    settings: tuple[RobotConfig, CameraConfig, SceneConfig] | None = None
    simulation: Simulation | None = None


_KEPT = _Kept()


def simulation(robot: RobotConfig, camera: CameraConfig, scene: SceneConfig) -> Simulation:
    """The compiled scene, kept for this thread's next trial with the same settings: compiling costs as much as one."""
    if _KEPT.simulation is None or _KEPT.settings != (robot, camera, scene):
        forget_simulation()
        _KEPT.simulation, _KEPT.settings = Simulation(robot, camera, scene), (robot, camera, scene)
    return _KEPT.simulation


def forget_simulation() -> None:
    """Close the scene that this thread keeps, if any."""
    if _KEPT.simulation is not None:
        _KEPT.simulation.close()
    _KEPT.simulation = _KEPT.settings = None


def course(condition: Condition, settings: Settings, rng: np.random.Generator) -> Course:
    """The stimulus's path, with the errors of its start pose: it drives straight where it was set down pointing."""
    camera = settings.camera
    distance, speed = condition.distance_cm / 100, condition.speed_cm_s / 100
    half = half_crossing(distance, ROBOT_RADIUS_CM / 100, math.radians(camera.hfov_deg)) + MARGIN_CM / 100
    run_up = PathFollower.run_up(speed)
    side = 1.0 if condition.direction == "rightward" else -1.0  # y is the observer's left
    dx, dy = rng.normal(0.0, settings.pose_sd_mm / 1000, 2)
    skew = rng.normal(0.0, math.radians(settings.heading_sd_deg))
    start = Pose(camera.forward_cm / 100 + distance + dx, side * (half + run_up) + dy, -side * math.pi / 2 + skew)
    return Course(Line(start, run_up + 2 * half), run_up, run_up + 2 * half, speed)


def run_trial(spec: TrialSpec, *, keep_media: bool = False) -> TrialResult:
    """Run one trial; the same specification gives the same result, wall time aside, in any process.

    ``keep_media`` also returns camera frames and layer maps, for a recording. Raises `TrialError` if the
    stimulus does not get to the end of its path.
    """
    began = time.perf_counter()
    settings = spec.settings
    sim = simulation(settings.robot, settings.camera, settings.scene)
    placing, scenery, noise = (np.random.default_rng(s) for s in np.random.SeedSequence(spec.seed).spawn(3))
    route = course(spec.condition, settings, placing)
    sim.reset({"observer": OBSERVER, "stimulus": route.line.start}, scenery)
    model = model_entry(settings.model).build((settings.camera.height, settings.camera.width), settings.network)
    stimulus = sim.robots["stimulus"]
    follower = PathFollower(stimulus, route.line, route.speed)
    longest = int((3.0 + 2.0 * route.line.length / route.speed) / sim.frame_interval)
    frames: list[Frame] = []
    responses: list[Response] = []
    poses: list[Pose] = []
    while not poses or route.line.along(poses[-1]) < route.leave:
        if len(frames) >= longest:
            raise TrialError(f"trial {spec.index} ({spec.condition.label()}): the stimulus got stuck on its way")
        frame = sim.step(noise, lambda dt: stimulus.drive(follower.wheels(dt)))
        responses.append(model.step(frame.luma, maps=keep_media))
        frames.append(frame)
        poses.append(stimulus.pose)
    wall_s = time.perf_counter() - began
    shown = collect(frames, responses) if keep_media else None
    return _result(spec, route, _columns(frames, responses, poses, settings), poses, shown, wall_s)


def _result(
    spec: TrialSpec,
    route: Course,
    columns: FrameColumns,
    poses: list[Pose],
    shown: Media | None,
    wall_s: float,
) -> TrialResult:
    along = np.array([route.line.along(p) for p in poses])
    offset = np.array([route.line.offset(p) for p in poses])
    crossing = (along >= route.enter) & (along <= route.leave)
    times = columns.sim_time_s
    lens = spec.settings.camera.forward_cm
    spikes = int(np.abs(columns.hs_spikes).sum())
    return TrialResult(
        spec=spec,
        spikes=spikes,
        firing_rate_hz=spikes / (len(poses) / spec.settings.camera.fps),
        peak_hs=float(columns.hs.max()),
        trough_hs=float(columns.hs.min()),
        peak_vs=float(columns.vs.max()),
        trough_vs=float(columns.vs.min()),
        achieved_speed_cm_s=100 * float(np.ptp(along[crossing]) / np.ptp(times[crossing])),
        path_error_mm=1000 * float(np.abs(offset[crossing]).max()),
        closest_cm=float(np.hypot(columns.stimulus_x_cm - lens, columns.stimulus_y_cm).min()),
        frames=len(poses),
        wall_s=wall_s,
        columns=columns,
        media=shown,
    )


def _columns(frames: list[Frame], responses: list[Response], poses: list[Pose], settings: Settings) -> FrameColumns:
    forward = settings.camera.forward_cm / 100
    return FrameColumns(
        sim_time_s=np.array([f.time for f in frames]),
        hs=np.array([r.hs for r in responses]),
        vs=np.array([r.vs for r in responses]),
        hs_spikes=np.array([r.hs_spikes for r in responses], np.int64),
        vs_spikes=np.array([r.vs_spikes for r in responses], np.int64),
        stimulus_bearing_deg=np.degrees([bearing(OBSERVER, p, forward) for p in poses]),
        stimulus_x_cm=100 * np.array([p.x for p in poses]),
        stimulus_y_cm=100 * np.array([p.y for p in poses]),
        stimulus_heading_deg=np.degrees([p.heading for p in poses]),
    )
