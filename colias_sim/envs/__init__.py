"""Gymnasium envs in which a simulated Colias drives itself: ``gymnasium.make("colias_sim/Fixation-v0")``.

## Action Space

`Box(-1, 1, (2,), float32)`: the speeds of the wheels, as shares of the robot's maximum (35 cm/s at the rim, or 15.3
cm/s with `robot="colias4"`). Commands change by at most 2 m/s^2 (0.18 s from rest to 35 cm/s), because faster changes
would tip the robot over. Speeds are clipped to the space. Another shape, and NaN, raise
`gymnasium.error.InvalidAction`.

| Num | Action | Min | Max | Unit |
|---|---|---|---|---|
| 0 | left wheel | -1 | 1 | of the maximum, forward positive |
| 1 | right wheel | -1 | 1 | of the maximum, forward positive |

With `actions="manoeuvres"` it is `Discrete(7)`:

| Num | Manoeuvre | Left wheel | Right wheel |
|---|---|---|---|
| 0 | stop | 0.0 | 0.0 |
| 1 | ahead | 0.3 | 0.3 |
| 2 | bend left | 0.2 | 0.3 |
| 3 | bend right | 0.3 | 0.2 |
| 4 | turn left | -0.2 | 0.2 |
| 5 | turn right | 0.2 | -0.2 |
| 6 | back | -0.2 | -0.2 |

## Observation Space

By the argument `observation`:

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
- `"events"`: `Box(0, 255, (2, 72, 99), uint8)`, the ON events of each pixel since the last step, then the OFF
  events, of an event camera in the camera's place (argument `events`). `env.unwrapped.events` has each event.
- `"state"`: `Box(-1, 1, (7 + 5 robots,), float32)`, the state of the world for privileged baselines, which a real robot
  cannot know. Nothing is rendered. `colias_sim.envs.State.read` decodes it into SI units, and the directions into
  bearings, right positive:

| Num | Observation | Scale |
|---|---|---|
| 0 | speed ahead | 0.35 m/s |
| 1, 2, 3 | turn rate, turn rate relative to the wall, rate of the disturbance, left positive | 5 rad/s |
| 4 | distance from the hull to the nearest wall | 0.9 m |
| 5, 6 | its direction: sine, cosine, left positive | |
| 7 + 5 i | distance between hulls of the other robot i: the target first, then by distance | 0.9 m |
| 8, 9 + 5 i | its direction: sine, cosine, left positive | |
| 10, 11 + 5 i | its velocity relative to the observer's: ahead, to the left | 0.35 m/s |

The observation of a reset is a single frame, in which the robot stands.

## Rewards

The reward is the sum of the env's terms and of `touch`, which is -10 when the hull touches anything. Each term except
`touch` is the mean over the frames of a step.

## Info

`info` has the reward's terms as `reward_...`, the observer's pose as `x_cm`, `y_cm` and `heading_deg`, `driven_cm` (the
distance driven in this step), `turn_deg_s` (the turn rate), `slip_deg_s` (the turn rate relative to the wall),
`drift_deg_s` (the slip that the disturbance alone would cause) and `touched`. The three rates are left positive, so a
drum that turns to the right causes a positive drift. With `randomise` or options of a reset, the info of a reset has
`randomised`, a dict of the values drawn or given.

With `truth=True` it has what truly moved in the last frame too, as `true_flow_x`, `true_flow_y`, `true_share`,
`true_width_deg`, `true_image_speed_deg_s`, `true_time_to_contact_s`, `true_heading_deg` and `true_interval_ms`. They
are of the robots that drive, or of the wall where none does, and NaN where there is no number. A policy can be
supervised by them, which it cannot see. `env.unwrapped.truth()` returns flow, depth and surface of each pixel.

## Randomisation

Only the env's seed determines the differences between episodes: places, the paths of the other robots, camera noise,
light (standard deviation 3 %) and the phase of the wall's texture.

`randomise` adds variation. A number adds, in proportion to its value: light by up to 30 %, shells from black to a
reflectance of 0.42, the speed of each wheel by up to 5 %, and the camera's direction by up to 3 degrees in pitch and
yaw. (Bearings, and what is in view, are those of the camera without tilt.) A mapping such as `{"light": (0.7, 1.3),
"mass_g": (26, 30)}` draws each factor uniformly between two ends in each episode. Each factor has its own random
numbers, so that it does not change the draws of the others or of the world. The name of a preset is short for a
mapping, and `{"preset": NAME, ...}` adds to it. A range that the camera cannot provide is refused: `ae_target` needs a
camera with `auto_exposure`.

`reset(options={"light": 0.5, "tilt": (3, -2)})` sets these factors for one episode; a factor with two draws takes two
values. A value given replaces the one that `randomise` would draw; all other draws stay the same.
`options={"poses": {"observer": (x_cm, y_cm, heading_deg)}}` gives start poses, up to 42 cm from the arena's middle and
5 cm apart. Another robot that the seed puts within 5 cm of a given pose is drawn again. Scripted robots drive to their
usual paths from the given pose. `row_time_us` above 0 needs a camera that was made with a rolling shutter.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import gymnasium as gym

from colias_sim.envs.avoidance import Avoidance
from colias_sim.envs.base import ColiasEnv
from colias_sim.envs.fixation import Fixation
from colias_sim.envs.measures import COLLISIONS, RETURN
from colias_sim.envs.options import checked
from colias_sim.envs.optomotor import Optomotor
from colias_sim.envs.pursuit import Pursuit
from colias_sim.envs.randomise import FACTORS, PRESETS
from colias_sim.envs.senses import NEURAL
from colias_sim.envs.state import Other, State
from colias_sim.envs.swarm import SwarmOptions

if TYPE_CHECKING:
    from colias_sim.envs.parallel import SwarmEnv

__all__ = [
    "COLLISIONS", "ENVS", "FACTORS", "NEURAL", "PRESETS", "RETURN", "Other", "State", "register_envs", "swarm_env",
]  # fmt: skip

ENVS: Mapping[str, type[ColiasEnv[Any]]] = MappingProxyType(
    {f"colias_sim/{env.__name__}-v0": env for env in (Avoidance, Fixation, Optomotor, Pursuit)}
)
"""The registered envs: Gymnasium's id -> class. A new env is a file and a name here."""


