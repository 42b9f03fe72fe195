"""Pages that are made of the code itself, written into docs/generated/ before Sphinx reads its sources.

A writer is a module. Its function ``write`` receives a folder of the module's name in docs/generated/, and writes
Markdown and pictures into it. A folder ``site`` there is copied to the top of the site as it is.
"""

from __future__ import annotations

import shutil
from pathlib import Path

from sphinx.application import Sphinx
from sphinx.util import logging

from tools.pages import benchmark, commands, envs, experiments, models, playground, scenes, stimuli

WRITERS = (commands, models, stimuli, scenes, experiments, envs, benchmark, playground)
_LOGGER = logging.getLogger(__name__)


def _on_builder_inited(app: Sphinx) -> None:
    for module in WRITERS:
        name = module.__name__.rpartition(".")[2]
        folder = Path(app.srcdir) / "generated" / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        _LOGGER.info("generating %s", name)
        module.write(folder)
        if (folder / "site").is_dir():
            app.config.html_extra_path.append(str(folder / "site"))


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when Sphinx begins."""
    app.connect("builder-inited", _on_builder_inited, priority=100)  # autosummary looks for pages at 500
    return {"parallel_read_safe": True, "parallel_write_safe": True}
