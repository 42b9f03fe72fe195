"""Trials with the robot: what the camera sees while the robots drive, with their poses, and what is measured."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import polars as pl

from colias_sim import OpenLoop, PathFollower, Robot, Schedule, Simulation, Tracker, bearing
from colias_sim.config import CameraConfig, EventConfig, RobotConfig, SceneConfig
from colias_sim.scene import groups_of, hidden
from colias_sim.simulation import TRIAL_ROBOTS
from experiments.base.errors import TrialError
from experiments.base.streams import stream
from experiments.base.user_code import sha256
from experiments.declare.conditions import Command, Condition, Hand, RobotName
from experiments.declare.experiment import Experiment
from experiments.settings.models import ConfiguredModel, event_camera, parse_label
from experiments.settings.settings import Settings
from experiments.show.course import Course, course, files, measured
from experiments.show.play import Controls, Sample, Trial, phase_of
from experiments.show.trial_rows import FRAME_SCHEMA, TRUE_FRAMES, agreement, away_cm, responses, windows
from experiments.store.tables import OBSERVER, finite

TRUE = "ov7670"
"""The preset that is a model of the robot's eye."""
GEOMETRY = ("width", "height", "hfov_deg", "fps", "forward_cm", "up_cm")
"""Settings that both eyes have in common: size, field of view, clock and place."""


def through(label: str) -> str:
    """Return the camera preset that a model sees through; empty: the camera of the settings."""
    return parse_label(label).eye


def camera(settings: Settings, eye: str) -> CameraConfig:
    """Return an eye's settings, with the size, field of view, clock and place of the camera as it is set."""
    if not eye:
        return settings.camera
    common = {name: getattr(settings.camera, name) for name in GEOMETRY}
    return replace(CameraConfig.preset(eye), **common)


MOST_SCENES = 6


@dataclass(frozen=True, slots=True)
class RobotTrial(Trial):
    """One trial with the robot, wholly determined.

    Parameters
    ----------
    settings
        What its apparatus is set to.
    """

    models: tuple[ConfiguredModel, ...] = field(init=False, compare=False)
    settings: Settings

    def __post_init__(self) -> None:
        object.__setattr__(self, "models", self.settings.models)
        object.__setattr__(self, "events", self.events or event_camera(self.models, self.settings.events))

    def sources(self) -> Iterator[tuple[str, RobotSource, Sequence[ConfiguredModel]]]:
        """Open the source of each eye, the eye of the first model first: the trial is simulated once for each."""
        by_eye: dict[str, list[ConfiguredModel]] = {}
        for model in self.models:
            by_eye.setdefault(through(model.label), []).append(model)
        for eye, models in by_eye.items():
            source = RobotSource(self, camera(self.settings, eye))
            with source.sim.camera(OBSERVER).in_use():
                yield eye, source, models

    @property
    def fps(self) -> float:
        """The camera's frame rate, 1/s."""
        return self.settings.camera.fps


def is_random(settings: Settings) -> bool:
    """Return whether trials differ between seeds: in start, motors, light, wall, a camera's noise, frames taken."""
    eyes = [camera(settings, through(model.label)) for model in settings.models]
    noises = ("shot_noise", "read_noise", "jitter_ms", "drop_probability")
    placing = settings.pose_sd_mm or settings.heading_sd_deg or settings.robot.motor_inequality_sd
    scenery = settings.scene.light_sd or settings.scene.turn_wall
    own = any(model.processor.every > 1 or model.declared.senses == "events" for model in settings.models)
    return bool(placing or scenery or own) or any(getattr(eye, noise) for eye in eyes for noise in noises)


def trial_seed(seed: int, index: int) -> int:
    """The seed of trial ``index``: a function of the experiment's seed and the index alone, in 0..2^32-1."""
    return int(np.random.SeedSequence(seed, spawn_key=(index,)).generate_state(1)[0])