def register_envs() -> None:
    """Register `ENVS` with ``gymnasium.make`` and ``gymnasium.make_vec``. A second call does nothing."""
    for name, env in ENVS.items():
        if name not in gym.registry:
            gym.register(
                name,
                entry_point=f"{env.__module__}:{env.__name__}",
                max_episode_steps=env.max_episode_steps,
                # Gymnasium's checker looks at the first reset alone. Where that one raises, say for a wrong option,
                # every later step fails in the checker. The tests run `check_env` on each env instead.
                disable_env_checker=True,
            )


def swarm_env(**arguments: Any) -> SwarmEnv:
    """Make PettingZoo's parallel env of many robots that all see.

    It is `Avoidance` for many: each robot drives about, its reward is its speed along its heading as a share of the
    maximum, and -10 when its hull touches anything. With that its own episode ends.

    Parameters
    ----------
    **arguments
        The fields of `colias_sim.envs.swarm.SwarmOptions`: ``robots``, ``observation``, ``actions``, ``model``,
        ``crash`` and so on, as of the single envs.

    Returns
    -------
    SwarmEnv
        The env, with the agents ``robot0``, ``robot1`` and so on.

    Raises
    ------
    ValueError
        An argument is unknown or out of range, the vision model cannot be built, or the arena is refused.
    ImportError
        PettingZoo is not installed, the extra ``[swarm]``.
    colias_sim.GLUnavailable
        No OpenGL backend works.

    Examples
    --------
    >>> import colias_sim
    >>> env = colias_sim.swarm_env(robots=3, observation="state")
    >>> observations, infos = env.reset(seed=0)
    >>> sorted(observations)
    ['robot0', 'robot1', 'robot2']
    >>> env.close()
    """
    options = checked(SwarmOptions, arguments)
    try:
        from colias_sim.envs.parallel import SwarmEnv
    except ModuleNotFoundError as error:
        raise ImportError("swarm_env needs PettingZoo: pip install 'colias-sim[swarm]'") from error
    return SwarmEnv(options)
