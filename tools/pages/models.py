"""Pages: a page for each vision model, with its picture."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import polars as pl

from dsnn import MODELS, ModelEntry
from experiments.bench.report import clips, style
from experiments.bench.run.models import choose, family
from experiments.bench.run.play import Trial, play
from experiments.bench.sources.clips import Clip, Figure
from tools.pages import docstring_text, markdown, parameter_tables
from tools.pages.docstring_text import ASSUMED
from tools.pages.markdown import code, prose, sentence, table
from tools.pages.parameter_tables import changes, parameters, written

EQUATIONS = Path(__file__).parents[2] / "docs" / "reference" / "equations"
"""A page for each model, hand-written."""
CHANNELS: Mapping[str, str] = {
    "hs": "horizontal motion, rightward positive",
    "vs": "vertical motion, downward positive",
    "looming": "what comes nearer",
    "azimuth": "where the motion is, from -1 at the left edge of the view to 1 at the right",
}
"""Channel of a `dsnn.Response` -> what it tells."""
KINDS: Mapping[tuple[str, ...], str] = {
    ("direction",): "Direction",
    ("looming",): "Looming",
    ("direction", "looming"): "Direction and looming",
}
"""Kind of a model's answers -> the heading of its part of the index."""
DARK = (("grey", 40.0), ("background_grey", 200.0))
SQUARE = (("rows", 72), ("columns", 99), ("width", 25.0), ("height", 25.0), ("motion", "rightward"), ("speed", 60.0))
CLIPS: Mapping[str, Clip] = {
    "direction": Clip("dark square rightward", "plain", (*SQUARE, *DARK)),
    "looming": Clip("dark looming", "looming", (("l_over_v_s", 0.16), *DARK)),
}
"""Kind of a model's answers -> the clip that its page shows them to."""


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    for entry in MODELS.values():
        _write_page(folder, entry)
    _write_index(folder)


def _write_index(folder: Path) -> None:
    parts = []
    for kinds, title in KINDS.items():
        rows = [
            (f"[{code(name)}]({name}.md)", prose(sentence(entry.summary)), docstring_text.references(entry.build))
            for name, entry in MODELS.items() if kinds_of(entry) == kinds
        ]  # fmt: skip
        parts.append(f"## {title}\n\n{table(('Model', 'What it is', 'Literature'), rows)}")
    markdown.write(
        folder / "index.md",
        "# Models\n",
        "Every model that ships: its equations, its parameters, and what it answers to one clip.\n"
        "`--model NAME` shows it in every command that takes models, and `dsnn.MODELS[NAME]` is its entry.\n"
        "[Add a model](../../how-to/add-a-model.md) writes another,"
        " and [Looming detectors](../../results-looming.md) compares the looming detectors.\n",
        *parts,
        markdown.toctree(MODELS),
    )


def _write_page(folder: Path, entry: ModelEntry) -> None:
    section = family(entry.name)
    offline = entry.preset("offline")
    equations = (EQUATIONS / f"{entry.name}.md").read_text(encoding="utf-8")
    markdown.write(
        folder / f"{entry.name}.md",
        f"# {entry.name}\n",
        f"{prose(sentence(entry.summary))}\n",
        _facts(entry),
        "## Answer\n",
        *(_picture(folder, entry.name, kind) for kind in kinds_of(entry)),
        "## Equations\n",
        equations,
        _assumed(entry),
        "## Parameters\n",
        f"`--set {section}.NAME=VALUE` sets one, and `--model {entry.name}:NAME=VALUE` sets it for this model alone.\n"
        f"`colias list parameters --only --model {entry.name}` lists them."
        " A parameter without a unit is a number, or in what its meaning says.\n",
        parameters(entry.robot, {"off-line": offline}),
        _presets(entry, section),
    )


def _facts(entry: ModelEntry) -> str:
    build: Any = entry.build
    spikes = [
        f"{code(channel)} at {code(f'{name} = {written(level)}')}"
        for channel in entry.channels
        if (level := entry.threshold(channel, entry.robot)) is not None
        for name in (entry.thresholds.get(channel, "t_sp"),)
    ]
    rows = [
        ("Literature", docstring_text.references(build)),
        ("Kind", KINDS[kinds_of(entry)].lower()),
        ("Channels", "<br>".join(f"{code(channel)}: {CHANNELS[channel]}" for channel in entry.channels)),
        ("Spikes", ", ".join(spikes) or "none"),
        ("Classes", ", ".join(code(f"dsnn.{named.__name__}") for named in (build, type(entry.robot)))),
    ]
    return table(("Model", code(entry.name)), rows)


def kinds_of(entry: ModelEntry) -> tuple[str, ...]:
    """Return what a model answers: ``direction``, ``looming`` or both."""
    return tuple(kind for kind, channel in (("direction", "hs"), ("looming", "looming")) if channel in entry.channels)


def _picture(folder: Path, name: str, kind: str) -> str:
    model, clip = choose(name), CLIPS[kind]
    shown = play(Trial(kind, 0, 0, 0, clip, (model,)))
    title = f"{name}, with its parameters on the robot"
    drawn = clips.draw(Figure(), pl.DataFrame(shown.rows), shown.frames, {name: model.threshold}, title)
    file = style.save(drawn, folder / f"{name}-{kind}").name
    return markdown.picture(file, f"The answers of {name} against time", f"The clip *{clip.name}* at 30 frames/s.")


def assumed(entry: ModelEntry) -> list[str]:
    """Return what no source gives of a model: constants that say so, then what its class lists."""
    constants = [
        f"{code(f'{row.key} = {row.value}')}: {prose(row.description)}"
        for row in parameter_tables.rows(entry.robot)
        if f"({ASSUMED.lower()}" in row.description
    ]
    return [*constants, *docstring_text.assumed(entry.build)]


def _assumed(entry: ModelEntry) -> str:
    words = "What no source gives, and what was taken in its place:"
    return "\n".join(["## What is assumed\n", f"{words}\n", *(f"- {sentence(item)}" for item in assumed(entry)), ""])


def _presets(entry: ModelEntry, section: str) -> str:
    """Return every named set of its parameters, by what it sets otherwise than the class."""
    base, offline = type(entry.robot)(), entry.preset("offline")
    if offline == entry.robot:
        rows = [("robot and off-line", "trials, envs, clips and footage", _changes(entry.robot, base))]
    else:
        rows = [
            ("robot", "trials and envs", _changes(entry.robot, base)),
            ("off-line", "clips and footage", _changes(offline, base)),
        ]
    named: Mapping[str, Any] = base.presets() if hasattr(base, "presets") else {}
    for name, values in named.items():
        rows.append((code(name), code(f"--set {section}.preset={name}"), _changes(values, base)))
    paragraphs = docstring_text.paragraphs(type(base).presets)[1:] if named else []
    heads = ("Preset", "Used by", f"Set otherwise than {code(f'dsnn.{type(base).__name__}')} has it")
    return "\n\n".join(["## Presets", *paragraphs, table(heads, rows)])


def _changes(values: Any, base: Any) -> str:
    return ", ".join(map(code, changes(values, base))) or "nothing"
