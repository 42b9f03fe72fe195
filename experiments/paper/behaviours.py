"""Fly-like reflexes, hand-written, each a few lines over the network's responses; and their baselines.

A behaviour is asked for wheel speeds once a frame: shares of the motors' maximum, left and right. A reflex is given a
`dsnn.Response`, a privileged baseline a `colias_sim.envs.State`, a blind one nothing it could use. A new behaviour is
a function or class here, and an entry in `_ENTRIES`.
"""

import math
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from colias_sim.config import RobotConfig
from colias_sim.envs import State
from colias_sim.envs.options import FPS
from dsnn import MODELS, Response
from experiments.declare.behaviour import AVOIDANCE, FIXATION, OPTOMOTOR, PURSUIT, WHEELS, Behaviour, Wheels, steer

AHEAD = 0.3
"""Cruising speed of the wheels: 10.5 cm/s."""
FULL_TURN = RobotConfig().full_turn
"""That of the default robot, in rad/s."""


def turn(right: float, ahead: float = 0.0) -> Wheels:
    """Turn to the right, as HS is positive rightward, while driving ahead; shares of the maximum."""
    return ahead + right, ahead - right


# The reflexes.


def optomotor(seen: Response) -> Wheels:
    """Turn the way the view moves, so that it moves no more."""
    return turn(0.2 * seen.hs)


def fixation(seen: Response) -> Wheels:
    """Turn towards where something moves."""
    return turn(0.2 * seen.azimuth)


def pursuit(seen: Response) -> Wheels:
    """Turn towards what moves and drive after it; stand back from what looms."""
    return turn(0.1 * seen.azimuth, ahead=0.2 if seen.looming_spikes == 0 else -0.05)


class ProportionalIntegral:
    """Turn by what is seen and by its integral over time, through the steering of a trained policy.

    The steering takes commands from -1 to 1. The integral stays within these, so that it does not wind up.

    Parameters
    ----------
    error
        What is to become 0, positive where it asks for a turn to the right.
    proportional
        Command at an error of 1.
    integral
        Growth of the command in a second at an error of 1, 1/s.
    """

    def __init__(self, error: Callable[[Response], float], proportional: float, integral: float) -> None:
        self._error, self._proportional, self._rate = error, proportional, integral / FPS
        self._integral, self._command = 0.0, np.zeros(WHEELS, np.float32)

    def __call__(self, seen: Response) -> Wheels:
        """Return the wheels for the next frame."""
        error = self._error(seen)
        self._integral = min(max(self._integral + self._rate * error, -1.0), 1.0)
        answer = self._proportional * error + self._integral
        self._command = steer(self._command, np.array(turn(answer), np.float32))
        left, right = self._command.tolist()
        return left, right


OPTOMOTOR_GAINS, FIXATION_GAINS = (1.0, 16.0), (4.0, 0.0)
"""Proportional and integral gains (1, 1/s), by the search in docs/results/behaviours.md, at seeds 2000 to 2003."""


class Saccades:
    """Drive ahead; when something looms, turn away on the spot, to the ``side`` chosen (1: right), for some frames.

    While turning, and for the few frames in which its own turn still echoes in the network, it does not look: flies
    suppress vision in their saccades too. A side once chosen holds for as long as looming goes on, ``HOLD`` frames
    from one saccade to the next, or it would dither before a wall.
    """

    TURN, TURN_FRAMES, ECHO_FRAMES = 0.25, 8, 4
    HOLD = 15

    def __init__(self, side: Callable[[Response], float], *, hold: bool = True) -> None:
        self._choose, self._hold = side, self.HOLD if hold else -1
        self._frame, self._until, self._side = 0, -self.HOLD - 1, 1.0

    def __call__(self, seen: Response) -> Wheels:
        """Return the wheels for the next frame."""
        self._frame += 1
        if self._frame >= self._until and seen.looming_spikes:
            if self._frame > self._until + self._hold:
                self._side = self._choose(seen)
            self._until = self._frame + self.TURN_FRAMES + self.ECHO_FRAMES
        if self._frame < self._until - self.ECHO_FRAMES:
            return turn(self._side * self.TURN)
        return turn(0.0, AHEAD)


