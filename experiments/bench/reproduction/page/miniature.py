"""A claim as a small picture: the reading that decided it in each replicate, against its bound.

A mark stands for each replicate, at its reading: a dot where the claim holds there, a cross where it fails, a ring
where it could not be judged. The tinted side of the line is where the bound is kept. The picture is SVG, made of
nothing but the stored decisions; its colours are the custom properties of the report's style sheet, light and dark.
"""

from __future__ import annotations

import html
import math
from collections.abc import Sequence
from dataclasses import dataclass

from experiments.bench.stats.checks import Check
from experiments.bench.stats.verdict import Decision

WIDTH, HEIGHT = 160.0, 60.0
TOP, FLOOR = 16.0, 46.0
"""Upper and lower edge of the field that the marks stand in, px."""
INSET = 16.0
"""Distance from the edges of the picture to the outermost reading or bound, px."""
RADIUS, PITCH = 2.6, 5.6
LETTER = 7.2
"""Mean width of a letter of the labels, px."""


@dataclass(frozen=True, slots=True)
class Axis:
    """The axis that the marks of a picture are placed on.

    Parameters
    ----------
    values
        Values of the marks, one for each check.
    bounds
        The values at which a line is drawn: one, or two of a reading that has to lie within them.
    kept
        The two values between which the bound is kept; infinite where nothing ends it.
    says
        The bound, in a few words. The tinted side tells where it is kept: a sign would read as the claim's own words.
    ends
        Labels of the least and the greatest value, with their unit where ``values`` are no readings.
    """

    values: tuple[float, ...]
    bounds: tuple[float, ...]
    kept: tuple[float, float]
    says: str
    ends: tuple[str, str]

    def across(self, value: float) -> float:
        """Return where a value lies in the picture, px from its left edge; infinities lie at the edges."""
        low, high = min(*self.values, *self.bounds), max(*self.values, *self.bounds)
        if math.isinf(value):
            return WIDTH if value > 0 else 0.0
        return INSET + (value - low) / (high - low) * (WIDTH - 2 * INSET) if high > low else WIDTH / 2


def axis(checks: Sequence[Check]) -> Axis:
    """Return the axis of the readings, in their unit, where the checks have one bound.

    Where their bounds differ it is that of the slack: how far inside its bound each reading lies. Where their units
    differ too, marks stand at slacks over scales.

    Parameters
    ----------
    checks
        One or more, with finite readings and bounds.
    """
    first = checks[0]
    if all((check.needs, check.bound, check.unit) == (first.needs, first.bound, first.unit) for check in checks):
        bounds = first.bound if isinstance(first.bound, tuple) else (first.bound,)
        above = first.needs in ("above", "at least")
        kept = (bounds[0], bounds[1]) if len(bounds) == 2 else (bounds[0], math.inf) if above else (-math.inf, *bounds)
        one = bounds == (1.0,) and first.unit in ("spikes", "trials")
        unit = first.unit.removesuffix("s") if one else first.unit
        readings = tuple(check.reading for check in checks)
        says = " ".join(filter(None, ("bound", " to ".join(map(_number, bounds)), unit)))
        return Axis(readings, bounds, kept, says, (_number(min(readings)), _number(max(readings))))
    alike = all(check.unit == first.unit for check in checks)
    values = tuple(check.slack / (1.0 if alike else check.scale) for check in checks)
    least, most = (_slack(checks[values.index(end)]) for end in (min(values), max(values)))
    return Axis(values, (0.0,), (0.0, math.inf), "slack, bound 0", (least, most))


def miniature(decisions: Sequence[Decision]) -> str:
    """Return the picture of a claim, as an ``<svg>`` element that takes its colours from the page around it.

    Parameters
    ----------
    decisions
        What decided in each replicate. Those without a finite reading or bound are not drawn: the label counts them.

    Returns
    -------
    str
        Empty where nothing can be drawn.
    """
    drawn = [(decision.verdict, decision.check) for decision in decisions if decision.check and _finite(decision.check)]
    if not drawn:
        return ""
    place = axis([check for _, check in drawn])
    begin, end = map(place.across, place.kept)
    depth = FLOOR - TOP
    lines = [place.across(bound) for bound in place.bounds]
    parts = [
        f'<rect class="field" y="{TOP:g}" width="{WIDTH:g}" height="{depth:g}"/>',
        f'<rect class="kept" x="{begin:.1f}" y="{TOP:g}" width="{end - begin:.1f}" height="{depth:g}"/>',
        *(f'<path class="bound" d="M{line:.1f} {TOP - 2:g}V{FLOOR:g}"/>' for line in lines),
        _label(place.says, sum(lines) / len(lines), TOP - 4.5),
        *_marks([verdict for verdict, _ in drawn], [place.across(value) for value in place.values]),
        *_ends(place),
    ]
    begin_tag = f'<svg class="mini" viewBox="0 0 {WIDTH:g} {HEIGHT:g}" role="img"'
    return f'{begin_tag} aria-label="{html.escape(described(decisions))}">{"".join(parts)}</svg>'