def trials_of(
    experiment: Experiment, settings: Settings, repeats: int, seed: int, *, truth: bool = False,
    controls: Controls | None = None,
) -> list[RobotTrial]:  # fmt: skip
    """Every trial, by rounds of all conditions: a run cut short stays balanced, and more repeats only append."""
    conditions = experiment.conditions()
    return [
        RobotTrial(
            experiment.name, index, index // len(conditions), trial_seed(seed, index), condition, settings,
            truth=truth, controls=controls,
        )
        for index, condition in enumerate(conditions * repeats)
    ]  # fmt: skip


class _Scenes(threading.local):
    """The scenes each thread compiled last, which hold OpenGL contexts of that thread."""

    def __init__(self) -> None:
        self.simulations: dict[Any, Simulation] = {}


_SCENES = _Scenes()


def simulation(
    robot: RobotConfig, camera: CameraConfig, scene: SceneConfig, movers: int = 0, *, truth: bool = False,
    events: EventConfig | None = None,
) -> Simulation:  # fmt: skip
    """The compiled scene, kept for this thread's next trials with the same settings: compiling costs as much as one.

    ``movers`` is the number of robots beside observer and stimulus.
    """
    scenes = _SCENES.simulations
    key = robot, camera, scene, movers, truth, events, *map(sha256, map(Path, files(scene)))
    if key not in scenes:
        while len(scenes) >= MOST_SCENES:
            scenes.pop(next(iter(scenes))).close()
        further = {f"mover{i}": TRIAL_ROBOTS["stimulus"] for i in range(movers)}
        scenes[key] = Simulation(robot, camera, scene, {**TRIAL_ROBOTS, **further}, truth=truth, events=events)
    scenes[key] = scenes.pop(key)  # the one that was used last
    return scenes[key]


def forget_simulations() -> None:
    """Close the scenes that this thread keeps."""
    while _SCENES.simulations:
        _SCENES.simulations.popitem()[1].close()


def scene_of(condition: Condition, settings: Settings) -> SceneConfig:
    """Return the scene's settings with what the condition sets itself."""
    looks = {name: getattr(condition, name) for name in ("shell_grey", "wall_contrast")}
    return replace(settings.scene, **{name: value for name, value in looks.items() if value is not None})


