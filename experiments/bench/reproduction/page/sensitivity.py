"""What the claims survive: the matrix of moves by claims, as a table of the page and as ``sensitivity.svg``."""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass

import matplotlib as mpl
from matplotlib.figure import Figure

from experiments.bench.figures.plotting import STYLE
from experiments.bench.judging.count import SIGNS, Kind
from experiments.bench.judging.verdict import Outcome
from experiments.bench.reproduction import robustness

SHADES = {"holds": "#2a9d8f", "fails": "#b5485d"}
UNJUDGED = "#cfcfcf"
DEFAULTS = "defaults (replicate 0)"


@dataclass(frozen=True, slots=True)
class Cell:
    """A claim after a move: what it came to, its style class and sign, and whether that is as with the defaults."""

    verdict: str
    kind: Kind
    sign: str
    same: bool


@dataclass(frozen=True, slots=True)
class Move:
    """A row of the table: what was moved, and a cell for each claim of `robustness.ROBOT_CLAIMS`."""

    name: str
    cells: tuple[Cell, ...]


def moves(verdicts: Mapping[str, Mapping[str, Outcome]]) -> list[Move]:
    """Return the rows of the table, the defaults first."""
    return [
        Move(_name(name), tuple(_cell(found[claim], verdicts[robustness.MODEL][claim]) for claim in found))
        for name, found in verdicts.items()
    ]


def _cell(found: Outcome, defaults: Outcome) -> Cell:
    kind: Kind = "holds" if found.verdict == "holds" else "fails" if found.judged else "unjudged"
    return Cell(found.verdict, kind, SIGNS[kind], found.verdict == defaults.verdict)


def _name(move: str) -> str:
    return DEFAULTS if move == robustness.MODEL else move


def draw(verdicts: Mapping[str, Mapping[str, Outcome]]) -> Figure:
    """Draw the matrix: what was moved, down; claims, across; the verdict in words and colour.

    Parameters
    ----------
    verdicts
        Move -> claim of `robustness.ROBOT_CLAIMS` -> what was found.

    Returns
    -------
    matplotlib.figure.Figure
        A row for each move, the first on top.
    """
    claims, names = robustness.ROBOT_CLAIMS, list(verdicts)
    with mpl.rc_context(STYLE):
        drawn = Figure(figsize=(8.2, 0.6 + 0.3 * len(names)), layout="constrained")
        axes = drawn.subplots()
        for row, name in enumerate(names):
            for column, claim in enumerate(claims):
                verdict = verdicts[name][claim].verdict
                axes.barh(row, 0.94, left=column - 0.47, height=0.88, color=SHADES.get(verdict, UNJUDGED))
                axes.text(column, row, verdict, ha="center", va="center", fontsize=8,
                          color="white" if verdict in ("holds", "fails") else "black")  # fmt: skip
        axes.set_xticks(range(len(claims)), claims)
        axes.set_yticks(range(len(names)), [_name(name) for name in names])
        axes.xaxis.tick_top()
        axes.tick_params(length=0)
        axes.spines[:].set_visible(False)
        axes.set(xlim=(-0.5, len(claims) - 0.5), ylim=(len(names) - 0.5, -0.5))
    return drawn


def sensitivity_figure(verdicts: Mapping[str, Mapping[str, Outcome]]) -> str:
    """Return the matrix that `draw` makes as SVG."""
    drawn, stream = draw(verdicts), io.StringIO()
    with mpl.rc_context(STYLE):
        drawn.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()