def by_chance(rng: np.random.Generator) -> Callable[[Response], float]:
    """Return a choice of either side by chance, of a looming detector that knows no direction."""
    return lambda seen: 1.0 if rng.random() < 0.5 else -1.0


def lgmd(rng: np.random.Generator) -> Saccades:
    """Make the looming detector alone: each turn is to a side drawn again."""
    return Saccades(by_chance(rng), hold=False)


def escape(model: str, name: str = "") -> Behaviour:
    """Make the escape reflex of a looming model, which knows no direction: that of ``lgmd``, whatever the model.

    Parameters
    ----------
    model
        A name, or the path of a .py file that declares ``MODEL``; it responds on the channel ``looming``.
    name
        Name of the behaviour; otherwise ``escape-`` and the model's name.

    Returns
    -------
    Behaviour
        The reflex, in the env ``colias_sim/Avoidance-v0``.

    Raises
    ------
    ValueError
        The name is invalid.
    """
    called = name or f"escape-{Path(model).stem}"
    return Behaviour(called, f"{model} alone: a looming spike turns it to a random side", AVOIDANCE, lgmd, model=model)


# What they are held against.


def random(rng: np.random.Generator) -> Callable[[object], Wheels]:
    """Every frame other wheel speeds, uniform over what the motors can."""

    def draw(seen: object) -> Wheels:
        left, right = rng.uniform(-1.0, 1.0, 2).tolist()
        return left, right

    return draw


class RandomWalk:
    """A correlated random walk: ahead, at turn rates that wander about 0 (sd 60 degrees/s, over half a second)."""

    SD, MEMORY_FRAMES = math.radians(60.0), 15.0

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng, self._turn = rng, 0.0

    def __call__(self, state: State) -> Wheels:
        """Return the wheels for the next frame."""
        fade, sd = math.exp(-1.0 / self.MEMORY_FRAMES), self.SD / state.full_turn
        self._turn = fade * self._turn + math.sqrt(1.0 - fade * fade) * sd * float(self._rng.standard_normal())
        return turn(self._turn, AHEAD)


class Oracle:
    """Privileged: turn by the true error in the state, and by its integral.

    Without the integral it would know the truth and not its own wheels: the dead band of ``colias4`` swallows it.
    """

    def __init__(self, right: Callable[[State], float], error: Callable[[State], float], integral: float) -> None:
        self._right, self._error, self._rate = right, error, integral / FPS
        self._integral = 0.0

    def __call__(self, state: State) -> Wheels:
        """Return the wheels for the next frame."""
        self._integral = min(max(self._integral + self._rate * self._error(state), -1.0), 1.0)
        return turn(self._right(state) + self._integral)


def bearing(state: State) -> float:
    """Return the target's true bearing."""
    return state.others[0].bearing


def oracle_distance(state: State) -> Wheels:
    """Privileged: turns to the target's true bearing and keeps 10 cm."""
    target = state.others[0]
    return turn(0.3 * target.bearing, ahead=min(max(4.0 * (target.distance - 0.10) + 0.15, -0.3), 0.6))


def oracle_ways(state: State) -> Wheels:
    """Privileged: turns away from what is near ahead, by its true place."""
    things = [(other.distance, other.bearing) for other in state.others] + [(state.wall_distance, state.wall_bearing)]
    near = [(gap, bearing) for gap, bearing in things if gap < 0.05 and abs(bearing) < math.radians(120 - 1100 * gap)]
    if not near:
        return turn(0.0, AHEAD)
    return turn(0.2 if min(near)[1] < 0 else -0.2)


