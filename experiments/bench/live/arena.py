"""A trial that goes on until another begins, behind the page: its stimulus is driven by hand, or along a condition."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from colias_sim import Pose
from colias_sim.pose import WheelSpeeds
from experiments import NAMES
from experiments.behaviours import BEHAVIOURS
from experiments.bench import registry
from experiments.bench.api import run
from experiments.bench.live.session import Session, View
from experiments.bench.result import Run
from experiments.bench.run.errors import TrialError, UsageError, short
from experiments.bench.run.files import new_folder
from experiments.bench.run.models import choose
from experiments.bench.run.play import ModelRunner, Showing
from experiments.bench.run.streams import stream
from experiments.bench.sources.behaviour import Policy
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.episodes import PartialResponse, load_behaviour, wheels
from experiments.bench.sources.experiment import Experiment
from experiments.bench.sources.hand import FASTEST_CM_S, FASTEST_DEG_S, LONGEST_FRAMES, Change, Hand, HandDrive, Place
from experiments.bench.sources.robot import RobotSource
from experiments.bench.sources.visit import visit
from experiments.bench.trials import plan
from scenes import ARENA_RADIUS_CM

WORLD = ("scene.", "camera.")
"""What the parameters of the world begin with."""
Robot = Literal["stimulus", "observer"]
START: Mapping[Robot, Place] = {"stimulus": Place(12.0, 11.0, -90.0), "observer": Place(0.0, 0.0, 0.0)}
"""Places at the start: the stimulus beside the view, pointing across it."""
ROBOTS = tuple(START)
ROOM_CM = 3.0
"""Distance that robots keep from the wall, and that their middles keep beyond touching."""
NEAR_CM = 0.4
"""Distance from its target at which a driven robot stops."""
STEERING_PER_S = 4.0
"""Turn rate of a robot on its way to a target, for each radian that it is off it."""


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
    experiments
        Names of the experiments whose conditions can be looped.
    behaviours
        Names of the behaviours that the observer can be given to.

    Parameters
    ----------
    models
        One or more.
    assignments
        ``SECTION.NAME=VALUE`` texts.
    seed
        Of every trial.
    experiment
        An experiment whose first condition is looped at the beginning, by name or file; empty: by hand.
    behaviour
        A behaviour that drives the observer at the beginning, by name or file; empty: a hand.

    Raises
    ------
    UsageError
        A model, a parameter, the experiment or the behaviour is not known, or a value is not legal.
    """

    def __init__(
        self, models: Sequence[str], assignments: Sequence[str] = (), seed: int = 0, *, experiment: str = "",
        behaviour: str = "",
    ) -> None:  # fmt: skip
        super().__init__(models, assignments)
        self.seed, self._began = seed, self.settings
        self.experiments = tuple(dict.fromkeys([*NAMES, experiment] if experiment else NAMES))
        sighted = [name for name, entry in BEHAVIOURS.items() if entry.senses == "neural"]
        self.behaviours = tuple(dict.fromkeys([*sighted, behaviour] if behaviour else sighted))
        self.speed_cm_s = 8.0
        self.looped: tuple[str, int] | None = None
        self._target: dict[Robot, tuple[float, float]] = {}
        self._behaviour: tuple[str, ModelRunner, Policy] | None = None
        self._wheels: dict[Robot, tuple[float, float]] = {}
        self._begin(self.models, self.settings, START, (experiment, 0) if experiment else None)
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

    def conditions(self, name: str) -> tuple[Condition, ...]:
        """Return the conditions of an experiment that can be looped.

        Raises
        ------
        UsageError
            There is no such experiment here.
        """
        return self._experiment(name).conditions()

    def _experiment(self, name: str) -> Experiment:
        if name not in self.experiments:
            raise UsageError(f"unknown experiment '{short(name)}': known are {', '.join(self.experiments)}")
        return registry.load(name)

    def begin(self, places: Mapping[Robot, Place] | None = START) -> None:
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
        self._begin(self.models, self.settings, places, self.looped)

    def _begin(
        self, models: Sequence[str], settings: dict[str, str], places: Mapping[Robot, Place] | None,
        looped: tuple[str, int] | None,
    ) -> None:  # fmt: skip
        places = START if looped else places or self._present()
        hand = visit(Hand(LONGEST_FRAMES, places["stimulus"], places["observer"]))
        experiment, index = (self._experiment(looped[0]), looped[1]) if looped else (hand, 0)
        texts = [f"{key}={text}" for key, text in settings.items()]
        specs = plan(experiment, models, texts, 1, self.seed).specs()
        if not 0 <= index < len(specs):
            raise UsageError(f"{experiment.name}: condition {index}: legal is 0 to {len(specs) - 1}")
        spec = specs[index]
        try:
            showing = Showing(RobotSource(spec, spec.settings.camera), spec.models, keep=False)
        except ValueError as error:
            raise UsageError(str(error)) from error
        self.settings, self.looped, self.spec, self._places = settings, looped, spec, places
        self.trial: RobotSource = showing.source
        self._showing, self._samples = showing, iter(showing)
        self.interval_s = self.trial.sim.frame_interval
        self._changes: list[Change] = []
        self._target.clear()
        self._wheels.clear()
        self._watch(models, showing.runners)

    def _present(self) -> dict[Robot, Place]:
        return {robot: Place.of(self.trial.sim.robots[robot].pose) for robot in ROBOTS}

    def choose_models(self, models: Sequence[str]) -> None:
        """Show other models, from a new trial on."""
        self._begin(models, self._kept(self.settings, models), None, self.looped)

    def set(self, key: str, text: str) -> None:
        """Change a parameter of the apparatus, from a new trial on."""
        self._begin(self.models, {**self.settings, key: text}, None, self.looped)

    def reset_world(self) -> None:
        """Give scene and camera the parameters that they began with, from a new trial on."""
        others = {key: text for key, text in self.settings.items() if not key.startswith(WORLD)}
        began = {key: text for key, text in self._began.items() if key.startswith(WORLD)}
        self._begin(self.models, others | began, None, self.looped)

    def show(self, name: str, index: int = 0) -> None:
        """Loop a condition of an experiment; an empty name drives by hand again.

        Parameters
        ----------
        name
            As ``experiments`` has it.
        index
            Which condition.
        """
        self._begin(self.models, self.settings, START, (name, index) if name else None)
        self._behaviour = None

    def _change(self, model: str, values: Mapping[str, str]) -> None:
        super()._change(model, values)
        self._changes += [Change(self.number, model, name, text) for name, text in values.items()]

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
        if self.looped:
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
        if name not in self.behaviours:
            raise UsageError(f"behaviour {short(name)}: legal is one of {', '.join(self.behaviours)}")
        entry = load_behaviour(name)
        if entry.senses != "neural":
            raise UsageError(f"{name} senses the state of its env, which is not here: legal are those with a camera")
        camera = self.spec.settings.camera
        runner = ModelRunner(choose(entry.model), (camera.height, camera.width), keep=False)
        self._behaviour = name, runner, entry.make(stream("policy", self.seed))
        self._target.pop("observer", None)

    def step(self) -> View:
        """Advance by a frame.

        Raises
        ------
        TrialError
            The trial of an experiment went wrong, or the behaviour.
        """
        if self.trial.drive.over:
            self.begin(None)
        trial = self.trial
        if isinstance(trial.drive, HandDrive):
            self._command(trial.drive)
        before = [runner.seconds for runner in self.watching]
        sample = next(self._samples)
        if self._behaviour is not None:
            self._act(sample.image)
        poses = {name: robot.pose for name, robot in trial.sim.robots.items()}
        return self._view(sample.time_s, sample.image, self._showing.responses, before, poses)

    def _act(self, image: npt.NDArray[np.uint8]) -> None:
        """Let the behaviour answer a frame."""
        assert self._behaviour is not None
        name, runner, policy = self._behaviour
        answer = runner.see(image)
        if answer is None:
            self.behave("")
            raise TrialError(f"the behaviour {name} broke: {runner.trouble}")
        shares = wheels(policy, PartialResponse(answer, runner.chosen.channels, runner.label)).tolist()
        robot = self.trial.sim.robots["observer"]
        speed, turn = robot.motion_of(WheelSpeeds(*(share * robot.config.max_speed_cm_s / 100 for share in shares)))
        fastest = math.radians(FASTEST_DEG_S)
        self._wheels["observer"] = (
            min(max(100 * speed, -FASTEST_CM_S), FASTEST_CM_S), math.degrees(min(max(turn, -fastest), fastest)),
        )  # fmt: skip

    def _command(self, drive: HandDrive) -> None:
        poses = {name: robot.pose for name, robot in self.trial.sim.robots.items()}
        for robot in ROBOTS:
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
            name = self.looped[0] if self.looped else ""
            raise UsageError(f"this is a trial of {name}: colias run {name} records it")
        if not self.trial.number:
            raise UsageError("nothing has happened yet")
        places = self._places
        return Hand(
            self.trial.number, places["stimulus"], places["observer"],
            tuple(c for c in drive.commands if c.frame < self.trial.number),
            tuple(c for c in self._changes if c.frame < self.trial.number),
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
