"""Templates of pages and files, filled in: the one Jinja environment."""

import functools
from typing import Any

import jinja2


def render(name: str, /, **values: Any) -> str:
    """Fill in a template; what it is filled with is escaped where it makes HTML.

    Parameters
    ----------
    name
        Path below ``experiments``: ``"cli/new/model.py.j2"``.
    **values
        The names that the template uses.

    Returns
    -------
    str
        The text, without a newline at its end.

    Raises
    ------
    jinja2.UndefinedError
        The template uses a name that has no value.
    """
    return _environment().get_template(name).render(**values)


@functools.cache
def _environment() -> jinja2.Environment:
    return jinja2.Environment(
        loader=jinja2.PackageLoader("experiments", ""),
        autoescape=lambda name: name is not None and name.endswith(".html.j2"),
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