class RobotSource:
    """The frames of a trial before one eye, with the poses of both robots at the end of each exposure.

    Equal trials give equal frames, in any process.

    Parameters
    ----------
    trial
        The trial.
    eye
        The camera.

    Attributes
    ----------
    sim
        The simulation.
    course
        What its robots are asked to do.
    drive
        What commands them, and says when the trial is over.
    number
        Frames so far.
    """

    def __init__(self, trial: RobotTrial, eye: CameraConfig) -> None:
        settings, condition = trial.settings, trial.condition
        self.trial, self._eye, self.fps, self.shape = trial, eye, eye.fps, (eye.height, eye.width)
        self.frame_columns = TRUE_FRAMES if trial.truth else FRAME_SCHEMA
        scene = scene_of(condition, settings)
        self.sim = simulation(settings.robot, eye, scene, len(condition.movers), truth=trial.truth, events=trial.events)
        placing, scenery, self._noise = (
            stream(f"trial.{part}", trial.seed) for part in ("placing", "scenery", "noise")
        )
        self.course, start = course(condition, settings, placing)
        starts = {name: script.route.body(script.route.start) for name, script in self.course.items()}
        self.sim.reset({**starts, "stimulus": start}, scenery, events=stream("trial.events", trial.seed))
        hand: Any = condition.hand
        self.drive: Drive | HandDrive = Drive(self.sim, self.course) if hand is None else HandDrive(self.sim, hand)
        self._tracker = Tracker(self.course["stimulus"].route)
        self.number = 0

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames until the trial is over.

        Raises
        ------
        TrialError
            The stimulus got stuck, or a robot met another one.
        """
        while not self.drive.over:
            yield self._next()

    def _next(self) -> Sample:
        frame = self.sim.step(self._noise, self.drive)
        darkest, brightest, _, _ = cv2.minMaxLoc(frame.luma)
        self.number += 1
        self.drive.look()
        lasting = 3.0 + 2.0 * self.course["stimulus"].seconds
        if not self.drive.over and isinstance(self.drive, Drive) and self.sim.data.time > lasting:
            raise TrialError("the stimulus got stuck on its way")
        poses = {name: self.sim.pose(name) for name in ("stimulus", OBSERVER)}
        ahead = bearing(poses[OBSERVER], poses["stimulus"], self.trial.settings.camera.forward_cm / 100)
        self._tracker.see(poses["stimulus"])
        truth: dict[str, Any] = {
            "robot": OBSERVER, "time_s": frame.time, "stimulus_bearing_deg": math.degrees(ahead),
            "along_m": self._tracker.along, "offset_m": self._tracker.offset,
            "exposure_ms": frame.exposure_ms, "row_time_us": frame.row_time_us,
            "darkest": int(darkest), "brightest": int(brightest),
        }  # fmt: skip
        for name, pose in poses.items():
            truth |= {f"{name}_x_cm": 100 * pose.x, f"{name}_y_cm": 100 * pose.y}
            truth[f"{name}_heading_deg"] = math.degrees(pose.heading)
        events = self.sim.event_camera.take() if self.sim.event_camera else None
        if not self.trial.truth:
            return Sample(frame.time, frame.luma, truth, events=events)
        things = set(self.sim.everyone) - {OBSERVER}
        pixels = {
            every: self.sim.truth(every) for every in {1, *(model.processor.every for model in self.trial.models)}
        }
        since = {
            every: {name: finite(value) for name, value in shown.columns(things).items()}
            for every, shown in pixels.items()
        }
        return Sample(frame.time, frame.luma, truth | since[1], pixels[1], since, events)

    @contextmanager
    def absent(self) -> Iterator[RobotSource]:
        """Open the same trial with every robot but the one that sees out of sight: they drive as they did."""
        with ExitStack() as stack:
            for name in self.sim.robots.keys() - {OBSERVER}:
                stack.enter_context(hidden(groups_of(self.sim.model, name)))
            yield RobotSource(self.trial, self._eye)

    def columns(self, truth: pl.DataFrame) -> dict[str, Any]:
        """Return the robot that sees, the condition, and what the stimulus did.

        Parameters
        ----------
        truth
            A row per camera frame: time, poses.
        """
        settings = self.trial.settings
        return {
            "robot": OBSERVER,
            **self.trial.condition.columns(),
            **self._driven(truth),
            "drive": "open" if settings.robot.open_loop else "feedback",
            "closest_cm": float(away_cm(truth, settings.camera.forward_cm).min()),
        }

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return what a model saw, and its responses in the whole trial and in parts of it.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame that it took: time, poses, responses.
        """
        camera = self.trial.settings.camera
        parts, fps = windows(self.trial.condition, camera, frames), camera.fps / model.processor.every
        return {
            "phase": phase_of(model, self.trial.seed),
            "seconds_in_view": float(parts["in_view"].sum()) / fps,
            "darkest": frames["darkest"].min(),
            "brightest": frames["brightest"].max(),
            **responses(model, frames, parts, fps),
            **(agreement(frames) if self.trial.truth else {}),
        }

    def _driven(self, frames: pl.DataFrame) -> dict[str, float | None]:
        """Return the speed that the stimulus reached, and how far it was off its path."""
        script = self.course["stimulus"]
        time_s, along, offset = (frames[name].to_numpy() for name in ("time_s", "along_m", "offset_m"))
        driven = measured(script, self.trial.settings.robot)
        masks = [(along >= enter) & (along <= leave) for enter, leave in driven]
        masks = [mask for mask in masks if mask.sum() > 1]  # a stimulus that drives open loop may stop too early
        drift = {"drift_mm": 1000 * float(offset[-1])}
        if not masks:
            return {"achieved_speed_cm_s": None, "path_error_mm": None, **drift}
        parts = [(float(along[mask].min()), float(along[mask].max())) for mask in masks]
        mean = sum(np.ptp(along[mask]) for mask in masks) / sum(np.ptp(time_s[mask]) for mask in masks)
        # Where the speed changes along the path, the mean counts by how it compares with the one asked for there.
        wanted = self.trial.condition.speed_cm_s / 100 / script.speed_over(parts)
        error = float(np.abs(offset[np.logical_or.reduce(masks)]).max())
        return {"achieved_speed_cm_s": 100 * float(mean) * wanted, "path_error_mm": 1000 * error, **drift}


