"""Pages: a page for each env, its own documentation with a picture and its arguments."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import numpy as np
from gymnasium.envs.registration import load_env_creator

from colias_sim import envs
from colias_sim.envs import ENVS, FACTORS
from experiments.behaviours import BEHAVIOURS
from tools.pages import markdown
from tools.pages.markdown import sentence, table

STEPS, AHEAD = 20, 0.3
"""Until the picture is taken, and the speed of both wheels."""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    pages = {name: name.partition("/")[2] for name in ENVS}
    for name, page in pages.items():
        _draw(name, folder / f"{page}.png")
        markdown.write(folder / f"{page}.md", *_parts(name, page))
    factors = [(f"`{name}`", f"{f.low:g} to {f.high:g} {f.unit}", f.changes) for name, f in FACTORS.items()]
    markdown.write(
        folder / "index.md",
        "# Envs\n",
        "Gymnasium envs in which the observer drives itself.\n"
        "[Use environments and reflexes](../../how-to/environments-and-reflexes.md) closes the loop,"
        " and [Train by reinforcement learning](../../how-to/reinforcement-learning.md) trains policies.\n",
        table(("Env", "Task"), [(f"[`{name}`]({pages[name]}.md)", sentence(ENVS[name].summary)) for name in ENVS]),
        markdown.toctree(pages.values()),
        (inspect.getdoc(envs) or "").partition("\n\n")[2],
        table(("Factor", "Range", "What varies"), factors),
    )


def _parts(name: str, page: str) -> list[str]:
    """Return the parts of an env's page."""
    entry = ENVS[name]
    env: Any = load_env_creator(entry.entry_point)
    baselines = [f"- `{baseline}`: {BEHAVIOURS[baseline].summary}" for baseline in entry.baselines]
    return [
        f"# {page.partition('-')[0]}\n",
        f"{sentence(entry.summary)} `gymnasium.make(\"{name}\")` makes it.\n",
        markdown.picture(f"{page}.png", f"The arena of {page}, the observer from near, and what its camera sees",
                         f"`render()` {STEPS} steps after `reset(seed=0)`, with both wheels at {AHEAD:g}."),
        # Links to the env's class lead here.
        f":::{{py:class}} {entry.entry_point.replace(':', '.')}(**arguments)\n"
        "A [ColiasEnv](../api/colias_sim.envs.base.ColiasEnv.rst): that page has its methods.\n:::\n",
        str(inspect.getdoc(env)).partition("## Arguments")[0],
        "## Arguments\n",
        markdown.autodoc(env.options_type),
        "## Measures and baselines\n",
        f"Measures are {', '.join(measure.name for measure in entry.all_measures)}. {entry.note}\n",
        "\n".join(baselines),
        "\n[What all envs share](index.md): spaces, `info`, randomisation, and the options of a reset.\n",
    ]  # fmt: skip


def _draw(name: str, path: Path) -> None:
    env = gym.make(name, observation="pixels", render_mode="rgb_array", render_width=640, render_height=480)
    env.reset(seed=0)
    for _ in range(STEPS):
        env.step(np.full(2, AHEAD, np.float32))
    picture = env.render()
    env.close()
    cv2.imwrite(str(path), cv2.cvtColor(np.asarray(picture, np.uint8), cv2.COLOR_RGB2BGR))
