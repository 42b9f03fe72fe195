"""Objects that go on from a state: drawn envs to save, and a walk that finds attributes which no list has."""

import hashlib
import json
import sys
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

from colias_sim.envs.base import ColiasEnv
from dsnn import MODELS
from dsnn.snapshot import Parts, attributes
from tests.helpers.envs import NAMES, fingerprint

STEPS = 300
CAMERAS = ("default", "ov7670", "ov7670-gamma", {"jitter_ms": 1.0, "drop_probability": 0.1}, {"supersample": 2})
ROBOTS = ("default", "colias4", {"command_slot_ms": 100.0, "serial_ms": 5.0})
RANDOMISE = (
    0.0, 1.0, "domain", "colias4", {"wall": (0.5, 1.5), "tilt": (-3.0, 3.0)}, {"latency_ms": (20.0, 90.0)},
)  # fmt: skip


def drawn(seed: int) -> tuple[str, dict[str, Any], int]:
    """Draw a case: an env, its arguments, and the step at which it is saved."""
    rng = np.random.default_rng(seed)

    def one(values: Any) -> Any:
        return values[int(rng.integers(len(values)))]

    name, camera = NAMES[seed % len(NAMES)], one(CAMERAS)
    options = {
        "observation": one(("pixels", "neural", "both", "state")), "camera": camera, "robot": one(ROBOTS),
        "randomise": one(RANDOMISE),
        "model": one([model for model in MODELS if "reference" not in model]), "actions": one(("wheels", "manoeuvres")),
        "processor": {"every": int(rng.integers(1, 3))}, "truth": seed % 2 == 1,
    }  # fmt: skip
    options |= {
        "Optomotor": {"disturbance": one(("drum", "push"))},
        "Fixation": {"robots": int(rng.integers(1, 4))},
    }.get(name.partition("/")[2].partition("-")[0], {"arena": one(("leaves", "bright", "dim"))})
    return name, options, int(rng.integers(0, STEPS))


def play(env: ColiasEnv[Any], seed: int, begin: int, end: int) -> str:
    """Drive by the actions of a seed, over the ends of episodes; return a digest of all that is told and seen."""
    rng, whole = np.random.default_rng(seed), hashlib.sha256()
    actions = rng.uniform(-0.4, 1.0, (STEPS, 2)).astype(np.float32)
    for wheels in actions[begin:end]:
        told = env.step(int(7 * wheels[0] + 2.8) % 7 if isinstance(env.action_space, gym.spaces.Discrete) else wheels)
        response = () if env.response is None else (env.response.hs, env.response.vs, env.response.looming)
        whole.update(fingerprint([*told, response, env.luma]).encode())
        if told[2]:
            whole.update(fingerprint([*env.reset()]).encode())
    return whole.hexdigest()


def unlisted(value: object, parts: Parts, rest: Mapping[str, str], seen: set[int] | None = None) -> Iterator[str]:
    """Yield ``Class.attribute`` of every object whose class is in ``parts``, also of those in lists and mappings.

    ``rest`` has the attributes that are no state, by class, with its module or without.
    """
    seen = set() if seen is None else seen
    if isinstance(value, list | tuple | deque | dict):
        for one in value.values() if isinstance(value, dict) else value:
            yield from unlisted(one, parts, rest, seen)
    elif (names := attributes(value, parts)) is not None and id(value) not in seen:
        seen.add(id(value))
        for kind in type(value).__mro__:
            names += rest.get(f"{kind.__module__}.{kind.__qualname__}", rest.get(kind.__name__, "")).split()
        for name, one in vars(value).items():
            if name not in names:
                yield f"{type(value).__name__}.{name}"
            yield from unlisted(one, parts, rest, seen)


def main(folder: Path) -> None:
    """Restore the envs whose cases and states are in a folder, and print what follows."""
    told = {}
    for file in sorted(folder.glob("*.state")):
        name, options, cut = drawn(int(file.stem))
        env: Any = gym.make(name, **options).unwrapped
        env.set_state(file.read_bytes())
        told[file.stem] = play(env, int(file.stem), cut, STEPS)
        env.close()
    print(json.dumps(told))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