ESCAPES = tuple(escape(name) for name, entry in MODELS.items() if entry.channels == ("looming",))
"""An escape reflex for each looming model; that of the hybrid is the LGMD1's."""

_ENTRIES = (
    Behaviour.reflex("optomotor", "turns the way the view moves, by HS", OPTOMOTOR, optomotor),
    Behaviour("optomotor-pi", "the same by a PI rule, through the steering of a policy", OPTOMOTOR,
              lambda rng: ProportionalIntegral(lambda seen: seen.hs, *OPTOMOTOR_GAINS)),
    Behaviour.reflex("fixation", "turns towards where something moves", FIXATION, fixation),
    Behaviour("fixation-pi", "the same by a PI rule, through the steering of a policy", FIXATION,
              lambda rng: ProportionalIntegral(lambda seen: seen.azimuth, *FIXATION_GAINS)),
    Behaviour.reflex("pursuit", "turns towards what moves, drives after it, stands back from looming", PURSUIT,
                     pursuit),
    Behaviour("lgmd", "LGMD1 alone, as published: a looming spike turns it to a random side", AVOIDANCE, lgmd,
              model="lgmd1"),
    Behaviour("lgmd-hybrid", "the hybrid without direction: a side by chance, for as long as it looms", AVOIDANCE,
              lambda rng: Saccades(by_chance(rng))),
    Behaviour("avoidance", "a looming spike turns it away from the motion that HS reports", AVOIDANCE,
              lambda rng: Saccades(lambda seen: -1.0 if seen.hs > 0.0 else 1.0, hold=False)),
    # Where the DSNN's ON and OFF cells see motion tells the side of what looms more often than the sign of HS does:
    # ahead of a robot that drives, things on either side drift outward and HS has only the difference.
    Behaviour("hybrid", "looming gates where the motion is: away from there, for as long as it looms", AVOIDANCE,
              lambda rng: Saccades(lambda seen: -1.0 if seen.azimuth > 0.0 else 1.0)),
    *ESCAPES,
    Behaviour("still", "does nothing", OPTOMOTOR, lambda rng: lambda state: (0.0, 0.0), senses="state"),
    Behaviour("random", "draws new wheel speeds every frame, from the whole range", OPTOMOTOR, random, senses="state"),
    Behaviour("straight", "drives ahead", AVOIDANCE, lambda rng: lambda state: (AHEAD, AHEAD), senses="state"),
    Behaviour("random-walk", "a correlated random walk", AVOIDANCE, RandomWalk, senses="state"),
    Behaviour("oracle-heading", "privileged: cancels the true disturbance", OPTOMOTOR,
              # The integral of a slower robot is no stronger than that of the default one, as its commands may wait.
              lambda rng: Oracle(lambda state: state.drift / state.full_turn,
                                 lambda state: state.slip / max(state.full_turn, FULL_TURN), 6.0),
              senses="state"),
    Behaviour("oracle-target", "privileged: turns to the true bearing", FIXATION,
              lambda rng: Oracle(bearing, bearing, 1.5), senses="state"),
    Behaviour("oracle-distance", "privileged: keeps the true distance and bearing", PURSUIT,
              lambda rng: oracle_distance, senses="state"),
    Behaviour("oracle-ways", "privileged: turns away from what is truly near", AVOIDANCE, lambda rng: oracle_ways,
              senses="state"),
)  # fmt: skip

BEHAVIOURS: Mapping[str, Behaviour] = {entry.name: entry for entry in _ENTRIES}
"""The behaviours that ship: name -> `experiments.Behaviour`."""

GROUPS: Mapping[str, tuple[str, ...]] = {"escape": tuple(behaviour.name for behaviour in ESCAPES)}
"""Name -> the behaviours that ``colias behave NAME`` plays in the same worlds."""
REFERENCE: Mapping[str, tuple[str, ...]] = {"escape": ("hybrid", "straight")}
"""Group -> what it is held against: that which is to collide less often, and that which does not look."""
