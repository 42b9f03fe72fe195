"""A script: show each model file given an env's frames, and write to answers.json what came of it."""

from __future__ import annotations

import importlib.util
import json
import os
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np

import colias_sim  # noqa: F401  (registers the envs)

STEPS = 9


def factory(path: str) -> Any:
    """What builds the model that the file declares, for a shape."""
    name = f"attack_{Path(path).stem.replace('-', '_').replace('.', '_')}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return lambda shape: module.MODEL.build(shape, module.MODEL.robot)


def played(model: Any) -> dict[str, Any]:
    """A few steps with the model: what was observed, and what was raised."""
    seen: dict[str, Any] = {"neural": [], "pixels": [], "outside": "", "raised": ""}
    env = None
    try:
        env = gym.make("colias_sim/Fixation-v0", observation="both", model=model, disable_env_checker=True)
        observation, _ = env.reset(seed=3)
        for _ in range(STEPS):
            _keep(observation, env, seen)
            observation = env.step(np.array([0.2, -0.2], np.float32))[0]
        _keep(observation, env, seen)
    except BaseException as error:  # a model may raise any of them
        try:
            message = str(error)[:300]
        except Exception:
            message = ""
        seen["raised"] = f"{type(error).__name__}: {message}"
    finally:
        if env is not None:
            env.close()
    return seen


def _keep(observation: dict[str, Any], env: Any, seen: dict[str, Any]) -> None:
    seen["neural"].append([float(value) for value in observation["neural"]])
    seen["pixels"].append(int(observation["pixels"].astype(np.int64).sum()))
    if not env.observation_space["neural"].contains(observation["neural"]):
        seen["outside"] = str(observation["neural"])


if __name__ == "__main__":
    how, *paths = sys.argv[1:]
    here, errors, write = Path.cwd(), np.geterr(), Path.write_text
    answers = {}
    environment = dict(os.environ)
    for path in paths:
        try:
            model = str(here / path) if how == "path" else factory(str(here / path))
            answers[Path(path).stem] = played(model)
        finally:
            np.seterr(**errors)
            os.chdir(here)
            os.environ.clear()
            os.environ.update(environment)
    (here / "answers.json").write_text(json.dumps(answers))
