"""One trial, from its specification to its result."""

from __future__ import annotations

import dataclasses
import math
import threading
import time
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from colias_sim import Frame, OpenLoop, PathFollower, Pose, Simulation, SpeedProfile, WheelSpeeds, bearing
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from dsnn import ResponseSeries
from experiments.bench.core.model_runner import ModelRunner, spike_counts
from experiments.bench.core.models import ConfiguredModel
from experiments.bench.robot.experiment import Condition, Settings, TrialSpec
from experiments.bench.robot.mechanism.windows import InWindows, Windows, measure, windows
from experiments.bench.robot.media import Media, collect
from experiments.bench.robot.trajectory import Course, course
from experiments.bench.streams import stream

KEPT_SCENES = 6
AT_REST_M_S = 0.002


class TrialError(RuntimeError):
    """A trial that could not be completed: what went wrong."""


@dataclass(frozen=True, slots=True)
class FrameColumns:
    """Time and poses of every frame, one entry each, at the end of the frame's exposure."""

    sim_time_s: npt.NDArray[np.float64]
    stimulus_bearing_deg: npt.NDArray[np.float64]
    """From the observer's optical axis, left positive: in the tables and on the figures' axes."""
    stimulus_x_cm: npt.NDArray[np.float64]
    stimulus_y_cm: npt.NDArray[np.float64]
    stimulus_heading_deg: npt.NDArray[np.float64]
    observer_x_cm: npt.NDArray[np.float64]
    observer_y_cm: npt.NDArray[np.float64]
    observer_heading_deg: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Answer:
    """What one model made of the trial's frames."""

    model: str
    channels: tuple[str, ...]
    """Those that the model declares."""
    thresholds: Mapping[str, float | None]
    """Channel -> its spiking threshold."""
    spikes: int
    """Accumulated count of HS, or of looming where no direction is declared."""
    hs_spikes: int | None
    vs_spikes: int | None
    looming_spikes: int | None
    """Accumulated counts of each channel; ``None`` where it is not declared."""
    firing_rate_hz: float
    peak_hs: float
    trough_hs: float
    peak_vs: float
    trough_vs: float
    peak_looming: float
    parts: InWindows
    """The same in parts of the trial."""
    series: ResponseSeries


@dataclass(frozen=True, slots=True)
class TrialResult:
    """A finished trial: what the robots did, and every model's answer to the same frames."""

    spec: TrialSpec
    answers: tuple[Answer, ...]
    broken: Mapping[str, str]
    """Models that raised, or answered with something else than numbers: label -> what went wrong."""
    achieved_speed_cm_s: float
    path_error_mm: float
    drift_mm: float
    drive: str
    closest_cm: float
    seconds_in_view: float
    frames: int
    wall_s: float
    columns: FrameColumns
    media: Media | None


class _Kept(threading.local):
    """The scenes each thread compiled last, which hold OpenGL contexts of that thread."""

    def __init__(self) -> None:
        self.simulations: OrderedDict[tuple[RobotConfig, CameraConfig, SceneConfig], Simulation] = OrderedDict()


_KEPT = _Kept()


def simulation(robot: RobotConfig, camera: CameraConfig, scene: SceneConfig) -> Simulation:
    """The compiled scene, kept for this thread's next trials with the same settings: compiling costs as much as one."""
    kept, key = _KEPT.simulations, (robot, camera, scene)
    if key not in kept:
        while len(kept) >= KEPT_SCENES:
            kept.popitem(last=False)[1].close()
        kept[key] = Simulation(robot, camera, scene)
    kept.move_to_end(key)
    return kept[key]


def forget_simulations() -> None:
    """Close the scenes that this thread keeps."""
    while _KEPT.simulations:
        _KEPT.simulations.popitem()[1].close()


def scene_of(condition: Condition, settings: Settings) -> SceneConfig:
    """The scene's settings with what the condition sets itself."""
    own = {name: getattr(condition, name) for name in ("shell_grey", "wall_contrast")}
    return dataclasses.replace(settings.scene, **{name: value for name, value in own.items() if value is not None})


