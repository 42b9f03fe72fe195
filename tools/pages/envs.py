"""Pages: a page for each env, its own documentation with a picture."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cv2
import gymnasium as gym
import numpy as np

from colias_sim import envs
from colias_sim.envs import ENVS, FACTORS, PRESETS
from colias_sim.envs.measures import EnvEntry
from dsnn.field_docs import kind, meaning
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
        (inspect.getdoc(envs) or "").partition("\n\n")[2],
        "## Factors and presets\n",
        table(
            ("Factor", "Unit", "Range", "What varies"),
            [(code(name), f.unit, f"{f.low:g} .. {f.high:g}", prose(f.changes)) for name, f in FACTORS.items()],
        ),
        table(("Preset", "Ranges"), [(code(name), _ranges(preset)) for name, preset in PRESETS.items()]),
    )


def _ranges(preset: Mapping[str, tuple[float, float]]) -> str:
    return ", ".join(f"{code(name)} {low:g} .. {high:g}" for name, (low, high) in preset.items())


def _page(name: str) -> str:
    return name.partition("/")[2]


def _write_page(folder: Path, name: str, entry: EnvEntry) -> None:
    page = _page(name)
    _draw(name, folder / f"{page}.png")
    module, _, cls = entry.entry_point.partition(":")
    env = getattr(importlib.import_module(module), cls)
    alt = f"The arena of {page}, with a close view of the observer and what its camera sees"
    caption = (
        f"What `render()` shows {STEPS} steps after `reset(seed=0)`, both wheels at {AHEAD:g}."
        " At the left the observer from near, at the right its camera."
    )
    baselines = [f"{code(baseline)}: {prose(BEHAVIOURS[baseline].summary)}" for baseline in entry.baselines]
    rows = [
        ("Make it", code(f'gymnasium.make("{name}")')),
        ("Class", code(f"{module}.{cls}")),
        ("Steps", f"{entry.max_episode_steps:,} at most"),
        ("Measures", ", ".join(prose(all_measure.name) for all_measure in entry.all_measures)),
        ("Baselines", "<br>".join(baselines)),
    ]
    markdown.write(
        folder / f"{page}.md",
        f"# {page.partition('-')[0]}\n",
        f"{prose(sentence(entry.summary))}\n",
        table(("Env", code(name)), rows),
        _anchor(module, cls),
        f"{entry.note}\n" if entry.note else "",
        markdown.picture(f"{page}.png", alt, caption),
        inspect.cleandoc(env.__doc__).partition("## Arguments")[0],
        "## Arguments\n",
        _arguments(env.options_type),
        "[What all envs share](index.md): spaces, `info`, randomisation, and the options of a reset.\n",
    )


def _arguments(options: type[Any]) -> str:
    """Return a table of the fields of an options class."""
    fields = options.__pydantic_fields__.items()
    rows = [
        (code(name), code(repr(field.default)), prose(kind(field)), meaning(options, name)) for name, field in fields
    ]
    return table(("Argument", "Default", "Type", "Meaning"), rows)


def _anchor(module: str, cls: str) -> str:
    """Return what links to the class of the env lead to."""
    text = "A [ColiasEnv](../api/colias_sim.envs.base.ColiasEnv.rst): that page has its methods."
    return f":::{{py:class}} {module}.{cls}(**arguments)\n{text}\n:::\n"


def _draw(name: str, path: Path) -> None:
    env = gym.make(name, observation="pixels", render_mode="rgb_array", render_width=SIZE[0], render_height=SIZE[1])
    env.reset(seed=0)
    for _ in range(STEPS):
        env.step(np.full(2, AHEAD, np.float32))
    picture = env.render()
    env.close()
    cv2.imwrite(str(path), cv2.cvtColor(np.asarray(picture, np.uint8), cv2.COLOR_RGB2BGR))