def described(decisions: Sequence[Decision]) -> str:
    """Say what the picture draws: in how many replicates the claim holds and fails, the readings, and their bound."""
    held, failed = (sum(decision.verdict == word for decision in decisions) for word in ("holds", "fails"))
    numbers = {"holds": held, "fails": failed, "not judged": len(decisions) - held - failed}
    counts = ", ".join(f"{word} in {number}" for word, number in numbers.items() if number)
    checks = [decision.check for decision in decisions if decision.check and _finite(decision.check)]
    if not checks:
        return f"{counts}; no reading"
    place = axis(checks)
    ends = " to ".join(dict.fromkeys(place.ends))
    missing = len(decisions) - len(checks)
    lacking = f"; {missing} without a number" if missing else ""
    return f"{counts}; deciding reading {ends}; {place.says}{lacking}"


def _finite(check: Check) -> bool:
    bounds = check.bound if isinstance(check.bound, tuple) else (check.bound,)
    return all(map(math.isfinite, (check.reading, *bounds)))


def _slack(check: Check) -> str:
    return " ".join(filter(None, (_number(check.slack, "+" if check.slack else ""), check.unit)))


def _number(value: float, sign: str = "") -> str:
    return f"{value:{sign}.3g}".replace("-", "\N{MINUS SIGN}")


def _marks(verdicts: Sequence[str], places: Sequence[float]) -> list[str]:
    """A mark for each replicate; those that would cover each other stand in a column."""
    columns: dict[int, list[int]] = {}
    for index, place in enumerate(places):
        columns.setdefault(round(place / PITCH), []).append(index)
    marks = []
    for indices in columns.values():
        ordered = sorted(indices, key=lambda index: verdicts[index])  # what fails stands together
        step = min(PITCH, (FLOOR - TOP - 3 * RADIUS) / max(len(ordered) - 1, 1))
        across = sum(places[index] for index in ordered) / len(ordered)
        for level, index in enumerate(ordered):
            marks.append(_mark(verdicts[index], across, FLOOR - 1.5 * RADIUS - level * step))
    return marks


def _mark(verdict: str, x: float, y: float) -> str:
    if verdict == "fails":
        arm = 0.95 * RADIUS
        strokes = f"M{x - arm:.1f} {y - arm:.1f}l{2 * arm:g} {2 * arm:g}m0 {-2 * arm:g}l{-2 * arm:g} {2 * arm:g}"
        return f'<path class="failed" d="{strokes}"/>'
    name = "held" if verdict == "holds" else "left"
    return f'<circle class="{name}" cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS if name == "held" else RADIUS - 0.4:g}"/>'


def _ends(place: Axis) -> list[str]:
    """Labels of the least and the greatest reading; one, where two would cover each other."""
    low, high = min(place.values), max(place.values)
    texts, at = place.ends, (place.across(low), place.across(high))
    y = HEIGHT - 3
    if texts[0] == texts[1]:
        return [_label(texts[0], at[0], y)]
    centres = [_clear(text, where) for text, where in zip(texts, at, strict=True)]
    if centres[1] - centres[0] < LETTER * (len(texts[0]) + len(texts[1]) + 2) / 2:
        return [_label(" to ".join(texts), sum(at) / 2, y)]
    return [_label(text, where, y) for text, where in zip(texts, at, strict=True)]


def _label(text: str, x: float, y: float) -> str:
    return f'<text x="{_clear(text, x):.1f}" y="{y:g}" text-anchor="middle">{html.escape(text)}</text>'


def _clear(text: str, x: float) -> float:
    """Return the middle of a text, so that it stays inside the picture."""
    half = min(LETTER * len(text) / 2, WIDTH / 2)
    return min(max(x, half), WIDTH - half)
