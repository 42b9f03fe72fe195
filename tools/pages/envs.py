"""Pages: a page for each env, its own documentation with a picture."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path

import cv2
import gymnasium as gym
import numpy as np

from colias_sim.envs import ENVS
from colias_sim.envs.measures import EnvEntry
from experiments.behaviours import BEHAVIOURS
from tools.pages import markdown
from tools.pages.markdown import code, prose, sentence, table

STEPS, AHEAD = 20, 0.3
"""Until the picture is taken, and the speed of both wheels."""
SIZE = (640, 480)
"""Size of the picture, width and height, px."""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    for name, entry in ENVS.items():
        _write_page(folder, name, entry)
    rows = [(f"[{code(name)}]({_page(name)}.md)", prose(sentence(entry.summary))) for name, entry in ENVS.items()]
    markdown.write(
        folder / "index.md",
        "# Envs\n",
        "Gymnasium envs in which the observer drives itself.\n"
        "[Behaviours and training](../../behaviours-and-training.md) closes the loop by reflexes and policies,"
        " and [Reinforcement learning](../../reinforcement-learning.md) wraps, randomises and films them.\n",
        table(("Env", "Task"), rows),
        markdown.toctree(map(_page, ENVS)),
    )


def _page(name: str) -> str:
    return name.partition("/")[2]


def _write_page(folder: Path, name: str, entry: EnvEntry) -> None:
    page = _page(name)
    _draw(name, folder / f"{page}.png")
    module, _, kind = entry.entry_point.partition(":")
    env = getattr(importlib.import_module(module), kind)
    alt = f"The arena of {page}, with a close view of the observer and what its camera sees"
    caption = (
        f"What `render()` shows {STEPS} steps after `reset(seed=0)`, both wheels at {AHEAD:g}."
        " At the left the observer from near, at the right its camera."
    )
    baselines = [f"{code(baseline)}: {prose(BEHAVIOURS[baseline].summary)}" for baseline in entry.baselines]
    rows = [
        ("Make it", code(f'gymnasium.make("{name}")')),
        ("Class", code(f"{module}.{kind}")),
        ("Steps", f"{entry.max_episode_steps:,} at most"),
        ("Measures", ", ".join(prose(all_measure.name) for all_measure in entry.all_measures)),
        ("Baselines", "<br>".join(baselines)),
    ]
    markdown.write(
        folder / f"{page}.md",
        f"# {page.partition('-')[0]}\n",
        f"{prose(sentence(entry.summary))}\n",
        table(("Env", code(name)), rows),
        _anchor(module, kind),
        f"{entry.note}\n" if entry.note else "",
        markdown.picture(f"{page}.png", alt, caption),
        inspect.cleandoc(env.__doc__),
    )


def _anchor(module: str, kind: str) -> str:
    """Return what links to the class of the env lead to."""
    text = "A [ColiasEnv](../api/colias_sim.envs.base.ColiasEnv.rst): that page has its methods."
    return f":::{{py:class}} {module}.{kind}(**arguments)\n{text}\n:::\n"


def _draw(name: str, path: Path) -> None:
    env = gym.make(name, observation="pixels", render_mode="rgb_array", render_width=SIZE[0], render_height=SIZE[1])
    env.reset(seed=0)
    for _ in range(STEPS):
        env.step(np.full(2, AHEAD, np.float32))
    picture = env.render()
    env.close()
    cv2.imwrite(str(path), cv2.cvtColor(np.asarray(picture, np.uint8), cv2.COLOR_RGB2BGR))
