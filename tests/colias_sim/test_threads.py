"""Simulations and envs beside other OpenGL, in threads too: made, used and closed by any one of them at a time."""

import contextlib
import importlib
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from unittest.mock import patch

import gymnasium as gym
import mujoco
import numpy as np
from mujoco.rendering.classic import gl_context


def here(call: Callable[..., Any], *arguments: Any, **more: Any) -> Any:
    return call(*arguments, **more)


def elsewhere(call: Callable[..., Any], *arguments: Any, **more: Any) -> Any:
    """Call in a new thread, which ends."""
    with ThreadPoolExecutor(1) as threads:
        return threads.submit(call, *arguments, **more).result()


def pictures(run: Callable[..., Any]) -> list[np.ndarray]:
    """The observations and renders of two envs in turn, each of whose calls ``run`` makes."""
    envs = [run(gym.make, "colias_sim/Fixation-v0", camera=eye, render_mode="rgb_array") for eye in ("ideal", "ov7670")]
    seen = [run(env.reset, seed=3)[0] for env in envs]
    for _ in range(3):
        for env in envs:
            seen += [run(env.step, np.zeros(2, np.float32))[0], run(env.render)]
    for env in envs:
        run(env.close)
    return seen


def test_envs_may_be_made_used_and_closed_in_different_threads(contexts):
    alone, apart = pictures(here), pictures(elsewhere)
    assert all(np.array_equal(one, other) for one, other in zip(alone, apart, strict=True))
    assert len(contexts) == 8


def test_a_renderer_of_somebody_else_between_the_steps_freezes_no_observation():
    """MuJoCo's own leaves its context current."""
    model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><geom size='.1'/></worldbody></mujoco>")

    def observed(foreign: mujoco.Renderer | None) -> list[np.ndarray]:
        with contextlib.closing(gym.make("colias_sim/Fixation-v0")) as env:
            seen = [env.reset(seed=3)[0]]
            for _ in range(4):
                if foreign is not None:
                    foreign.update_scene(mujoco.MjData(model))
                    foreign.render()
                seen.append(env.step(np.array([0.2, -0.2], np.float32))[0].copy())
        return seen

    alone = observed(None)
    # MuJoCo chooses its backend when it is imported, which here may be before colias_sim has named one.
    backend = importlib.import_module(f"mujoco.{os.environ['MUJOCO_GL']}")
    with patch.object(gl_context, "GLContext", backend.GLContext), mujoco.Renderer(model, 24, 32) as foreign:
        beside = observed(foreign)
    assert all(np.array_equal(one, other) for one, other in zip(alone, beside, strict=True))
    assert not np.array_equal(alone[-2], alone[-1])
