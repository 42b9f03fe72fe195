"""Pages that are made of the code itself, written into docs/generated/ before Sphinx reads its sources.

A writer is a function of a folder, its own in docs/generated/, into which it writes Markdown and pictures. What it
puts into a folder ``site`` there is copied to the top of the site as it is.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

from tools.pages import commands, envs, experiments, models, playground, scenes, stimuli

WRITERS: dict[str, Callable[[Path], None]] = {
    "commands": commands.write,
    "models": models.write,
    "stimuli": stimuli.write,
    "scenes": scenes.write,
    "experiments": experiments.write,
    "envs": envs.write,
    "playground": playground.write,
}
"""The folder in docs/generated/ -> what writes into it."""
_LOGGER = logging.getLogger(__name__)


def _on_builder_inited(app: Sphinx) -> None:
    for name, write in WRITERS.items():
        folder = Path(app.srcdir) / "generated" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        _LOGGER.info("generating %s", name)
        write(folder)
        if (folder / "site").is_dir():
            app.config.html_extra_path.append(str(folder / "site"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when Sphinx begins."""
    app.connect("builder-inited", _on_builder_inited, priority=100)  # autosummary looks for pages at 500
    return {"parallel_read_safe": True, "parallel_write_safe": True}
