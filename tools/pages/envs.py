"""The page of envs: what all share, and each with its own documentation, a picture and its arguments."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym

from colias_sim import envs
from colias_sim.envs import ENVS, FACTORS
from experiments.paper.behaviours import BEHAVIOURS
from tools.pages import markdown


def write(folder: Path) -> None:
    """Write the page and its pictures into ``folder``."""
    factors = [(f"`{name}`", f"{f.low:g} to {f.high:g} {f.unit}", f.changes) for name, f in FACTORS.items()]
    markdown.write(
        folder / "index.md",
        "# Envs\n",
        "Gymnasium envs in which the observer drives itself.\n"
        "[Use environments and reflexes](../../how-to/environments-and-reflexes.md) closes the loop,"
        " and [Train by reinforcement learning](../../how-to/reinforcement-learning.md) trains policies.\n",
        (inspect.getdoc(envs) or "").partition("\n\n")[2],
        markdown.table(("Factor", "Range", "What varies"), factors),
        *(part for name in ENVS for part in _parts(folder, name)),
    )


def _parts(folder: Path, name: str) -> list[str]:
    """Return the parts of an env's section."""
    env, title = ENVS[name], name.partition("/")[2]
    _draw(name, folder / f"{title}.png")
    baselines = [f"- `{baseline}`: {BEHAVIOURS[baseline].summary}" for baseline in env.baselines]
    return [
        f"## {title}\n",
        f"{markdown.sentence(env.summary)} `gymnasium.make(\"{name}\")` makes it.\n",
        markdown.picture(f"{title}.png", f"The arena of {title}, the observer from near, and what its camera sees",
                         "`render()` after `reset(seed=0)`."),
        # Links to the env's class lead here.
        f":::{{py:class}} {env.__module__}.{env.__name__}(**arguments)\n"
        "A [ColiasEnv](../api/colias_sim.envs.base.ColiasEnv.rst): that page has its methods.\n:::\n",
        re.sub("^##", "###", str(inspect.getdoc(env)).partition("## Arguments")[0], flags=re.MULTILINE),
        markdown.autodoc(env.options_type),
        f"Measures are {', '.join([*env.measures, *env.collisions, envs.RETURN])}. {env.note}\n",
        "\n".join(baselines),
    ]  # fmt: skip


def _draw(name: str, path: Path) -> None:
    env: Any = gym.make(name, observation="pixels", render_mode="rgb_array", render_width=640, render_height=480)
    env.reset(seed=0)
    cv2.imwrite(str(path), cv2.cvtColor(env.render(), cv2.COLOR_RGB2BGR))
    env.close()
