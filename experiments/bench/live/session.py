"""The running trial behind the page: what a person may do with it. It knows nothing of the page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import cv2
import numpy as np

from colias_sim import Frame, Pose
from dsnn import Response
from experiments.bench import registry
from experiments.bench.closed_loop.behaviour import Behaviour, Policy
from experiments.bench.closed_loop.episode import wheels
from experiments.bench.closed_loop.find import load_behaviour
from experiments.bench.closed_loop.seen import PartialResponse
from experiments.bench.engine.errors import UsageError, short
from experiments.bench.engine.model_runner import ModelRunner
from experiments.bench.engine.models import choose
from experiments.bench.public.result import Run
from experiments.bench.public.run import run
from experiments.bench.robot.experiment import Condition, Experiment
from experiments.bench.robot.hand import FASTEST_CM_S, FASTEST_DEG_S, LONGEST_FRAMES, Change, Hand, HandDrive, Place
from experiments.bench.robot.plan import plan
from experiments.bench.robot.trial import RunningTrial
from experiments.bench.robot.visit import visit
from experiments.bench.store.files import new_folder
from experiments.bench.streams import stream
from scenes import ARENA_RADIUS_CM

Robot = Literal["stimulus", "observer"]
START = {"stimulus": Place(12.0, 11.0, -90.0), "observer": Place(0.0, 0.0, 0.0)}
"""Places at the start: the stimulus beside the view, pointing across it."""
ROOM_CM = 3.0
"""Distance that robots keep from the wall, and that their middles keep beyond touching."""
NEAR_CM = 0.4
"""Distance from its target at which a driven robot stops."""
STEERING_PER_S = 4.0
"""Turn rate of a robot on its way to a target, for each radian that it is off it."""


@dataclass(frozen=True, slots=True)
class View:
    """A frame of the session, for the page.

    ``answers`` has ``None`` for a model that has broken; ``seconds`` is what the models took, by label.
    """

    number: int
    frame: Frame
    answers: dict[str, Response | None]
    poses: dict[str, Pose]
    seconds: dict[str, float]
    began: bool
    """Whether a trial began with it."""


class Session:
    """A trial that goes on until another begins, and what one does in it.

    What changes the apparatus or the models begins a new trial, with the robots where they are. Commands to robots
    and parameters of models change within a trial, from the next frame on.

    Attributes
    ----------
    models
        The texts of the models, as after ``--model``.
    settings
        Parameter -> text, of the apparatus.
    values
        Model's label -> parameter -> text: those that were changed on the page.
    speed_cm_s
        At which robots are driven.

    Parameters
    ----------
    models
        One or more.
    assignments
        ``SECTION.NAME=VALUE`` texts.
    seed
        Of every trial.

    Raises
    ------
    UsageError
        A model or a parameter is not known, or a value is not legal.
    """

    def __init__(self, models: Sequence[str], assignments: Sequence[str] = (), seed: int = 0) -> None:
        cv2.setNumThreads(1)
        self.models, self.seed = tuple(models), seed
        self.settings = dict(text.partition("=")[::2] for text in assignments)
        self.values: dict[str, dict[str, str]] = {}
        self.speed_cm_s = 8.0
        self._shown: tuple[Experiment, Condition] | None = None
        self._target: dict[Robot, tuple[float, float]] = {}
        self._behaviour: tuple[Behaviour, ModelRunner, Policy] | None = None
        self._wheels: dict[Robot, tuple[float, float]] = {}
        self._maps = False
        self.begin(START)

    def begin(self, places: dict[str, Place] | None = None) -> None:
        """Begin a trial.

        Parameters
        ----------
        places
            Where the robots are put down; ``None``: where they are.

        Raises
        ------
        UsageError
            It cannot be run so. The trial under way goes on then.
        """
        self._begin(self.models, self.settings, places, self._shown)

    def _begin(
        self, models: tuple[str, ...], settings: dict[str, str], places: dict[str, Place] | None,
        shown: tuple[Experiment, Condition] | None,
    ) -> None:  # fmt: skip
        texts = [f"{key}={text}" for key, text in settings.items()]
        places = places or self._present()
        experiment = shown[0] if shown else visit(Hand(LONGEST_FRAMES, places["stimulus"], places["observer"]))
        specs = plan(experiment, models, texts, 1, self.seed).specs()
        spec = specs[0] if shown is None else next(s for s in specs if s.condition == shown[1])
        camera = spec.settings.camera
        try:
            trial = RunningTrial(spec, camera, spec.settings.models, keep=False)
        except ValueError as error:
            raise UsageError(str(error)) from None
        self.models, self.settings, self._shown = models, settings, shown
        self.trial, self.spec, self._places, self._fresh = trial, spec, places, True
        self.show_maps(self._maps)
        self._changes: list[Change] = []
        self._target.clear()
        self._wheels.clear()
        labels = {model.label for model in spec.settings.models}
        self.values = {label: values for label, values in self.values.items() if label in labels}
        for label, values in self.values.items():
            if values:
                self._change(label, values)

    def _present(self) -> dict[str, Place]:
        robots = self.trial.sim.robots
        return {name: Place.of(robots[name].pose) for name in START}

    @property
    def by_hand(self) -> bool:
        """Tell whether the stimulus is driven by hand, not along a condition of an experiment."""
        return self._shown is None

    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models, from a new trial on."""
        self._begin(tuple(dict.fromkeys(models)), self.settings, None if self.by_hand else START, self._shown)

    def set(self, key: str, text: str) -> None:
        """Change a parameter of the apparatus, from a new trial on; an empty text is its default."""
        settings = {**self.settings, key: text}
        if not text:
            del settings[key]
        self._begin(self.models, settings, None if self.by_hand else START, self._shown)

    def show(self, name: str, index: int = 0) -> None:
        """Loop a condition of an experiment; an empty name drives by hand again.

        Parameters
        ----------
        name
            As ``colias run`` takes it.
        index
            Which condition.
        """
        if not name:
            self._begin(self.models, self.settings, START, None)
            return
        experiment = registry.find(name)
        if not isinstance(experiment, Experiment):
            raise UsageError(f"{name} has no trials with the robot")
        conditions = experiment.conditions()
        if not 0 <= index < len(conditions):
            raise UsageError(f"{name}: condition {index}: legal is 0 to {len(conditions) - 1}")
        self._begin(self.models, self.settings, START, (experiment, conditions[index]))

    def change(self, model: str, name: str, text: str) -> None:
        """Change a parameter of a model, from the next frame on; there it begins anew, from rest.

        Raises
        ------
        UsageError
            The value is not legal; nothing has changed.
        """
        self._change(model, {name: text})
        self.values.setdefault(model, {})[name] = text

    def _change(self, model: str, values: dict[str, str]) -> None:
        self.trial.change(model, values)
        self._changes += [Change(self.trial.seen, model, name, text) for name, text in values.items()]

    def show_maps(self, wanted: bool) -> None:
        """Let the first model compute its layer maps, from the next frame on, or no longer."""
        self._maps = wanted
        self.trial.showing = self.spec.settings.models[0] if wanted else None

    def reset_parameters(self) -> None:
        """Give every model the parameters that it began with, from the next frame on."""
        for label, values in self.values.items():
            network = next(m.network for m in self.spec.settings.models if m.label == label)
            self._change(label, {name: _text(getattr(network, name)) for name in values})
        self.values = {}

    def drive(self, robot: Robot, ahead: float, turn: float = 0.0) -> None:
        """Drive a robot until it is told otherwise.

        Parameters
        ----------
        robot
            Which.
        ahead
            Share of the speed that is set, -1 to 1.
        turn
            Turn rate in degrees/s, left positive.
        """
        self._check_hand()
        self._target.pop(robot, None)
        self._wheels[robot] = (ahead * self.speed_cm_s, turn)

    def send(self, robot: Robot, x_cm: float, y_cm: float) -> None:
        """Let a robot drive to a place, in the arena."""
        self._check_hand()
        if not math.hypot(x_cm, y_cm) <= ARENA_RADIUS_CM:
            raise UsageError(f"({x_cm:g}, {y_cm:g}) cm is outside the arena: legal is up to {ARENA_RADIUS_CM:g} cm")
        self._target[robot] = (x_cm, y_cm)

    def _check_hand(self) -> None:
        if not self.by_hand:
            raise UsageError("a condition of an experiment drives the robots: choose 'by hand' to drive them")

    def set_speed(self, speed_cm_s: float) -> None:
        """Set the speed of driving, for robots under way too."""
        if not 0.1 <= speed_cm_s <= FASTEST_CM_S:
            raise UsageError(f"speed {speed_cm_s:g} cm/s: legal is 0.1 to {FASTEST_CM_S:g}")
        before, self.speed_cm_s = self.speed_cm_s, speed_cm_s
        self._wheels = {name: (v * speed_cm_s / before, turn) for name, (v, turn) in self._wheels.items()}

    def behave(self, name: str) -> None:
        """Give the observer to a behaviour; an empty name takes it back.

        Raises
        ------
        UsageError
            There is no such behaviour, or it needs a sense that it does not have here.
        """
        if not name:
            self._behaviour = None
            self._wheels["observer"] = (0.0, 0.0)
            return
        self._check_hand()
        entry = load_behaviour(name)
        if entry.senses != "neural":
            raise UsageError(f"{name} senses the state of its env, which is not here: legal are those with a camera")
        chosen, camera = choose(entry.model), self.spec.settings.camera
        runner = ModelRunner(chosen, (camera.height, camera.width), keep=False)
        self._behaviour = entry, runner, entry.make(stream("policy", self.seed))

    def step(self) -> View:
        """Advance by a frame.

        Raises
        ------
        TrialError
            The trial of an experiment went wrong.
        """
        if self.trial.drive.over:
            self.begin(START if self._shown else None)
        began, self._fresh = self._fresh, False
        drive, trial = self.trial.drive, self.trial
        if isinstance(drive, HandDrive):
            self._command(drive)
        before = {runner.label: runner.seconds for runner in trial.watching}
        frame, answers = trial.step()
        if self._behaviour is not None:
            self._act(frame)
        return View(
            trial.seen - 1, frame, {r.label: answer for r, answer in zip(trial.watching, answers, strict=True)},
            {name: robot.pose for name, robot in trial.sim.robots.items()},
            {runner.label: runner.seconds - before[runner.label] for runner in trial.watching}, began,
        )  # fmt: skip

    def _act(self, frame: Frame) -> None:
        """Let the behaviour answer a frame."""
        assert self._behaviour is not None
        entry, runner, policy = self._behaviour
        answer = runner.see(frame.luma)
        if answer is None:
            self._behaviour = None
            raise UsageError(f"the behaviour {entry.name} broke: {runner.trouble}")
        left, right = wheels(policy, PartialResponse(answer, runner.chosen.channels, runner.label)).tolist()
        robot = self.spec.settings.robot
        top = min(robot.max_speed_cm_s, FASTEST_CM_S)
        turn = math.degrees((right - left) * top / robot.track_cm)
        self._wheels["observer"] = (
            (left + right) / 2 * top, min(max(turn, -FASTEST_DEG_S), FASTEST_DEG_S),
        )  # fmt: skip

    def _command(self, drive: HandDrive) -> None:
        poses = {name: robot.pose for name, robot in self.trial.sim.robots.items()}
        for name in START:
            robot: Robot = "stimulus" if name == "stimulus" else "observer"
            if robot in self._target:
                self._steer(robot, poses[robot])
            speed, turn = self._wheels.get(robot, (0.0, 0.0))
            other = poses["observer" if robot == "stimulus" else "stimulus"]
            if self._blocked(poses[robot], other, speed):
                speed = 0.0
            drive.command(robot, float(speed), float(turn))

    def _steer(self, robot: Robot, pose: Pose) -> None:
        """Turn a robot towards its target, and drive there: backward where that is nearer to its heading."""
        x, y = self._target[robot]
        dx, dy = x - 100 * pose.x, y - 100 * pose.y
        if math.hypot(dx, dy) < NEAR_CM:
            del self._target[robot]
            self._wheels[robot] = (0.0, 0.0)
            return
        off = math.remainder(math.atan2(dy, dx) - pose.heading, 2 * math.pi)
        way = 1.0
        if abs(off) > math.pi / 2:
            way, off = -1.0, math.remainder(off - math.pi, 2 * math.pi)
        near = min(1.0, math.hypot(dx, dy) / 2)
        speed = way * self.speed_cm_s * near * max(math.cos(off), 0.0) ** 4
        turn = math.degrees(STEERING_PER_S * off)
        self._wheels[robot] = (speed, min(max(turn, -FASTEST_DEG_S), FASTEST_DEG_S))

    @staticmethod
    def _blocked(pose: Pose, other: Pose, speed: float) -> bool:
        """Say whether a robot that drives on would come too near the wall or the other robot."""
        way = math.copysign(0.01, speed)
        x, y = pose.x + way * math.cos(pose.heading), pose.y + way * math.sin(pose.heading)
        here, there = math.hypot(pose.x, pose.y), math.hypot(x, y)
        if 100 * there > ARENA_RADIUS_CM - ROOM_CM and there > here:
            return True
        now, then = (math.hypot(px - other.x, py - other.y) for px, py in ((pose.x, pose.y), (x, y)))
        return 100 * then < 4.0 + ROOM_CM / 2 and then < now

    def hand(self) -> Hand:
        """Return what was done since the trial began, as data.

        Raises
        ------
        UsageError
            Nothing was, or a condition of an experiment drives.
        """
        drive = self.trial.drive
        if not isinstance(drive, HandDrive):
            raise UsageError(f"this is a trial of {self.spec.experiment}: colias run {self.spec.experiment} records it")
        if not self.trial.seen:
            raise UsageError("nothing has happened yet")
        places = self._places
        return Hand(
            self.trial.seen, places["stimulus"], places["observer"],
            tuple(c for c in drive.commands if c.frame < self.trial.seen),
            tuple(c for c in self._changes if c.frame < self.trial.seen),
        )  # fmt: skip

    def record(self, out: Path | None = None) -> Run:
        """Record the trial since it began: run it once more, from what was done, into a run's folder.

        A new trial begins then, with the robots where they are.

        Parameters
        ----------
        out
            The folder; otherwise a new one, ``runs/live-TIME``.

        Returns
        -------
        Run
            With every frame as it was on the page, bit for bit.
        """
        hand, places = self.hand(), self._present()
        folder = new_folder("live") if out is None else out
        done = run(
            visit(hand), seed=self.seed, models=self.models, only=True, settings=self.settings, out=folder,
            workers=0, quiet=True,
        )  # fmt: skip
        self._begin(self.models, self.settings, places, None)
        return done


def _text(value: Any) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def number_of(text: Any) -> float:
    """Return a number that a page sent; `UsageError` where it is none."""
    try:
        value = float(text)
    except (TypeError, ValueError):
        raise UsageError(f"{short(text)}: legal is a number") from None
    if not np.isfinite(value):
        raise UsageError(f"{value}: legal is a finite number")
    return value
