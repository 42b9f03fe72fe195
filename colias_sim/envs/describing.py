"""The parts of the envs' docstrings that are the same in all, or that their options already say."""

from __future__ import annotations

import inspect
from typing import Any, TypeVar, get_args

from pydantic.fields import FieldInfo

from colias_sim.envs.actions import MANOEUVRES
from colias_sim.envs.options import bounds, options_of
from scenes import ARENAS

Env = TypeVar("Env", bound=type[Any])

ACTIONS = """`Box(-1, 1, (2,), float32)`: the speeds of the wheels, as shares of their maximum (35 cm/s at the rim).
The motors are led there at 2 m/s^2 at most (0.18 s from rest to full speed), as jerked they throw so light a robot
over. An action that is not in the space raises `InvalidAction`.

| Num | Action | Min | Max | Unit |
|---|---|---|---|---|
| 0 | left wheel | -1 | 1 | of 35 cm/s, forward positive |
| 1 | right wheel | -1 | 1 | of 35 cm/s, forward positive |

With `actions="manoeuvres"` it is `Discrete({count})`:

| Num | Manoeuvre | Left wheel | Right wheel |
|---|---|---|---|
{manoeuvres}"""

OBSERVATIONS = """By the argument `observation`:

- `"pixels"`: `Box(0, 255, (72, 99, 1), uint8)`, the luma of the camera, 70 degrees wide, with its noise.
- `"neural"`: `Box((7,), float32)`, what the vision model (argument `model`) answers to every camera frame:

| Num | Observation | Min | Max | Unit |
|---|---|---|---|---|
| 0 | HS: horizontal motion, rightward positive | -1 | 1 | membrane potential |
| 1 | VS: vertical motion, downward positive | -1 | 1 | membrane potential |
| 2 | spikes of HS, signed, summed over the step's frames, cut at the ends | -10 | 10 | spikes |
| 3 | spikes of VS, likewise | -10 | 10 | spikes |
| 4 | looming: 0.5 at rest (0 in a model without it) | 0 | 1 | membrane potential |
| 5 | spikes of the looming detector, summed | 0 | 10 | spikes |
| 6 | azimuth: where the motion is (0 in a model without it) | -1 | 1 | half views, rightward positive |

- `"both"`: a `Dict` of `pixels` and `neural`.
- `"state"`: `Box(-1, 1, (7 + 5 robots,), float32)`, what a robot cannot know, for privileged baselines; nothing is
  rendered. `colias_sim.envs.State.read` turns it back into units:

| Num | Observation | Scale |
|---|---|---|
| 0 | speed ahead | 0.35 m/s |
| 1, 2, 3 | turn rate, turn rate against the wall, rate of the disturbance, left positive | 5 rad/s |
| 4 | distance from the hull to the nearest wall | 0.9 m |
| 5, 6 | its direction: sine, cosine, left positive | |
| 7 + 5 i | distance between hulls of the other robot i: the target first, then by distance | 0.9 m |
| 8, 9 + 5 i | its direction: sine, cosine | |
| 10, 11 + 5 i | its velocity against the observer's: ahead, to the left | 0.35 m/s |

A reset's observation is of one frame, in which the robot stands."""

REWARDS = """- `touch`: -10 when the hull touches anything.

Terms are means over the frames of a step, but for `touch`; the reward is their sum."""

RANDOM = """What differs between episodes comes from the env's seed alone: places, the others' paths, camera noise,
light (3 %), the wall's turn. `randomise` widens that to lamps by 30 %, shells from black to a reflectance of 0.42,
each wheel by 5 %, the camera by 3 degrees up and aside, all times its value."""

INFO = """`info` has the reward's terms as `reward_...`, `x_cm`, `y_cm`, `heading_deg`, `driven_cm` (in this step),
`turn_deg_s`, `slip_deg_s` (the turn against the wall), `drift_deg_s` (what the disturbance alone would do) and
`touched`."""


def documented(env: Env) -> Env:
    """Fill in the shared parts of an env's docstring, the table of its arguments among them."""
    assert env.__doc__ is not None
    rows = (f"| {i} | {name} | {left} | {right} |" for i, (name, (left, right)) in enumerate(MANOEUVRES.items()))
    shared = {
        "ACTIONS": ACTIONS.format(count=len(MANOEUVRES), manoeuvres="\n".join(rows)),
        "OBSERVATIONS": OBSERVATIONS, "REWARDS": REWARDS, "RANDOM": RANDOM, "INFO": INFO,
        "ARGUMENTS": arguments(env.options_type),
    }  # fmt: skip
    text = inspect.cleandoc(env.__doc__)
    for name, part in shared.items():
        text = text.replace(f"<{name}>", part)
    env.__doc__ = text
    return env


def arguments(options: type[Any]) -> str:
    """A table of the keyword arguments: default, range, meaning."""
    rows = ["| Argument | Default | Legal | Meaning |", "|---|---|---|---|"]
    for name, option in options_of(options).items():
        default = f'"{option.default}"' if isinstance(option.default, str) else repr(option.default)
        rows.append(f"| `{name}` | `{default}` | {_legal(name, option)} | {option.description} |")
    return "\n".join(rows)


def _legal(name: str, option: FieldInfo) -> str:
    if name == "arena":
        return ", ".join(f'"{arena}"' for arena in ARENAS)
    if name == "model":
        return (
            "a name of `colias list`, a .py file, an entry, or a factory taking one argument, the tuple (rows, columns)"
        )
    if option.annotation is bool:
        return "True, False"
    return bounds(option) or ", ".join(_choices(option.annotation))


def _choices(annotation: Any) -> list[str]:
    """What a ``Literal``, or a union with one, allows."""
    if annotation in (None, type(None)):
        return ["None"]
    if isinstance(annotation, str):
        return [f'"{annotation}"']
    return [choice for part in get_args(annotation) for choice in _choices(part)]