def run_trial(spec: TrialSpec, *, keep_media: bool = False) -> TrialResult:
    """Run one trial; the same specification gives the same result, wall time aside, in any process.

    ``keep_media`` also returns camera frames and the first model's layer maps, for a recording. Raises
    `TrialError` if the stimulus does not get to the end of its path, or every model breaks. A stimulus that drives
    open loop stops by time, wherever it is then.
    """
    began = time.perf_counter()
    settings = spec.settings
    sim = simulation(settings.robot, settings.camera, scene_of(spec.condition, settings))
    placing, scenery, noise = (stream(f"trial.{part}", spec.seed) for part in ("placing", "scenery", "noise"))
    route = course(spec.condition, settings, placing)
    sim.reset({"observer": route.observer, "stimulus": route.start}, scenery)
    shape = (settings.camera.height, settings.camera.width)
    watching = [ModelRunner(chosen, shape) for chosen in settings.models]
    drive = _Drive(sim, route, spec.condition)
    frames: list[Frame] = []
    poses: list[tuple[Pose, Pose]] = []
    while not drive.over:
        if sim.data.time > 3.0 + 2.0 * route.seconds:
            raise TrialError("the stimulus got stuck on its way")
        frame = sim.step(noise, drive)
        for i, each in enumerate(watching):
            each.see(frame.luma, maps=keep_media and i == 0)
        frames.append(frame)
        poses.append((sim.robots["stimulus"].pose, sim.robots["observer"].pose))
        drive.look()
    wall_s = time.perf_counter() - began
    columns = _columns(frames, poses, settings)
    parts = _parts(spec, columns)
    series = [(each.chosen, given) for each in watching if (given := each.series()) is not None]
    answers = tuple(_answer(chosen, given, parts, settings.camera.fps) for chosen, given in series)
    broken = {each.label: each.trouble for each in watching if each.trouble}
    if not answers:
        raise TrialError("; ".join(f"{label}: {trouble}" for label, trouble in broken.items()))
    shown = collect(frames, [] if watching[0].trouble else watching[0].responses) if keep_media else None
    return _result(spec, route, columns, [p for p, _ in poses], parts, answers, broken, shown, wall_s)


class _Drive:
    """Commands both robots over a trial, and says when it is over."""

    def __init__(self, sim: Simulation, route: Course, condition: Condition) -> None:
        self._sim, self._route = sim, route
        self._stimulus, observer = sim.robots["stimulus"], sim.robots["observer"]
        profile = SpeedProfile(route.line.length, route.speed, route.acceleration, route.stop, route.wait)
        self._by_time = OpenLoop(self._stimulus, profile) if self._stimulus.config.open_loop else None
        self._ends = self._stimulus.begins() + self._by_time.seconds + route.rest if self._by_time else 0.0
        self._follower = PathFollower(
            self._stimulus, route.line, route.speed, acceleration=route.acceleration, stop=route.stop
        )
        speed, turn = condition.observer_speed_cm_s / 100, np.radians(condition.observer_turn_deg_s)
        if speed or turn:
            observer.drive(observer.wheels_for(speed, float(turn)))
        self._arrived: float | None = None
        self.over = False

    def __call__(self, dt: float) -> None:
        if self._by_time is not None:
            self._by_time.drive(dt)
            return
        still = self._sim.data.time < self._route.wait - 1e-9
        self._stimulus.drive(WheelSpeeds(0.0, 0.0) if still else self._follower.wheels(dt))

    def look(self) -> None:
        """Once a frame: has the stimulus passed the end, or stopped there and rested? Is its time over?"""
        along, now = self._route.line.along(self._stimulus.pose), self._sim.data.time
        if self._by_time is not None:
            self.over = now >= self._ends - 1e-9
        elif not self._route.stop:
            self.over = along >= self._route.leave
        elif self._arrived is None:
            at_rest = float(np.hypot(*self._stimulus.velocity)) < AT_REST_M_S
            self._arrived = now if at_rest and along > self._route.leave else None
        else:
            self.over = now >= self._arrived + self._route.rest - 1e-9


