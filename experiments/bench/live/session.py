"""The sessions behind the page: models that watch frames without an end, and what a person may do with them."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2

from colias_sim import Pose
from colias_sim.pose import WheelSpeeds
from dsnn import Response
from experiments import NAMES
from experiments.behaviours import BEHAVIOURS
from experiments.bench import registry
from experiments.bench.api import run
from experiments.bench.result import Run
from experiments.bench.run.errors import TrialError, UsageError, short
from experiments.bench.run.files import new_folder
from experiments.bench.run.models import choose, look_up, rate_notes
from experiments.bench.run.play import ModelRunner, Sample, Showing, change
from experiments.bench.run.settings import assignments, watchers
from experiments.bench.run.streams import stream
from experiments.bench.sources.behaviour import Policy
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.designs import visit
from experiments.bench.sources.episodes import declared_part, load_behaviour, wheels
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.hand import (
    FASTEST_CM_S,
    FASTEST_DEG_S,
    LONGEST_FRAMES,
    Change,
    Hand,
    HandDrive,
    Place,
    Robot,
    place_of,
)  # fmt: skip
from experiments.bench.sources.robot import RobotSource
from experiments.bench.sources.video import VideoSource
from experiments.bench.trials import plan
from scenes import ARENA_RADIUS_CM

WORLD = ("scene.", "camera.")
"""What the parameters of the world begin with."""
START: Mapping[Robot, Place] = {"stimulus": (12.0, 11.0, -90.0), "observer": (0.0, 0.0, 0.0)}
"""Places at the start: the stimulus beside the view, pointing across it."""
ROBOTS = tuple(START)
ROOM_CM = 3.0
"""Distance that robots keep from the wall, and that their middles keep beyond touching."""


class Session:
    """Models that watch frames without an end, and what one does with them.

    What is refused raises `UsageError`, and what is under way goes on then.

    Attributes
    ----------
    models, given
        Their texts, as after ``--model``; those that the command was given.
    settings
        Parameter -> text, as after ``--set``.
    values
        Model's label -> parameter -> text: those that were changed on the page.
    showing
        The frames and the models at work.
    number
        Frames since the beginning.
    cost_s
        Model's label -> time that it took for the last frame.
    interval_s
        Time between two frames.
    paced
        Whether frames are to be shown at that rate; a camera has a rate of its own.
    """

    interval_s: float
    paced = True

    def __init__(self, models: Sequence[str], texts: Sequence[str]) -> None:
        cv2.setNumThreads(1)
        self.models = self.given = tuple(models)
        self.settings = dict(text.partition("=")[::2] for text in texts)
        self.values: dict[str, dict[str, str]] = {}
        self.cost_s: dict[str, float] = {}
        self._maps = False

    @property
    def runners(self) -> list[ModelRunner]:
        """The models at work."""
        return self.showing.runners

    @property
    def responses(self) -> dict[str, Response | None]:
        """The models' responses to the last frame, by label; ``None`` of one that raised."""
        return dict(zip((runner.label for runner in self.runners), self.showing.responses, strict=True))

    def step(self) -> Sample:
        """Advance by a frame, and return it.

        Raises
        ------
        TrialError
            The trial of an experiment went wrong, the behaviour did, the film ended early, or all its models raised.
        """
        before = {runner: runner.seconds for runner in self.runners}  # a film that restarts has new ones
        sample = self._next()
        self.number += 1
        self.cost_s = {one.label: one.seconds - before.get(one, 0.0) for one in self.runners}
        return sample

    def _next(self) -> Sample:
        """Show the next frame to the models."""
        raise NotImplementedError

    def change(self, model: str, name: str, text: str) -> None:
        """Change a parameter of a model, from the next frame on; there it begins anew, from rest."""
        self._change(model, {name: text})
        self.values.setdefault(model, {})[name] = text

    def _change(self, model: str, values: Mapping[str, str]) -> None:
        change(self.runners, model, values)

    def reset_parameters(self) -> None:
        """Give every model the parameters that it began with, from the next frame on."""
        for runner in self.runners:
            if changed := self.values.pop(runner.label, None):
                began = assignments({name: getattr(runner.chosen.network, name) for name in changed})
                self._change(runner.label, dict(text.split("=", 1) for text in began))

    def show_maps(self, wanted: bool) -> None:
        """Let the first model compute its layer maps, from the next frame on, or no longer."""
        self._maps = self.runners[0].maps = wanted

    def _show(self, models: Sequence[str], showing: Showing) -> None:
        """Let these models watch from now on, with what was changed of those that watched before."""
        self.models, self.showing, self._samples, self.number = tuple(models), showing, iter(showing), 0
        self.show_maps(self._maps)
        labels = {runner.label for runner in showing.runners}
        self.values = {label: values for label, values in self.values.items() if label in labels}
        for label, values in self.values.items():
            self._change(label, values)

    def _kept(self, models: Sequence[str]) -> dict[str, str]:
        """Return the settings without those of models that are no longer shown."""
        before, now = ({model.section for model in look_up(texts)} for texts in (self.models, models))
        return {key: text for key, text in self.settings.items() if key.partition(".")[0] not in before - now}