ASTRAY_M = 0.01
"""Distance from its path at which a robot that is steered along it has met an obstacle."""


class Drive:
    """Commands all robots over a trial, and says when it is over."""

    def __init__(self, sim: Simulation, course: Course) -> None:
        self._sim, self.over = sim, False
        self._drivers = {
            name: _driver(sim.robots[name], script)
            for name, script in course.items()
            if any(stretch.moves or stretch.rate for stretch in script.route.stretches)
        }
        driver = self._drivers["stimulus"]
        self._ends = sim.robots["stimulus"].begins() + driver.seconds if isinstance(driver, OpenLoop) else None

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        for driver in self._drivers.values():
            driver.drive(dt)

    def look(self) -> None:
        """Note once a frame whether the trial is over: the stimulus passed the end or rested there, or its time is up.

        Raises `TrialError` where another robot is far off its path.
        """
        if self._ends is not None:
            self.over = float(self._sim.data.time) >= self._ends - 1e-9
        for name, driver in self._drivers.items():
            if isinstance(driver, PathFollower):
                driver.look()
                if name == "stimulus":
                    self.over = driver.over
                elif abs(driver.offset) > ASTRAY_M:
                    raise TrialError(f"{name} is {100 * abs(driver.offset):.1f} cm off its path: it met another robot")


def _driver(robot: Robot, script: Schedule) -> PathFollower | OpenLoop:
    if robot.config.open_loop or math.isinf(script.acceleration):
        return OpenLoop(robot, script)
    return PathFollower(robot, script.route, acceleration=script.acceleration)


class HandDrive:
    """Commands both robots by what a hand does: as recorded, or as it comes in.

    Attributes
    ----------
    commands
        Those that were given, in order of frame.
    frame
        The number of the frame that is next.
    over
        Whether all frames of the record are past.

    Parameters
    ----------
    sim
        The simulation, reset.
    hand
        The record.
    """

    def __init__(self, sim: Simulation, hand: Hand) -> None:
        self._sim, self._hand = sim, hand
        self._wanted = {"stimulus": (0.0, 0.0), "observer": (0.0, 0.0)}
        self.commands: list[Command] = []
        self.frame, self.over = 0, False
        self._take()

    def command(self, robot: RobotName, speed_cm_s: float, turn_deg_s: float) -> None:
        """Command a robot from the next frame on; a command that changes nothing is not noted."""
        if self._wanted[robot] != (speed_cm_s, turn_deg_s):
            self._wanted[robot] = speed_cm_s, turn_deg_s
            self.commands.append((self.frame, robot, speed_cm_s, turn_deg_s))

    def _take(self) -> None:
        """Give the recorded commands of the next frame."""
        for frame, robot, speed_cm_s, turn_deg_s in self._hand.commands:
            if frame == self.frame:
                self.command(robot, speed_cm_s, turn_deg_s)

    def __call__(self, dt: float) -> None:
        """Command the wheels for the next ``dt`` seconds."""
        for name, (speed, turn) in self._wanted.items():
            robot = self._sim.robots[name]
            robot.ease(robot.wheels_for(speed / 100, math.radians(turn)), dt)

    def look(self) -> None:
        """Take the commands of the next frame, once a frame."""
        self.frame += 1
        self.over = self.frame >= self._hand.frames
        self._take()
