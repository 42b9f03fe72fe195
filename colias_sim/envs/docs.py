"""The parts of the envs' pages (their docstrings) that all envs share or that follow from their options."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar, get_args

from pydantic.fields import FieldInfo

from colias_sim.config import CameraConfig, RobotConfig
from colias_sim.envs.actions import MANOEUVRES
from colias_sim.envs.factors import FACTORS, PRESETS
from colias_sim.envs.options import bounds, options_of
from dsnn.field_docs import meaning
from scenes import ARENAS

Env = TypeVar("Env", bound=type[Any])
_CONFIGS: Mapping[str, type[CameraConfig | RobotConfig]] = MappingProxyType(
    {"camera": CameraConfig, "robot": RobotConfig}
)

ACTIONS = """`Box(-1, 1, (2,), float32)`: the speeds of the wheels, as shares of the robot's maximum (35 cm/s at the
rim, or 15.3 cm/s with `robot="colias4"`). Commands change by at most 2 m/s^2 (0.18 s from rest to 35 cm/s), as faster
changes would throw the robot over. An action that is not in the space raises `InvalidAction`.

| Num | Action | Min | Max | Unit |
|---|---|---|---|---|
| 0 | left wheel | -1 | 1 | of the maximum, forward positive |
| 1 | right wheel | -1 | 1 | of the maximum, forward positive |

With `actions="manoeuvres"` it is `Discrete({count})`:

| Num | Manoeuvre | Left wheel | Right wheel |
|---|---|---|---|
{manoeuvres}"""

OBSERVATIONS = """By the argument `observation`:

- `"pixels"`: `Box(0, 255, (72, 99, 1), uint8)`, the luma of the camera, 70 degrees wide, with its noise.
- `"neural"`: `Box((7,), float32)`, the response of the vision model (argument `model`) to the camera's frames:

| Num | Observation | Min | Max | Unit |
|---|---|---|---|---|
| 0 | HS: horizontal motion, rightward positive | -1 | 1 | membrane potential |
| 1 | VS: vertical motion, downward positive | -1 | 1 | membrane potential |
| 2 | spikes of HS, signed, summed over the step's frames, clipped | -10 | 10 | spikes |
| 3 | spikes of VS, likewise | -10 | 10 | spikes |
| 4 | looming: 0.5 at rest (0 in a model without it) | 0 | 1 | membrane potential |
| 5 | spikes of the looming detector, summed | 0 | 10 | spikes |
| 6 | azimuth: horizontal position of the motion (0 in a model without it) | -1 | 1 | half views, rightward positive |

- `"both"`: a `Dict` of `pixels` and `neural`.
- `"state"`: `Box(-1, 1, (7 + 5 robots,), float32)`, the state of the world, which a real robot cannot
  know, for privileged baselines. Nothing is rendered. `colias_sim.envs.State.read` decodes it into SI units, and
  the directions into bearings, right positive:

| Num | Observation | Scale |
|---|---|---|
| 0 | speed ahead | 0.35 m/s |
| 1, 2, 3 | turn rate, turn rate relative to the wall, rate of the disturbance, left positive | 5 rad/s |
| 4 | distance from the hull to the nearest wall | 0.9 m |
| 5, 6 | its direction: sine, cosine, left positive | |
| 7 + 5 i | distance between hulls of the other robot i: the target first, then by distance | 0.9 m |
| 8, 9 + 5 i | its direction: sine, cosine, left positive | |
| 10, 11 + 5 i | its velocity relative to the observer's: ahead, to the left | 0.35 m/s |

The observation of a reset is of one frame, in which the robot stands."""

REWARDS = """- `touch`: -10 when the hull touches anything.

The reward is the sum of these terms. Each is the mean over the frames of a step, but for `touch`."""

RANDOM = """The env's seed alone decides what differs between episodes: places, the paths of the other robots, camera
noise, light (standard deviation 3 %) and the phase of the wall's texture.

`randomise` adds to this. A number adds, in proportion to its value: light by up to 30 %, shells from black to a
reflectance of 0.42, the speed of each wheel by up to 5 %, and the camera's direction by up to 3 degrees in pitch and
yaw. A mapping such as `{{"light": (0.7, 1.3), "mass_g": (26, 30)}}` draws each of its factors uniformly between two
ends, anew in each episode. Each factor has random numbers of its own, so that none changes what is drawn of the others
or of the world:

