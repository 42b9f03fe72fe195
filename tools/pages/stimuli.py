"""Pages: a page for each stimulus, with its picture."""

from __future__ import annotations

import inspect
from pathlib import Path

from dsnn.stimuli import STIMULI, StimulusEntry
from tools.pages import docstring_text, markdown, stimulus_pictures
from tools.pages.markdown import code, prose, sentence, table
from tools.pages.parameter_tables import parameters


def write(folder: Path) -> None:
    """Write the pages into ``folder``."""
    for entry in STIMULI.values():
        _write_page(folder, entry)
    rows = ((f"[{code(name)}]({name}.md)", prose(sentence(entry.summary))) for name, entry in STIMULI.items())
    markdown.write(
        folder / "index.md",
        "# Stimuli\n",
        "Synthetic clips with their ground truth.\n"
        "[`colias video NAME --out NAME.avi`](../commands/video.md) writes one,"
        " [`colias watch NAME`](../commands/watch.md) shows it to a model,"
        " and `dsnn.stimuli.stimulus(NAME)` makes it in Python.\n"
        "An experiment of your own [declares clips of them](../../how-to/experiments-claims-and-arenas.md).\n",
        table(("Stimulus", "What it shows"), rows),
        markdown.toctree(STIMULI),
    )


def _write_page(folder: Path, entry: StimulusEntry) -> None:
    name, params = entry.name, type(entry.params)
    row = stimulus_pictures.draw(entry, folder / f"{name}.png")
    band = stimulus_pictures.BANDS.get(name)
    slice_text = f"the darkest of the {band} rows about row {row}" if band else f"row {row}"
    caption = (
        f"Frames of {code(name)} as its defaults make it, at seed 0."
        f" Below, {slice_text} of every frame, one below the other; the marks at its right are the frames above."
    )
    about = docstring_text.paragraphs(params)
    kind = [] if not inspect.isclass(entry.build) else docstring_text.paragraphs(entry.build)
    markdown.write(
        folder / f"{name}.md",
        f"# {name}\n",
        f"{prose(sentence(entry.summary))}\n",
        *(f"{text}\n" for text in (*about, *kind)),
        markdown.picture(f"{name}.png", f"Five frames of the stimulus {name}, and a slice through space and time",
                         caption),
        "## Parameters\n",
        f"`--set {name}.NAME=VALUE` sets one, and `colias list parameters {name}` lists them.\n",
        parameters(entry.params),
    )  # fmt: skip