def _result(
    spec: TrialSpec,
    route: Course,
    columns: FrameColumns,
    poses: list[Pose],
    parts: Windows,
    answers: tuple[Answer, ...],
    broken: Mapping[str, str],
    shown: Media | None,
    wall_s: float,
) -> TrialResult:
    along = np.array([route.line.along(p) for p in poses])
    offset = np.array([route.line.offset(p) for p in poses])
    steady = (along >= route.enter) & (along <= route.leave)
    times = columns.sim_time_s[steady]
    measured = len(times) > 1  # a stimulus that drives open loop may stop too early
    return TrialResult(
        spec=spec,
        answers=answers,
        broken=broken,
        achieved_speed_cm_s=100 * float(np.ptp(along[steady]) / np.ptp(times)) if measured else math.nan,
        path_error_mm=1000 * float(np.abs(offset[steady]).max()) if measured else math.nan,
        drift_mm=1000 * float(offset[-1]),
        drive="open" if spec.settings.robot.open_loop else "feedback",
        closest_cm=float(_away_cm(columns, spec.settings.camera.forward_cm).min()),
        seconds_in_view=float(parts.in_view.sum()) / spec.settings.camera.fps,
        frames=len(poses),
        wall_s=wall_s,
        columns=columns,
        media=shown,
    )


def _parts(spec: TrialSpec, columns: FrameColumns) -> Windows:
    camera = spec.settings.camera
    away = _away_cm(columns, camera.forward_cm)
    return windows(spec.condition, camera, columns.sim_time_s, columns.stimulus_bearing_deg, away)


def _away_cm(columns: FrameColumns, forward_cm: float) -> npt.NDArray[np.float64]:
    """From the lens to the stimulus's centre in every frame, wherever the observer was by then."""
    heading = np.radians(columns.observer_heading_deg)
    lens_x = columns.observer_x_cm + forward_cm * np.cos(heading)
    lens_y = columns.observer_y_cm + forward_cm * np.sin(heading)
    return np.hypot(columns.stimulus_x_cm - lens_x, columns.stimulus_y_cm - lens_y)


def _answer(model: ConfiguredModel, series: ResponseSeries, parts: Windows, fps: float) -> Answer:
    channels, spikes = model.channels, series.accumulated_spikes(model.counted)
    return Answer(
        model=model.label,
        channels=channels,
        thresholds=model.thresholds,
        spikes=spikes,
        **spike_counts(series, channels),
        firing_rate_hz=spikes / (len(series.hs) / fps),
        peak_hs=float(series.hs.max()),
        trough_hs=float(series.hs.min()),
        peak_vs=float(series.vs.max()),
        trough_vs=float(series.vs.min()),
        peak_looming=float(series.looming.max()),
        parts=measure(series, model.counted, parts, fps),
        series=series,
    )


def _columns(frames: list[Frame], poses: list[tuple[Pose, Pose]], settings: Settings) -> FrameColumns:
    forward = settings.camera.forward_cm / 100
    stimulus, observer = [p for p, _ in poses], [p for _, p in poses]
    return FrameColumns(
        sim_time_s=np.array([f.time for f in frames]),
        stimulus_bearing_deg=np.degrees([bearing(o, s, forward) for s, o in poses]),
        stimulus_x_cm=100 * np.array([p.x for p in stimulus]),
        stimulus_y_cm=100 * np.array([p.y for p in stimulus]),
        stimulus_heading_deg=np.degrees([p.heading for p in stimulus]),
        observer_x_cm=100 * np.array([p.x for p in observer]),
        observer_y_cm=100 * np.array([p.y for p in observer]),
        observer_heading_deg=np.degrees([p.heading for p in observer]),
    )