| Factor | Unit | Legal | What varies |
|---|---|---|---|
{factors}

The name of a preset is short for a mapping, and `{{"preset": NAME, ...}}` adds to it:

| Preset | Ranges |
|---|---|
{presets}

A range that needs more than the camera has is refused: `ae_target` needs a camera with `auto_exposure`.

`reset(options={{"light": 0.5, "tilt": (3, -2)}})` gives the same factors one value each, for that episode alone; a
factor with two draws takes two values. It stands in the place of what `randomise` would draw, and changes no other
draw. `options={{"poses": {{"observer": (x_cm, y_cm, heading_deg)}}}}` gives start poses, up to 42 cm from the arena's
middle and 5 cm apart. Another robot that the seed puts within 5 cm of a given pose is drawn anew. Scripted robots go
on to their usual paths from where they are put. `row_time_us` above 0 needs a camera that was made with a rolling
shutter."""

INFO = """`info` has the reward's terms as `reward_...`, the observer's pose as `x_cm`, `y_cm` and `heading_deg`,
`driven_cm` (the distance driven in this step), `turn_deg_s` (the turn rate), `slip_deg_s` (the turn rate relative to
the wall), `drift_deg_s` (the rate at which the disturbance alone would turn the view) and `touched`. With `randomise`
or the options of a reset the info of a reset has `randomised`, a dict of the values drawn or given."""


def documented(env: Env) -> Env:
    """Fill in the shared parts of an env's page, the table of its arguments among them.

    Parameters
    ----------
    env
        The env's class. Its docstring has placeholders such as ``<ACTIONS>``.

    Returns
    -------
    type
        The same class.
    """
    assert env.__doc__ is not None
    rows = (f"| {i} | {name} | {left} | {right} |" for i, (name, (left, right)) in enumerate(MANOEUVRES.items()))
    shared = {
        "ACTIONS": ACTIONS.format(count=len(MANOEUVRES), manoeuvres="\n".join(rows)),
        "OBSERVATIONS": OBSERVATIONS, "REWARDS": REWARDS, "INFO": INFO,
        "RANDOM": RANDOM.format(factors=_factors(), presets=_presets()),
        "ARGUMENTS": arguments(env.options_type),
    }  # fmt: skip
    text = inspect.cleandoc(env.__doc__)
    for name, part in shared.items():
        text = text.replace(f"<{name}>", part)
    env.__doc__ = text
    return env


def arguments(options: type[Any]) -> str:
    """Tabulate the fields of an options class in Markdown: name, default, legal values and meaning."""
    rows = ["| Argument | Default | Legal | Meaning |", "|---|---|---|---|"]
    for name, option in options_of(options).items():
        default = f'"{option.default}"' if isinstance(option.default, str) else repr(option.default)
        rows.append(f"| `{name}` | `{default}` | {_legal(name, option)} | {meaning(options, name)} |")
    return "\n".join(rows)


def _factors() -> str:
    rows = (
        f"| `{factor.name}` | {factor.unit} | {factor.low:g} .. {factor.high:g} | {factor.changes} |"
        for factor in FACTORS.values()
    )
    return "\n".join(rows)


def _presets() -> str:
    return "\n".join(
        f"| `{name}` | {', '.join(f'{factor} {low:g} .. {high:g}' for factor, (low, high) in ranges.items())} |"
        for name, ranges in PRESETS.items()
    )


def _legal(name: str, option: FieldInfo) -> str:
    if name == "randomise":
        return f"0 .. 1, {_quoted(PRESETS)}, a mapping from factors to ranges"
    if name in _CONFIGS:
        kind = _CONFIGS[name]
        return f"{_quoted(kind.presets())}, a mapping of settings and `preset`, a `{kind.__name__}`"
    if name == "arena":
        return f"{_quoted(ARENAS)}, the path of an .xml or .py file"
    if name == "model":
        return (
            "a name of `colias list`, a .py file, an entry, or a factory taking one argument, the tuple (rows, columns)"
        )
    if option.annotation is bool:
        return "True, False"
    return bounds(option) or ", ".join(_choices(option.annotation))


def _quoted(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def _choices(annotation: Any) -> list[str]:
    """Return the values that a ``Literal``, or a union with one, allows."""
    if annotation in (None, type(None)):
        return ["None"]
    if isinstance(annotation, str):
        return [f'"{annotation}"']
    return [choice for part in get_args(annotation) for choice in _choices(part)]
