"""Pages: a page for each vision model: its response to a clip, equations, class and parameters, and an index."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import polars as pl
from numpydoc.docscrape import NumpyDocString

from dsnn import MODELS, ModelEntry
from experiments.base.values import key_texts
from experiments.declare.clip import Clip, ClipFigure
from experiments.draw import clips, style
from experiments.settings.models import PRESET, choose, family
from experiments.show.clips import ClipTrial
from experiments.show.play import play
from tools.pages import markdown
from tools.pages.markdown import sentence, table

EQUATIONS = Path(__file__).parents[2] / "docs" / "reference" / "equations"
"""A page for each model, hand-written."""
DARK = (("grey", 40.0), ("background_grey", 200.0))
SQUARE = (("rows", 72), ("columns", 99), ("width", 25.0), ("height", 25.0), ("motion", "rightward"), ("speed", 60.0))
CLIPS: Mapping[str, Clip] = {
    "hs": Clip("dark square rightward", "plain", (*SQUARE, *DARK)),
    "looming": Clip("dark looming", "looming", (("l_over_v_s", 0.16), *DARK)),
}
"""Channel of a model -> the clip that its page shows."""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    rows = []
    for name, entry in MODELS.items():
        _write_page(folder, entry)
        channels = ", ".join(f"`{channel}`" for channel in entry.channels)
        literature = " ".join(NumpyDocString(inspect.getdoc(entry.build) or "")["References"])
        rows.append((f"[`{name}`]({name}.md)", sentence(entry.summary), channels, literature))
    markdown.write(
        folder / "index.md",
        "# Models\n",
        "Every model that ships: its equations, its parameters, and its response to one clip.\n"
        "`--model NAME` shows it in every command that takes models, and `dsnn.MODELS[NAME]` is its entry.\n"
        "[Add a model](../../how-to/add-a-model.md) writes another,"
        " and [Looming detectors](../../results/looming.md#looming-detectors) compares the looming detectors.\n",
        table(("Model", "What it is", "Channels", "Literature"), rows),
        markdown.toctree(MODELS),
    )


def _write_page(folder: Path, entry: ModelEntry) -> None:
    section = family(entry.name)
    markdown.write(
        folder / f"{entry.name}.md",
        f"# {entry.name}\n",
        f"{sentence(entry.summary)}\n",
        "## Response\n",
        *(_picture(folder, entry.name, channel) for channel in CLIPS if channel in entry.channels),
        "## Equations\n",
        (EQUATIONS / f"{entry.name}.md").read_text(encoding="utf-8"),
        "## What is computed and assumed\n",
        markdown.autodoc(entry.build, "dsnn"),
        "## Parameters\n",
        f"`--set {section}.NAME=VALUE` sets one, and `--model {entry.name}:NAME=VALUE` sets it for this model alone.\n",
        markdown.autodoc(type(entry.robot), "dsnn"),
        "## Presets\n",
        _presets(entry, section),
    )


def _picture(folder: Path, name: str, channel: str) -> str:
    model, clip = choose(name), CLIPS[channel]
    shown = play(ClipTrial("page", 0, 0, 0, clip, (model,)))
    title = f"{name}, with its parameters on the robot"
    file = f"{name}-{channel}.png"
    with style.look():
        drawn = clips.draw(ClipFigure(), pl.DataFrame(shown.rows), shown.frames, {name: model.threshold}, title)
        drawn.savefig(folder / file, dpi=markdown.DPI)
    return markdown.picture(file, f"The response of {name} over time", f"The clip *{clip.name}* at 30 frames/s.")


def _presets(entry: ModelEntry, section: str) -> str:
    """Return every named set of its parameters, by what it sets otherwise than the class."""
    base: Any = type(entry.robot)()
    named = {"trials and envs": entry.robot, "clips and footage": entry.preset("offline")}
    if hasattr(base, "presets"):
        named |= {f"`--set {section}.preset={name}`": values for name, values in base.presets().items()}
    rows = []
    for used, values in named.items():
        names = [field.name for field in dataclasses.fields(values) if field.name != PRESET]
        changed = {name: getattr(values, name) for name in names if getattr(values, name) != getattr(base, name)}
        rows.append((used, ", ".join(f"`{text}`" for text in key_texts(changed)) or "nothing"))
    return table(("Used by", "Set otherwise than by default"), rows)