class FootageSession(Session):
    """Models that watch a video, a camera or pictures. A file begins again after its end.

    Parameters
    ----------
    source
        A video file, the index of a camera, or a folder of pictures.
    models, texts
        Models, and ``SECTION.NAME=VALUE`` texts of their parameters.
    """

    def __init__(self, source: str, models: Sequence[str], texts: Sequence[str] = ()) -> None:
        super().__init__(models, texts)
        self.source, self._until_s = source, 0.0
        watchers(models, texts)  # refused before anything is opened
        self._open()
        self.choose_models(models)

    def _open(self) -> None:
        self.film = VideoSource(self.source)
        self.paced, self.interval_s = not self.film.is_camera, 1.0 / self.film.fps

    @property
    def title(self) -> str:
        """Return what is shown, in words."""
        (width, height), (columns, rows) = self.film.own_size, self.film.size
        name = self.film.label() if self.film.is_camera else Path(self.source).name
        return f"{name}, {width}x{height} px, seen at {columns}x{rows}"

    def notes(self) -> list[str]:
        """Return what to know of the models before this film, a line each."""
        rate = self.film.rate
        return [] if rate is None else rate_notes((runner.chosen, rate) for runner in self.runners)

    def begin(self) -> None:
        """Begin the file again; a camera goes on, and the models begin from rest."""
        if not self.film.is_camera:
            self._open()
        self.choose_models(self.models)

    def choose_models(self, models: Sequence[str]) -> None:
        """Show the frames from the next one on to these models."""
        settings = self._kept(models)
        chosen, _ = watchers(models, assignments(settings))
        self.settings = settings
        self._show(models, Showing(self.film, chosen, keep=False))

    def record(self) -> Run:
        """Refuse: another command watches it into a run's folder, which the refusal has."""
        raise UsageError(f"footage is not recorded from the page; this does it: {self.command()}")

    def command(self) -> str:
        """Return the command line of ``colias watch`` for these models, as they are now."""
        values = dict(self.settings)
        for runner in self.runners:
            values |= {f"{runner.section}.{name}": text for name, text in self.values.get(runner.label, {}).items()}
        models = [part for model in self.models for part in ("--model", model)]
        settings = [part for text in assignments(values) for part in ("--set", text)]
        return shlex.join(["colias", "watch", self.source, "--only", *models, *settings])

    def _next(self) -> Sample:
        sample = next(self._samples, None)
        if sample is None:
            if early := self.film.ended_early(self.number, self._until_s):
                raise TrialError(early)
            self.begin()
            return self._next()
        if not any(self.showing.responses):
            raise TrialError("\n".join(f"{label} broke: {why}" for label, why in self.showing.troubles().items()))
        self._until_s = sample.time_s
        return sample


