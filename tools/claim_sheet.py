"""All claims as one picture, ``docs/claims.svg``: each with its word and the readings that decided it.

`tools.numbers` draws it from ``docs/results.json``, which it is a pure function of: `tests/tools/test_numbers.py` holds
the one against the other. It has no letters or colours of its own: these are those of the report.
"""

from __future__ import annotations

import html
import re
import textwrap
from collections.abc import Mapping, Sequence
from importlib.resources import files
from typing import Any

from experiments.bench.judging.claims import words
from experiments.bench.judging.count import SIGNS, Count
from experiments.bench.judging.miniature import HEIGHT, WIDTH, miniature
from experiments.bench.judging.stored import decision, decision_entry
from experiments.bench.judging.verdict import Decision

COLUMN, ROW, GAP, TEXT_PX = 196, 134, 10, 60
"""Width of a claim's place and height of it, space around the picture, height of text above a claim's picture; px.

Three columns of this width leave type of some 8 px where the picture is shown 390 px wide.
"""
LETTERS = 25
"""Of a line of the claim's title, of which there are two at most."""
COLUMNS = 3
MARKS = "a dot where the claim holds, a cross where it fails, a ring where it could not be judged"
KEY = (
    f"In the picture a mark is a replicate: {MARKS}. Above the marks stand what is read and its bound, below them the"
    " least and the greatest reading. The line is the bound, and its tinted side keeps the claim. HS and VS are"
    " potentials, without a unit. A *lead* is the difference between what should be larger and what should be smaller:"
    " of potentials, or of spikes a trial. A *slack* is how far inside its bound a reading lies, below 0 outside: C11"
    " and C30 ask several things with different bounds, and not the same decides in each replicate. Of B1 to B4 the"
    " reading is the lower end of the 95 % interval."
    " A claim that no seed moves has one mark. Of a claim with two halves a mark stands at the half that is nearer to"
    " failing; the DSNN's half alone is in the table. *T* is the spiking threshold: 0.16 for clips, 0.2 on the robot."
)
"""What the picture does not say by itself, in Markdown."""
QUANTITIES: Mapping[str, tuple[str, ...]] = {
    "HS": ("C1", "C6", "C14", "C28"),
    "|HS|": ("C11",),
    "|VS|": ("C8",),
    "|HS| or |VS|": ("C2", "C3", "C5"),
    "HS correlation": ("C12",),
    "lead in HS": ("C7", "C9", "C10", "C24", "C25", "C26"),
    "lead": ("C15", "C16", "C17", "C18", "C19", "C20", "C21", "C29", "C31"),
    "share left": ("C4", "C22"),
    "share of |HS|": ("C23",),
    "|HS|, |VS| ratio": ("C27",),
    "with spikes": ("C13",),
    "": ("C30",),
    "ratio of rates": ("B1", "B2"),
    "optomotor gain": ("B3",),
    "time on target": ("B4",),
}
"""What the reading that decides a claim is -> the claims. Results keep numbers of readings, and not their words."""
NUMBERS = ("reading", "bound", "needs", "unit", "scale")
"""What is kept of a check: all but its words."""
STYLE = """
text { font-family: system-ui, sans-serif; fill: var(--text); font-size: 13px }
.mini text { font-size: 12px }
.ground { fill: var(--ground) }
.name { font-weight: 600 }
"""


def kept(drawn: Decision) -> dict[str, Any]:
    """Return what ``docs/results.json`` keeps of a decision: the numbers alone, as `decisions_of` reads them."""
    entry = decision_entry(drawn)
    numbers = entry["check"] and {name: entry["check"][name] for name in NUMBERS}
    return {"verdict": entry["verdict"], "check": numbers}


def decisions_of(claim: Mapping[str, Any]) -> list[Decision]:
    """Return what decided a claim in each replicate, from its entry in the results; none of results from before."""
    rows = claim.get("decisions", ())
    return [decision({**row, "check": row["check"] and {"says": "", **row["check"]}}) for row in rows]


def has_readings(results: Mapping[str, Any]) -> bool:
    """Return whether the results keep what decided in each replicate."""
    return any(map(decisions_of, (*results["claims"], *results["behaviours"])))


def sheet(results: Mapping[str, Any]) -> str:
    """Return the picture as an SVG file, light or dark as its reader's screen is.

    Parameters
    ----------
    results
        What ``docs/results.json`` holds.
    """
    claims = [*results["claims"], *results["behaviours"]]
    rows = -(-len(claims) // COLUMNS)
    wide, high = COLUMN * COLUMNS + 2 * GAP, rows * ROW + 2 * GAP
    places = [_place(claim, GAP + at // rows * COLUMN, GAP + at % rows * ROW) for at, claim in enumerate(claims)]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" height="{high}">\n'
        f"<style>{_style()}</style>\n"
        f'<rect class="ground" width="{wide}" height="{high}"/>\n' + "\n".join(places) + "\n</svg>\n"
    )


def _place(claim: Mapping[str, Any], x: int, y: int) -> str:
    count = Count(**claim["count"])
    sign = "" if count.kind == "counted" else f"{SIGNS[count.kind]} "  # no key of signs here
    head = f"{claim['id']} {sign}{count.label}"
    lines = textwrap.wrap(words(claim["id"]).title, LETTERS)
    texts = [
        f'<text class="name {count.kind}" x="{x}" y="{y + 18}">{html.escape(head)}</text>',
        *(f'<text x="{x}" y="{y + 36 + 16 * at}">{html.escape(line)}</text>' for at, line in enumerate(lines[:2])),
    ]
    quantity = next((name for name, ids in QUANTITIES.items() if claim["id"] in ids), "")
    picture = miniature(decisions_of(claim), quantity)
    place = f'<svg x="{x}" y="{y + TEXT_PX}" width="{WIDTH:g}" height="{HEIGHT:g}"'
    return "".join([*texts, picture.replace("<svg", place, 1)])


def _style() -> str:
    """The report's colours, and its rules for the parts of a picture and for the words of verdicts."""
    text = files("experiments.bench.reproduction").joinpath("page/style.css").read_text(encoding="utf-8")
    light, dark = re.findall(r":root \{.*?\}", text, re.DOTALL)
    rules = re.findall(r"^\.mini \..*$", text, re.MULTILINE)
    kinds = [f".name.{kind} {{ fill: var(--{kind}-ink) }}" for kind in SIGNS]
    return "\n".join([light, f"@media (prefers-color-scheme: dark) {{ {dark} }}", *rules, *kinds, STYLE])


def described(claims: Sequence[Mapping[str, Any]]) -> str:
    """Return the words that stand in the picture's place for who cannot see it."""
    return (
        f"The {len(claims)} claims, each with a mark for every replicate at the reading that decided there: {MARKS};"
        " the line is the bound, and its tinted side keeps it"
    )
