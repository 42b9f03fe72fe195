"""One trial, from its specification to its result."""

from __future__ import annotations

import dataclasses
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from colias_sim import Frame, Pose, Route, Simulation, Tracker, bearing
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.simulation import TRIAL_ROBOTS
from dsnn import Response, ResponseSeries
from experiments.bench.run.errors import TrialError
from experiments.bench.run.model_runner import ModelRunner, change, spike_counts
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.streams import stream
from experiments.bench.run.user_code import sha256
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.course import Course, course
from experiments.bench.sources.drive import AstrayError, Drive
from experiments.bench.sources.experiment import Settings, TrialSpec
from experiments.bench.sources.hand import HandDrive, changes_at
from experiments.bench.sources.media import Media, collect
from experiments.bench.sources.room import files
from experiments.bench.sources.windows import InWindows, Windows, measure, windows

MARK = "@"
TRUE = "ov7670"
"""The preset that is a model of the robot's eye."""
GEOMETRY = ("width", "height", "hfov_deg", "fps", "forward_cm", "up_cm")
"""Settings that both eyes have in common: size, field of view, clock and place."""


def through(label: str) -> str:
    """Return the camera preset that a model sees through; empty: the camera of the settings."""
    _, mark, name = label.rpartition(MARK)
    return name if mark and name in CameraConfig.presets() else ""


def camera(settings: Settings, eye: str) -> CameraConfig:
    """Return an eye's settings, with the size, field of view, clock and place of the camera as it is set."""
    if not eye:
        return settings.camera
    common = {name: getattr(settings.camera, name) for name in GEOMETRY}
    return dataclasses.replace(CameraConfig.preset(eye), **common)


def models_by_eye(models: Sequence[ConfiguredModel]) -> Mapping[str, list[ConfiguredModel]]:
    """Return the models of each eye, the eye of the first model first."""
    by_eye: dict[str, list[ConfiguredModel]] = {}
    for model in models:
        by_eye.setdefault(through(model.label), []).append(model)
    return by_eye


KEPT_SCENES = 6


@dataclass(frozen=True, slots=True)
class FrameColumns:
    """Time and poses of every frame, one entry each, at the end of the frame's exposure."""

    sim_time_s: npt.NDArray[np.float64]
    stimulus_bearing_deg: npt.NDArray[np.float64]
    """Bearing from the observer's optical axis, right positive."""
    stimulus_x_cm: npt.NDArray[np.float64]
    stimulus_y_cm: npt.NDArray[np.float64]
    stimulus_heading_deg: npt.NDArray[np.float64]
    observer_x_cm: npt.NDArray[np.float64]
    observer_y_cm: npt.NDArray[np.float64]
    observer_heading_deg: npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class TrialAnswer:
    """Answers of one model to the trial's frames."""

    model: str
    channels: tuple[str, ...]
    """Channels that the model declares."""
    thresholds: Mapping[str, float | None]
    """Channel -> its spiking threshold."""
    spikes: int | None
    """Accumulated count of HS, or of looming where no direction is declared."""
    hs_spikes: int | None
    vs_spikes: int | None
    looming_spikes: int | None
    """Accumulated counts of each channel; ``None`` where it has no threshold or is not declared."""
    firing_rate_hz: float | None
    peak_hs: float
    trough_hs: float
    peak_vs: float
    trough_vs: float
    peak_looming: float
    parts: InWindows | None
    """Answers in parts of the trial; ``None`` where nobody knows where the stimulus was."""
    series: ResponseSeries


@dataclass(frozen=True, slots=True)
class TrialResult:
    """A finished trial: what the robots did, and every model's answer to the same frames."""

    spec: TrialSpec
    answers: tuple[TrialAnswer, ...]
    broken: Mapping[str, str]
    """Models that raised, or answered with something else than numbers: label -> what went wrong."""
    achieved_speed_cm_s: float | None
    path_error_mm: float | None
    drift_mm: float
    drive: str
    closest_cm: float
    seconds_in_view: float
    frames: int
    wall_s: float
    columns: FrameColumns
    media: Media | None


Key = tuple[RobotConfig, CameraConfig, SceneConfig, int, tuple[str, ...]]


class _Kept(threading.local):
    """The scenes each thread compiled last, which hold OpenGL contexts of that thread."""

    def __init__(self) -> None:
        self.simulations: OrderedDict[Key, Simulation] = OrderedDict()


_KEPT = _Kept()


def simulation(robot: RobotConfig, camera: CameraConfig, scene: SceneConfig, movers: int = 0) -> Simulation:
    """The compiled scene, kept for this thread's next trials with the same settings: compiling costs as much as one.

    ``movers`` is the number of robots beside observer and stimulus.
    """
    kept, key = _KEPT.simulations, (robot, camera, scene, movers, tuple(map(sha256, map(Path, files(scene)))))
    if key not in kept:
        while len(kept) >= KEPT_SCENES:
            kept.popitem(last=False)[1].close()
        further = {f"mover{i}": TRIAL_ROBOTS["stimulus"] for i in range(movers)}
        kept[key] = Simulation(robot, camera, scene, {**TRIAL_ROBOTS, **further})
    kept.move_to_end(key)
    return kept[key]


