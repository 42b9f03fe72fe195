"""Pages: a page for each env, its own documentation with a picture."""

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
from colias_sim.envs.measures import EnvEntry
from dsnn.field_docs import kind, meaning
from experiments.behaviours import BEHAVIOURS
from tools.pages import markdown
from tools.pages.markdown import code, prose, sentence, table

STEPS, AHEAD = 20, 0.3
"""Until the picture is taken, and the speed of both wheels."""
SIZE = (640, 480)
"""Size of the picture, width and height, px."""
BASE = "../api/colias_sim.envs.base.ColiasEnv.rst"


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    for name, entry in ENVS.items():
        _write_page(folder, name, entry)
    rows = [(f"[{code(name)}]({_page(name)}.md)", prose(sentence(entry.summary))) for name, entry in ENVS.items()]
    factors = [(code(name), f"{f.low:g} .. {f.high:g} {f.unit}", prose(f.changes)) for name, f in FACTORS.items()]
    markdown.write(
        folder / "index.md",
        "# Envs\n",
        "Gymnasium envs in which the observer drives itself.\n"
        "[Use environments and reflexes](../../how-to/environments-and-reflexes.md) closes the loop,"
        " and [Train by reinforcement learning](../../how-to/reinforcement-learning.md) trains policies.\n",
        table(("Env", "Task"), rows),
        markdown.toctree(map(_page, ENVS)),
        (inspect.getdoc(envs) or "").partition("\n\n")[2],
        table(("Factor", "Range", "What varies"), factors),
    )


def _page(name: str) -> str:
    return name.partition("/")[2]


def _write_page(folder: Path, name: str, entry: EnvEntry) -> None:
    page, place = _page(name), entry.entry_point.replace(":", ".")
    _draw(name, folder / f"{page}.png")
    env: Any = load_env_creator(entry.entry_point)
    alt = f"The arena of {page}, with a close view of the observer and what its camera sees"
    caption = (
        f"What `render()` shows {STEPS} steps after `reset(seed=0)`, both wheels at {AHEAD:g}."
        " At the left the observer from near, at the right its camera."
    )
    baselines = [f"{code(baseline)}: {prose(BEHAVIOURS[baseline].summary)}" for baseline in entry.baselines]
    rows = [
        ("Make it", code(f'gymnasium.make("{name}")')),
        ("Measures", ", ".join(prose(measure.name) for measure in entry.all_measures)),
        ("Baselines", "<br>".join(baselines)),
    ]
    arguments = [
        (code(name), f"{code(kind(field))}, default {code(repr(field.default))}", meaning(env.options_type, name))
        for name, field in env.options_type.__pydantic_fields__.items()
    ]
    markdown.write(
        folder / f"{page}.md",
        f"# {page.partition('-')[0]}\n",
        f"{prose(sentence(entry.summary))}\n",
        table(("Env", code(name)), rows),
        # what links to the class of the env lead to
        f":::{{py:class}} {place}(**arguments)\nA [ColiasEnv]({BASE}): that page has its methods.\n:::\n",
        f"{entry.note}\n" if entry.note else "",
        markdown.picture(f"{page}.png", alt, caption),
        str(inspect.getdoc(env)).partition("## Arguments")[0],
        f"## Arguments\n\n{table(('Argument', 'Type', 'Meaning'), arguments)}",
        "[What all envs share](index.md): spaces, `info`, randomisation, and the options of a reset.\n",
    )


def _draw(name: str, path: Path) -> None:
    env = gym.make(name, observation="pixels", render_mode="rgb_array", render_width=SIZE[0], render_height=SIZE[1])
    env.reset(seed=0)
    for _ in range(STEPS):
        env.step(np.full(2, AHEAD, np.float32))
    picture = env.render()
    env.close()
    cv2.imwrite(str(path), cv2.cvtColor(np.asarray(picture, np.uint8), cv2.COLOR_RGB2BGR))
