"""The session behind the page: models that watch a trial of the simulation, and what a person may do with it."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

from colias_sim import Pose
from dsnn import Response
from experiments.base.errors import UsageError, as_usage_error
from experiments.declare.conditions import LONGEST_FRAMES, Hand, Place, RobotName, place_of
from experiments.declare.experiment import visit
from experiments.kinds.api import run
from experiments.kinds.result import Run
from experiments.kinds.trials import checked
from experiments.show.play import ModelRunner, Sample, Showing
from experiments.show.robot import HandDrive, RobotSource, trials_of
from experiments.store.asked import Asked

START: Mapping[RobotName, Place] = {"stimulus": (12.0, 11.0, -90.0), "observer": (0.0, 0.0, 0.0)}
"""Places at the start: the stimulus is out of view and points across it."""
ROBOTS = tuple(START)
ROOM_CM = 3.0
"""Distance that robots keep from the wall, and that their middles keep beyond touching."""


class Session:
    """Models that watch a trial without an end.

    A new parameter begins a new trial, with the robots where they are and driven as they were. Commands to robots hold
    from the next frame on. A change that is refused raises `UsageError`, and the trial goes on.

    Attributes
    ----------
    settings
        Parameter -> text, as after ``--set``.
    showing
        The frames, and the models that watch them.
    number
        Frames since the beginning of the trial.
    cost_s
        Model's label -> time that it took for the last frame that it saw.
    interval_s
        Time between two frames.
    speed_cm_s
        Speed at which robots are driven; a new one is for robots under way too.

    Parameters
    ----------
    models, settings, seed
        Models, ``SECTION.NAME`` -> text, and the seed of every trial.
    """

    def __init__(self, models: Sequence[str], settings: Mapping[str, str] | None = None, seed: int = 0) -> None:
        self.models, self.seed, self.speed_cm_s = tuple(models), seed, 8.0
        self.settings = self._given = dict(settings or {})
        self.cost_s: dict[str, float] = {}
        self._moves: dict[RobotName, tuple[float, float]] = {}
        self._begin(self.settings, START)

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
        return self.trial.sim.poses

    def step(self) -> Sample:
        """Advance by a frame, and return it.

        Raises
        ------
        TrialError
            The trial failed.
        """
        if self._drive.over:
            self.begin(None)
        self._command()
        before = [runner.seconds for runner in self.runners]
        sample = next(self._samples)
        self.number += 1
        costs = zip(self.runners, before, strict=True)
        self.cost_s |= {runner.label: cost for runner, earlier in costs if (cost := runner.seconds - earlier)}
        return sample

    def begin(self, places: Mapping[RobotName, Place] | None = START) -> None:
        """Begin a trial, with the robots at these places; ``None``: where they are."""
        self._begin(self.settings, places)

    def _begin(self, settings: dict[str, str], asked_places: Mapping[RobotName, Place] | None) -> None:
        places = asked_places or {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        hand = visit(Hand(LONGEST_FRAMES, places["stimulus"], places["observer"]))
        asked = Asked(kind="trials", values=settings, repeats=1, seed=self.seed)
        (spec,) = trials_of(*checked(hand, self.models, asked), self.seed)
        with as_usage_error():
            showing = Showing(RobotSource(spec, spec.settings.camera), spec.models, keep=False, seed=spec.seed)
        self.settings, self.spec, self._places = settings, spec, places
        self.trial: RobotSource = showing.source
        self._drive = cast(HandDrive, self.trial.drive)
        self.interval_s = self.trial.sim.frame_interval
        if asked_places:
            self._moves.clear()
        self.showing, self._samples, self.number = showing, iter(showing), 0

    def set(self, key: str, text: str) -> None:
        """Change a parameter, from a new trial on."""
        self._begin({**self.settings, key: text}, None)

    def reset_parameters(self) -> None:
        """Give models and apparatus their first parameters, from a new trial on."""
        self._begin(self._given, None)

    def drive(self, robot: RobotName, ahead: float, turn: float = 0.0) -> None:
        """Drive a robot from now on, at a share of the speed (-1 to 1), turning by degrees/s, left positive."""
        self._moves[robot] = (ahead, turn)

    def _command(self) -> None:
        poses = self.poses
        for robot in ROBOTS:
            ahead, turn = self._moves.get(robot, (0.0, 0.0))
            away_cm = self.spec.settings.scene.wall_cm
            if any(_blocked(poses[robot], poses[other], ahead, away_cm) for other in ROBOTS if other != robot):
                ahead = 0.0
            self._drive.command(robot, float(ahead * self.speed_cm_s), float(turn))

    def hand(self) -> Hand:
        """Return the commands since the trial began, as data."""
        if self.trial.number <= max(runner.phase for runner in self.runners):  # no model has seen anything
            raise UsageError("nothing has happened yet")
        places = self._places
        commands = tuple(command for command in self._drive.commands if command[0] < self.trial.number)
        return Hand(self.trial.number, places["stimulus"], places["observer"], commands)

    def record(self, out: Path | None = None) -> Run:
        """Run the trial since it began once more, from its commands, into ``out`` or a new folder ``runs/live-TIME``.

        The run has every frame of the page, bit for bit. A new trial begins then, with the robots where they are.
        """
        hand = self.hand()
        places = {robot: place_of(self.poses[robot]) for robot in ROBOTS}
        done = run(
            visit(hand), seed=self.seed, models=self.models, only=True, settings=self.settings, out=out,
            workers=0, quiet=True,
        )  # fmt: skip
        self._begin(self.settings, places)
        return done


def _blocked(pose: Pose, other: Pose, ahead: float, away_cm: float) -> bool:
    """Say whether a robot that drives on would come too near the wall, so far away, or the other robot."""
    way = math.copysign(0.01, ahead)
    x, y = pose.x + way * math.cos(pose.heading), pose.y + way * math.sin(pose.heading)
    here, there = math.hypot(pose.x, pose.y), math.hypot(x, y)
    if 100 * there > away_cm - ROOM_CM and there > here:
        return True
    now, then = (math.hypot(px - other.x, py - other.y) for px, py in ((pose.x, pose.y), (x, y)))
    return 100 * then < 4.0 + ROOM_CM / 2 and then < now