def forget_simulations() -> None:
    """Close the scenes that this thread keeps."""
    while _KEPT.simulations:
        _KEPT.simulations.popitem()[1].close()


def scene_of(condition: Condition, settings: Settings) -> SceneConfig:
    """The scene's settings with what the condition sets itself."""
    looks = {name: getattr(condition, name) for name in ("shell_grey", "wall_contrast")}
    return dataclasses.replace(settings.scene, **{name: value for name, value in looks.items() if value is not None})


def run_trial(spec: TrialSpec, *, keep_media: bool = False, watch: Watch | None = None) -> TrialResult:
    """Run one trial; the same specification gives the same result, wall time aside, in any process.

    ``keep_media`` also returns camera frames and the first model's layer maps, for a recording. Raises
    `TrialError` if the stimulus does not get to the end of its path, or every model breaks. A stimulus that drives
    open loop stops by time, wherever it is then. Where models see through other eyes
    (`through`), the trial is simulated for each. ``watch`` sees it after each frame.
    """
    began = time.perf_counter()
    settings = spec.settings
    by_eye = models_by_eye(settings.models)
    seen = {eye: _see(spec, eye, models, keep_media, watch) for eye, models in by_eye.items()}
    wall_s = time.perf_counter() - began
    first = next(iter(seen.values()))
    if any(runner.poses != first.poses for runner in seen.values()):
        raise TrialError("the robots moved otherwise before the other eye: this is a defect of the bench")
    columns = columns_of(first.frames, first.poses, settings)
    parts = parts_of(spec.condition, settings.camera, columns)
    runners = {runner.label: runner for eye in seen.values() for runner in eye.watching}
    watching = [runners[model.label] for model in settings.models]
    series = [(runner.chosen, given) for runner in watching if (given := runner.series()) is not None]
    answers = tuple(answer(chosen, given, parts, settings.camera.fps) for chosen, given in series)
    broken = {runner.label: runner.trouble for runner in watching if runner.trouble}
    if not answers:
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in broken.items()))
    media = None
    if keep_media:
        pictures = {eye: runner.frames for eye, runner in seen.items()}
        media = collect(pictures, [] if watching[0].trouble else watching[0].responses)
    return _result(spec, first.route, columns, [p for p, _ in first.poses], parts, answers, broken, media, wall_s)


class RunningTrial:
    """A trial before one eye, advanced one frame at a time: by `run_trial` to its end, by ``colias live`` at will.

    Attributes
    ----------
    sim
        The simulation.
    route
        What its robots are asked to do.
    drive
        What commands them, and says when the trial is over.
    watching
        The models, each with its answers.
    frames, poses
        What was seen, and the poses of stimulus and observer, where ``keep`` is set.

    Parameters
    ----------
    spec
        The trial.
    eye
        The camera.
    models
        Those that see through it.
    keep
        Whether frames, poses and answers are kept; a trial by hand may be endless.
    """

    def __init__(
        self, spec: TrialSpec, eye: CameraConfig, models: Sequence[ConfiguredModel], *, keep: bool = True
    ) -> None:
        settings, condition = spec.settings, spec.condition
        self.sim = sim = simulation(settings.robot, eye, scene_of(condition, settings), len(condition.movers))
        placing, scenery, self._noise = (stream(f"trial.{part}", spec.seed) for part in ("placing", "scenery", "noise"))
        self.route = course(condition, settings, placing)
        others = {name: script.route.body(script.route.start) for name, script in self.route.others.items()}
        sim.reset({**others, "stimulus": self.route.start}, scenery)
        self.watching = [ModelRunner(chosen, (eye.height, eye.width), keep=keep) for chosen in models]
        self._keep = keep
        self.frames: list[Frame] = []
        self.poses: list[tuple[Pose, Pose]] = []
        hand = condition.hand
        self._changes = () if hand is None else hand.changes
        self.drive: Drive | HandDrive = Drive(sim, self.route) if hand is None else HandDrive(sim, hand)
        self.seen = 0

    def step(self) -> tuple[Frame, list[Response | None]]:
        """Advance by a frame; return it and each model's answer, ``None`` of one that has broken.

        Raises
        ------
        TrialError
            The stimulus got stuck, or a robot is astray.
        """
        for model, values in changes_at(self._changes, self.seen).items():
            change(self.watching, model, values)
        sim = self.sim
        frame = sim.step(self._noise, self.drive)
        answers = [runner.see(frame.luma) for runner in self.watching]
        self.seen += 1
        if self._keep:
            self.frames.append(frame)
            self.poses.append((sim.robots["stimulus"].pose, sim.robots["observer"].pose))
        try:
            self.drive.look()
        except AstrayError as error:
            raise TrialError(str(error)) from None
        if not self.drive.over and isinstance(self.drive, Drive) and sim.data.time > 3.0 + 2.0 * self.route.seconds:
            raise TrialError("the stimulus got stuck on its way")
        return frame, answers


