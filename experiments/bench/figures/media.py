"""Media of figures, each with its own size of figure and type: a paper, a talk, or a page of the web."""

from __future__ import annotations

from contextvars import ContextVar
from dataclasses import dataclass
from enum import StrEnum


class Medium(StrEnum):
    """A medium that a command draws its figures for."""

    PAPER = "paper"
    TALK = "talk"
    WEB = "web"


@dataclass(frozen=True, slots=True)
class Sheet:
    """Size of a figure that is as wide as a page.

    Parameters
    ----------
    inches
        Its width. Type grows with it.
    dpi
        Dots per inch of the PNG file.
    """

    inches: float
    dpi: float


SHEETS = {Medium.PAPER: Sheet(7.16, 300.0), Medium.TALK: Sheet(13.33, 144.0), Medium.WEB: Sheet(8.95, 160.0)}
"""Medium -> its sheet: both columns of IEEE's page, with type of 8 points; a wide slide, with 15 points; 860 pixels of
a web page, with 13 pixels."""
_CHOSEN: ContextVar[Medium] = ContextVar("medium", default=Medium.WEB)


def choose(medium: Medium) -> Medium:
    """Have all later figures written for ``medium``; return it."""
    _CHOSEN.set(medium)
    return medium


def sheet() -> Sheet:
    """Return the sheet of the medium that figures are written for."""
    return SHEETS[_CHOSEN.get()]
