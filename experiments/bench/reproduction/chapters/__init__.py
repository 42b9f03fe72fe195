"""Chapters of the report that have a study of their own: each a template and the JSON file that fills it.

A chapter is on the page where the reproduction's folder has its file, and that can be read. Templates use the page's
classes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType

import jinja2
from markupsafe import Markup

from experiments.bench.reproduction.page.stored import read

TITLES: Mapping[str, str] = MappingProxyType(
    {"onboard": "Claims in the robot's own arithmetic", "detectors": "C21 of every looming detector"}
)
"""Chapter -> its title, in the order of the page. ``NAME.html.j2`` here is filled with ``NAME.json`` of the folder."""


@dataclass(frozen=True, slots=True)
class Chapter:
    """A chapter of the page.

    Parameters
    ----------
    name
        Its id on the page.
    title
        Its title.
    html
        All of it, the title among it.
    """

    name: str
    title: str
    html: Markup


def rendered(folder: Path) -> list[Chapter]:
    """Return the chapters that a reproduction's folder has, in the order of the page."""
    environment = jinja2.Environment(
        autoescape=True, trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined
    )
    found = []
    for name, title in TITLES.items():
        table = read(folder, name)
        if table is not None:
            source = files(__name__).joinpath(f"{name}.html.j2").read_text(encoding="utf-8")
            html = environment.from_string(source).render(table=table, name=name, title=title)
            found.append(Chapter(name, title, Markup(html)))  # the template escaped what it was filled with
    return found
