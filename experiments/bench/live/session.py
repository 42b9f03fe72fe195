"""The session behind the page: models that watch a trial of the simulation, and what a person may do with it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import cv2

from colias_sim import Pose
from colias_sim.pose import WheelSpeeds
from dsnn import Response
from experiments import NAMES
from experiments.bench import registry
from experiments.bench.api import run
from experiments.bench.result import Run
from experiments.bench.run.errors import TrialError, UsageError, short
from experiments.bench.run.files import new_folder
from experiments.bench.run.models import choose
from experiments.bench.run.play import ModelRunner, Sample, Showing, change
from experiments.bench.run.settings import assignments
from experiments.bench.run.streams import stream
from experiments.bench.sources.behaviour import Policy
from experiments.bench.sources.conditions import (
    FASTEST_CM_S,
    FASTEST_DEG_S,
    LONGEST_FRAMES,
    Change,
    Condition,
    Hand,
    Place,
    RobotName,
    place_of,
)  # fmt: skip
from experiments.bench.sources.episodes import declared_part, load_behaviour, wheels
from experiments.bench.sources.experiment import Experiment, visit
from experiments.bench.sources.robot import HandDrive, RobotSource
from experiments.bench.trials import plan
from scenes import ARENA_RADIUS_CM

WORLD = ("scene.", "camera.")
"""Prefixes of the parameters of the world."""
START: Mapping[RobotName, Place] = {"stimulus": (12.0, 11.0, -90.0), "observer": (0.0, 0.0, 0.0)}
"""Places at the start: the stimulus is out of view and points across it."""
ROBOTS = tuple(START)
ROOM_CM = 3.0
"""Distance that robots keep from the wall, and that their middles keep beyond touching."""


class Session:
    """Models that watch a trial without an end.

    A new parameter of the apparatus begins a new trial, with the robots where they are. Commands to robots and
    parameters of models change within a trial, from the next frame on. A change that is refused raises `UsageError`,
    and the trial goes on.

    Attributes
    ----------
    settings
        Parameter -> text, as after ``--set``.
    values
        Model's label -> parameter -> text, of the parameters that were changed on the page.
    showing
        The frames, and the models that watch them.
    number
        Frames since the beginning of the trial.
    cost_s
        Model's label -> time that it took for the last frame.
    interval_s
        Time between two frames.
    looped
        The experiment and the number of its condition that the stimulus is driven along; ``None``: by hand.
    speed_cm_s
        Speed at which robots are driven.
    experiments
        Names of the experiments whose conditions can be looped.

    Parameters
    ----------
    models, texts, seed
        Models, ``SECTION.NAME=VALUE`` texts, and the seed of every trial.
    experiment
        An experiment whose first condition is looped at the beginning, by name or file; empty: by hand.
    behaviour
        A behaviour that drives the observer, by name or file; empty: a hand.
    """

    def __init__(
        self, models: Sequence[str], texts: Sequence[str] = (), seed: int = 0, *, experiment: str = "",
        behaviour: str = "",
    ) -> None:  # fmt: skip
        cv2.setNumThreads(1)
        self.models, self.seed, self.speed_cm_s = tuple(models), seed, 8.0
        self.settings = self._first = dict(text.partition("=")[::2] for text in texts)
        self.values: dict[str, dict[str, str]] = {}
        self.cost_s: dict[str, float] = {}
        self.experiments = tuple(dict.fromkeys([*NAMES, experiment] if experiment else NAMES))
        self.looped: tuple[str, int] | None = None
        self._maps = False
        self._behaviour: tuple[str, ModelRunner, Policy] | None = None
        self._wheels: dict[RobotName, tuple[float, float]] = {}
        self._begin(self.settings, START, (experiment, 0) if experiment else None)
        if behaviour:
            self._behaviour = self._driver(behaviour)

    @property
    def title(self) -> str:
        """Return the condition that is looped, as text."""
        return f"{Path(self.looped[0]).name}: {self.spec.condition.label()}" if self.looped else "by hand"

    @property
    def runners(self) -> list[ModelRunner]:
        """The models that watch."""
        return self.showing.runners

    @property
    def responses(self) -> dict[str, Response | None]:
        """The models' responses to the last frame, by label; ``None`` of one that raised."""
        return dict(zip((runner.label for runner in self.runners), self.showing.responses, strict=True))

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

    def step(self) -> Sample:
        """Advance by a frame, and return it.

        Raises
        ------
        TrialError
            The trial of an experiment failed, or the behaviour raised.
        """
        if self.trial.drive.over:
            self.begin(None)
        if isinstance(self.trial.drive, HandDrive):
            self._command(self.trial.drive)
        before = [runner.seconds for runner in self.runners]
        sample = next(self._samples)
        self.number += 1
        costs = zip(self.runners, before, strict=True)
        self.cost_s = {runner.label: runner.seconds - earlier for runner, earlier in costs}
        if self._behaviour is not None:
            self._act(sample, *self._behaviour)
        return sample

    def begin(self, places: Mapping[RobotName, Place] | None = START) -> None:
        """Begin a trial, with the robots at these places; ``None``: where they are."""
        self._begin(self.settings, places, self.looped)

    def _begin(
        self, settings: dict[str, str], places: Mapping[RobotName, Place] | None, looped: tuple[str, int] | None
    ) -> None:
        places = START if looped else places or {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        hand = visit(Hand(LONGEST_FRAMES, places["stimulus"], places["observer"]))
        experiment, index = (self._experiment(looped[0]), looped[1]) if looped else (hand, 0)
        specs = plan(experiment, self.models, assignments(settings), 1, self.seed).specs()
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
        self.showing, self._samples, self.number = showing, iter(showing), 0
        self.show_maps(self._maps)
        for label, values in self.values.items():
            self._change(label, values)

    def set(self, key: str, text: str) -> None:
        """Change a parameter of the apparatus, from a new trial on."""
        self._begin({**self.settings, key: text}, None, self.looped)

    def reset_world(self) -> None:
        """Give scene and camera their first parameters, from a new trial on."""
        others = {key: text for key, text in self.settings.items() if not key.startswith(WORLD)}
        first = {key: text for key, text in self._first.items() if key.startswith(WORLD)}
        self._begin(others | first, None, self.looped)

    def show(self, name: str, index: int = 0) -> None:
        """Loop a condition of an experiment, by its number; an empty name drives by hand again."""
        self._begin(self.settings, START, (name, index) if name else None)

    def show_maps(self, wanted: bool) -> None:
        """Let the first model compute its layer maps, from the next frame on, or no longer."""
        self._maps = self.runners[0].maps = wanted

    def change(self, model: str, name: str, text: str) -> None:
        """Change a parameter of a model, from the next frame on, where the model restarts from rest."""
        self._change(model, {name: text})
        self.values.setdefault(model, {})[name] = text

    def _change(self, model: str, values: Mapping[str, str]) -> None:
        change(self.runners, model, values)
        self._changes += [(self.number, model, name, text) for name, text in values.items()]

    def reset_parameters(self) -> None:
        """Give every model its first parameters, from the next frame on."""
        for runner in self.runners:
            if changed := self.values.pop(runner.label, None):
                first = assignments({name: getattr(runner.chosen.network, name) for name in changed})
                self._change(runner.label, dict(text.split("=", 1) for text in first))

    def drive(self, robot: RobotName, ahead: float, turn: float = 0.0) -> None:
        """Drive a robot from now on, at a share of the speed (-1 to 1), turning by degrees/s, left positive."""
        if self.looped:
            raise UsageError("a condition of an experiment drives the robots: choose 'by hand' to drive them")
        self._wheels[robot] = (ahead * self.speed_cm_s, turn)

    def set_speed(self, speed_cm_s: float) -> None:
        """Set the speed of driving, for robots under way too."""
        if not 0.1 <= speed_cm_s <= FASTEST_CM_S:
            raise UsageError(f"speed must be between 0.1 and {FASTEST_CM_S:g} cm/s, got {speed_cm_s:g}")
        before, self.speed_cm_s = self.speed_cm_s, speed_cm_s
        self._wheels = {name: (v * speed_cm_s / before, turn) for name, (v, turn) in self._wheels.items()}

    def _driver(self, name: str) -> tuple[str, ModelRunner, Policy]:
        """Return a behaviour, with the model that it sees by."""
        entry = load_behaviour(name)
        if entry.senses != "neural":
            raise UsageError(f"--behaviour {name}: senses the state; here a behaviour has to see through the camera")
        runner = ModelRunner(choose(entry.model), self.trial.shape, keep=False)
        return name, runner, entry.make(stream("policy", self.seed))

    def _act(self, sample: Sample, name: str, runner: ModelRunner, policy: Policy) -> None:
        """Let the behaviour respond to a frame."""
        response = runner.see(sample.image)
        if response is None:
            self._behaviour = None
            self._wheels["observer"] = (0.0, 0.0)
            raise TrialError(f"the behaviour {name} raised: {runner.trouble}")
        shares = wheels(policy, declared_part(response, runner.chosen.channels)).tolist()
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
        """Return the commands and changes since the trial began, as data."""
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
        """Run the trial since it began once more, from its commands, into ``out`` or a new folder ``runs/live-TIME``.

        The run has every frame of the page, bit for bit. A new trial begins then, with the robots where they are.
        """
        hand, folder = self.hand(), new_folder("live") if out is None else out
        places = {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        done = run(
            visit(hand), seed=self.seed, models=self.models, only=True, settings=self.settings, out=folder,
            workers=0, quiet=True,
        )  # fmt: skip
        self._begin(self.settings, places, None)
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
