"""Configuration of Sphinx, which builds the documentation: ``make docs``."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version as installed
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
# Tutorials run `colias` as a reader does, and find this checkout.
os.environ["PATH"] = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
os.environ["COLUMNS"] = "100"

from tools.pages import api  # noqa: E402  (after the path)

project = "colias-sim"
author = "the colias-sim authors"
project_copyright = "the colias-sim authors, MIT licence"
version = release = installed("colias-sim")

extensions = [
    "myst_nb",  # Markdown, and tutorials that are notebooks in text form
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_design",  # cards and tabs
    "sphinx_copybutton",
    "tools.pages.mathml",
    "tools.pages.blocks",
    "tools.pages.generated",
    "tools.pages.api",
]
# Other pages include the last two.
exclude_patterns = ["_build", "**/.ipynb_checkpoints", "reference/equations", "generated/scenes"]
root_doc = "index"
nitpicky = False

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath", "attrs_inline"]
myst_heading_anchors = 4
suppress_warnings: list[str] = []

nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_merge_streams = True

default_role = "py:obj"  # a `name` in a docstring is a link where that has a page, and code elsewhere
templates_path = ["_templates"]
autosummary_generate = True
autosummary_filename_map = api.filenames()
autosummary_imported_members = True
autosummary_context = {"fields": api.fields()}
autodoc_member_order = "bysource"
maximum_signature_line_length = 80  # with types: a parameter a line
python_use_unqualified_type_names = True
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False
numpydoc_xref_param_type = True
numpydoc_xref_aliases = api.links()
numpydoc_xref_ignore = "all"  # other words of types than these aliases

html_theme = "pydata_sphinx_theme"
html_title = "colias-sim"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_favicon = "_static/favicon.svg"
# These have no pages below.
html_sidebars = {page: [] for page in ("index", "install", "gallery/index")}
html_math_renderer = "mathml"
html_show_sourcelink = False
html_copy_source = False
html_last_updated_fmt = None
html_theme_options = {
    "show_prev_next": True,
    "navigation_depth": 3,
    "show_toc_level": 2,
    "collapse_navigation": True,  # a page lists its own section alone
    "header_links_before_dropdown": 8,
    "logo": {"text": f"colias-sim {version}"},
    "navbar_end": ["playground", "theme-switcher"],
    "navbar_persistent": ["search-button"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "pygments_light_style": "tango",
    "pygments_dark_style": "monokai",
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