class ArenaSession(Session):
    """Models that watch a trial of the simulation.

    What changes the apparatus or the models begins a new trial, with the robots where they are. Commands to robots
    and parameters of models change within a trial, from the next frame on.

    Attributes
    ----------
    looped
        The experiment and the number of its condition that the stimulus is driven along; ``None``: by hand.
    speed_cm_s
        At which robots are driven.
    experiments, behaviours
        Names of the experiments whose conditions can be looped, and of what can drive the observer.

    Parameters
    ----------
    models, texts, seed
        Models, ``SECTION.NAME=VALUE`` texts, and the seed of every trial.
    experiment
        An experiment whose first condition is looped at the beginning, by name or file; empty: by hand.
    behaviour
        A behaviour that drives the observer at the beginning, by name or file; empty: a hand.
    """

    def __init__(
        self, models: Sequence[str], texts: Sequence[str] = (), seed: int = 0, *, experiment: str = "",
        behaviour: str = "",
    ) -> None:  # fmt: skip
        super().__init__(models, texts)
        self.seed, self._began, self.speed_cm_s = seed, self.settings, 8.0
        self.experiments = tuple(dict.fromkeys([*NAMES, experiment] if experiment else NAMES))
        sighted = [name for name, entry in BEHAVIOURS.items() if entry.senses == "neural"]
        self.behaviours = tuple(dict.fromkeys([*sighted, behaviour] if behaviour else sighted))
        self.looped: tuple[str, int] | None = None
        self._behaviour: tuple[str, ModelRunner, Policy] | None = None
        self._wheels: dict[Robot, tuple[float, float]] = {}
        self._begin(models, self.settings, START, (experiment, 0) if experiment else None)
        if behaviour:
            self.behave(behaviour)

    @property
    def title(self) -> str:
        """Return what is shown, in words."""
        return f"{Path(self.looped[0]).name}: {self.spec.condition.label()}" if self.looped else "by hand"

    @property
    def behaviour(self) -> str:
        """The name of the behaviour that drives the observer; empty where a hand does."""
        return self._behaviour[0] if self._behaviour else ""

    @property
    def poses(self) -> dict[str, Pose]:
        """Where the robots are."""
        return {name: robot.pose for name, robot in self.trial.sim.robots.items()}

    def conditions(self, name: str) -> tuple[Condition, ...]:
        """Return the conditions of an experiment that can be looped."""
        return self._experiment(name).conditions()

    def _experiment(self, name: str) -> Experiment:
        if name not in self.experiments:
            raise UsageError(f"unknown experiment '{short(name)}': known are {', '.join(self.experiments)}")
        return registry.load(name)

    def begin(self, places: Mapping[Robot, Place] | None = START) -> None:
        """Begin a trial, with the robots at these places; ``None``: where they are."""
        self._begin(self.models, self.settings, places, self.looped)

    def _begin(
        self, models: Sequence[str], settings: dict[str, str], places: Mapping[Robot, Place] | None,
        looped: tuple[str, int] | None,
    ) -> None:  # fmt: skip
        places = START if looped else places or {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        hand = visit(Hand(LONGEST_FRAMES, places["stimulus"], places["observer"]))
        experiment, index = (self._experiment(looped[0]), looped[1]) if looped else (hand, 0)
        specs = plan(experiment, models, assignments(settings), 1, self.seed).specs()
        if not 0 <= index < len(specs):
            raise UsageError(f"condition of {experiment.name} must be between 0 and {len(specs) - 1}, got {index}")
        spec = specs[index]
        try:
            showing = Showing(RobotSource(spec, spec.settings.camera), spec.models, keep=False)
        except ValueError as error:
            raise UsageError(str(error)) from error
        self.settings, self.looped, self.spec, self._places = settings, looped, spec, places
        self.trial: RobotSource = showing.source
        self.interval_s = self.trial.sim.frame_interval
        self._changes: list[Change] = []
        self._wheels.clear()
        self._show(models, showing)

    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models, from a new trial on."""
        self._begin(models, self._kept(models), None, self.looped)

    def set(self, key: str, text: str) -> None:
        """Change a parameter of the apparatus, from a new trial on."""
        self._begin(self.models, {**self.settings, key: text}, None, self.looped)

    def reset_world(self) -> None:
        """Give scene and camera the parameters that they began with, from a new trial on."""
        others = {key: text for key, text in self.settings.items() if not key.startswith(WORLD)}
        began = {key: text for key, text in self._began.items() if key.startswith(WORLD)}
        self._begin(self.models, others | began, None, self.looped)

    def show(self, name: str, index: int = 0) -> None:
        """Loop a condition of an experiment, by its number; an empty name drives by hand again."""
        self._begin(self.models, self.settings, START, (name, index) if name else None)
        self._behaviour = None

    def _change(self, model: str, values: Mapping[str, str]) -> None:
        super()._change(model, values)
        self._changes += [(self.number, model, name, text) for name, text in values.items()]

    def drive(self, robot: Robot, ahead: float, turn: float = 0.0) -> None:
        """Drive a robot from now on, at a share of the speed (-1 to 1), turning by degrees/s, left positive."""
        self._check_hand()
        self._wheels[robot] = (ahead * self.speed_cm_s, turn)

    def _check_hand(self) -> None:
        if self.looped:
            raise UsageError("a condition of an experiment drives the robots: choose 'by hand' to drive them")

    def set_speed(self, speed_cm_s: float) -> None:
        """Set the speed of driving, for robots under way too."""
        if not 0.1 <= speed_cm_s <= FASTEST_CM_S:
            raise UsageError(f"speed must be between 0.1 and {FASTEST_CM_S:g} cm/s, got {speed_cm_s:g}")
        before, self.speed_cm_s = self.speed_cm_s, speed_cm_s
        self._wheels = {name: (v * speed_cm_s / before, turn) for name, (v, turn) in self._wheels.items()}

    def behave(self, name: str) -> None:
        """Give the observer to a behaviour that senses through a camera; an empty name takes it back."""
        if not name:
            self._behaviour = None
            self._wheels["observer"] = (0.0, 0.0)
            return
        self._check_hand()
        entry = load_behaviour(name) if name in self.behaviours else None
        if entry is None or entry.senses != "neural":
            raise UsageError(f"behaviour must be one of {', '.join(self.behaviours)}, got {short(name)}")
        runner = ModelRunner(choose(entry.model), self.trial.shape, keep=False)
        self._behaviour = name, runner, entry.make(stream("policy", self.seed))

    def _next(self) -> Sample:
        if self.trial.drive.over:
            self.begin(None)
        if isinstance(self.trial.drive, HandDrive):
            self._command(self.trial.drive)
        sample = next(self._samples)
        if self._behaviour is not None:
            self._act(sample, *self._behaviour)
        return sample

    def _act(self, sample: Sample, name: str, runner: ModelRunner, policy: Policy) -> None:
        """Let the behaviour respond to a frame."""
        answer = runner.see(sample.image)
        if answer is None:
            self.behave("")
            raise TrialError(f"the behaviour {name} broke: {runner.trouble}")
        shares = wheels(policy, declared_part(answer, runner.chosen.channels)).tolist()
        robot = self.trial.sim.robots["observer"]
        speed, turn = robot.motion_of(WheelSpeeds(*(share * robot.config.max_speed_cm_s / 100 for share in shares)))
        self._wheels["observer"] = (
            min(max(100 * speed, -FASTEST_CM_S), FASTEST_CM_S),
            math.degrees(min(max(turn, -math.radians(FASTEST_DEG_S)), math.radians(FASTEST_DEG_S))),
        )

    def _command(self, drive: HandDrive) -> None:
        poses = self.poses
        for robot in ROBOTS:
            speed, turn = self._wheels.get(robot, (0.0, 0.0))
            if _blocked(poses[robot], poses["observer" if robot == "stimulus" else "stimulus"], speed):
                speed = 0.0
            drive.command(robot, float(speed), float(turn))

    def hand(self) -> Hand:
        """Return what was done since the trial began, as data."""
        drive = self.trial.drive
        if not isinstance(drive, HandDrive):
            name = self.looped[0] if self.looped else ""
            raise UsageError(f"this is a trial of {name}: colias run {name} records it")
        if not self.trial.number:
            raise UsageError("nothing has happened yet")
        places = self._places
        return Hand(
            self.trial.number, places["stimulus"], places["observer"],
            tuple(c for c in drive.commands if c[0] < self.trial.number),
            tuple(c for c in self._changes if c[0] < self.trial.number),
        )  # fmt: skip

    def record(self, out: Path | None = None) -> Run:
        """Run the trial since it began once more, from what was done, into ``out`` or a new folder ``runs/live-TIME``.

        The run has every frame as it was on the page, bit for bit. A new trial begins then, with the robots where they
        are.
        """
        hand, folder = self.hand(), new_folder("live") if out is None else out
        places = {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        done = run(
            visit(hand), seed=self.seed, models=self.models, only=True, settings=self.settings, out=folder,
            workers=0, quiet=True,
        )  # fmt: skip
        self._begin(self.models, self.settings, places, None)
        return done


def _blocked(pose: Pose, other: Pose, speed: float) -> bool:
    """Say whether a robot that drives on would come too near the wall or the other robot."""
    way = math.copysign(0.01, speed)
    x, y = pose.x + way * math.cos(pose.heading), pose.y + way * math.sin(pose.heading)
    here, there = math.hypot(pose.x, pose.y), math.hypot(x, y)
    if 100 * there > ARENA_RADIUS_CM - ROOM_CM and there > here:
        return True
    now, then = (math.hypot(px - other.x, py - other.y) for px, py in ((pose.x, pose.y), (x, y)))
    return 100 * then < 4.0 + ROOM_CM / 2 and then < now