def _see(
    spec: TrialSpec, eye: str, models: Sequence[ConfiguredModel], keep_media: bool, watch: Watch | None
) -> RunningTrial:
    """Simulate the trial before one eye. Only the first model of the trial keeps its layer maps."""
    trial = RunningTrial(spec, camera(spec.settings, eye), models)
    trial.watching[0].maps = keep_media and models[0] is spec.settings.models[0]
    while not trial.drive.over:
        trial.step()
        if watch is not None:
            watch(eye, trial)
    return trial


Watch = Callable[[str, RunningTrial], None]
"""Watcher of a running trial: it gets the eye's name and the trial after each frame, and changes nothing."""


def _result(
    spec: TrialSpec,
    route: Course,
    columns: FrameColumns,
    poses: list[Pose],
    parts: Windows,
    answers: tuple[TrialAnswer, ...],
    broken: Mapping[str, str],
    media: Media | None,
    wall_s: float,
) -> TrialResult:
    along, offset = tracked(route.stimulus.route, poses)
    masks = [(along >= enter) & (along <= leave) for enter, leave in route.parts]
    masks = [mask for mask in masks if mask.sum() > 1]  # a stimulus that drives open loop may stop too early
    steady = np.logical_or.reduce(masks) if masks else np.zeros(len(along), bool)
    return TrialResult(
        spec=spec,
        answers=answers,
        broken=broken,
        achieved_speed_cm_s=_achieved(spec.condition, route, along, columns.sim_time_s, masks) if masks else None,
        path_error_mm=1000 * float(np.abs(offset[steady]).max()) if masks else None,
        drift_mm=1000 * float(offset[-1]),
        drive="open" if spec.settings.robot.open_loop else "feedback",
        closest_cm=float(away_cm(columns, spec.settings.camera.forward_cm).min()),
        seconds_in_view=float(parts.in_view.sum()) / spec.settings.camera.fps,
        frames=len(poses),
        wall_s=wall_s,
        columns=columns,
        media=media,
    )


def tracked(route: Route, poses: list[Pose]) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
    """Return how far along a route poses are that follow each other, and how far beside it, (T,) in metres."""
    tracker, along, offset = Tracker(route), [], []
    for pose in poses:
        tracker.see(pose)
        along.append(tracker.along)
        offset.append(tracker.offset)
    return np.array(along), np.array(offset)


def _achieved(
    condition: Condition,
    route: Course,
    along: npt.NDArray[np.float64],
    times: npt.NDArray[np.float64],
    masks: Sequence[npt.NDArray[np.bool_]],
) -> float:
    """Return the mean speed; where that changes along the path, by how it compares with the one asked for there."""
    parts = [(float(along[mask].min()), float(along[mask].max())) for mask in masks]
    mean = sum(np.ptp(along[mask]) for mask in masks) / sum(np.ptp(times[mask]) for mask in masks)
    return 100 * float(mean) * (condition.speed_cm_s / 100 / route.stimulus.schedule().speed_over(parts))


def parts_of(condition: Condition, camera: CameraConfig, columns: FrameColumns) -> Windows:
    """Find the parts of a trial in its frames, from its poses."""
    away = away_cm(columns, camera.forward_cm)
    return windows(condition, camera, columns.sim_time_s, columns.stimulus_bearing_deg, away)


def away_cm(columns: FrameColumns, forward_cm: float) -> npt.NDArray[np.float64]:
    """Return how far the stimulus's centre is from the lens in every frame, (T,), wherever the observer was by then."""
    heading = np.radians(columns.observer_heading_deg)
    lens_x = columns.observer_x_cm + forward_cm * np.cos(heading)
    lens_y = columns.observer_y_cm + forward_cm * np.sin(heading)
    return np.hypot(columns.stimulus_x_cm - lens_x, columns.stimulus_y_cm - lens_y)


def answer(model: ConfiguredModel, series: ResponseSeries, parts: Windows | None, fps: float) -> TrialAnswer:
    """Say what a model made of a trial's frames.

    Parameters
    ----------
    model
        The model.
    series
        Its answers, T frames long.
    parts
        The parts of the trial, if it is known where the stimulus was.
    fps
        Frames per second.
    """
    counts = spike_counts(model, series)
    spikes = counts["spikes"]
    return TrialAnswer(
        model=model.label,
        channels=model.channels,
        thresholds=model.thresholds,
        **counts,
        firing_rate_hz=None if spikes is None else spikes / (len(series.hs) / fps),
        peak_hs=float(series.hs.max()),
        trough_hs=float(series.hs.min()),
        peak_vs=float(series.vs.max()),
        trough_vs=float(series.vs.min()),
        peak_looming=float(series.looming.max()),
        parts=None if parts is None else measure(series, model.counted if spikes is not None else "", parts, fps),
        series=series,
    )


def columns_of(frames: list[Frame], poses: list[tuple[Pose, Pose]], settings: Settings) -> FrameColumns:
    """Return time and poses of frames, from them and the poses of stimulus and observer after each."""
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
