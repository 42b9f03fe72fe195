"""What a machine can see wrong in a figure: each function returns what it found, in words; an empty list is well."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure, SubFigure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Bbox

Place = tuple[str, Bbox]
LEAST_POINTS = 8.0
"""Of type as printed."""
DIMENSIONLESS = (
    "spikes", "potential", "response", "accuracy", "auc", "alarms", "return", "time on target", "gain", "trials",
    "frame", "hs", "share", "reflectance", "contrast", "motion of", "direction in", "on target",
)  # fmt: skip
"""Words of a label that needs no unit: counts, potentials, shares, and classes."""
UNIT = re.compile(r"\(.+\)|%|/min|/m\b|µs|, deg|cm/s|°")


def drawn(figure: Figure) -> list[Place]:
    """Draw a figure; return its texts with their places."""
    return [(text.get_text(), box) for text, box in drawn_texts(figure)]


def drawn_texts(figure: Figure) -> list[tuple[Text, Bbox]]:
    """Draw a figure; return its texts, each with its place. An axis keeps labels that it does not draw."""
    texts: list[Text] = []
    draw = Text.draw
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Text, "draw", lambda self, *args, **more: (texts.append(self), draw(self, *args, **more)))
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        visible = {id(text): text for text in texts if text.get_text().strip() and text.get_visible()}.values()
        placed = [(text, text.get_window_extent(canvas.get_renderer())) for text in visible]
    return [(text, box) for text, box in placed if box.width > 1 and box.height > 1]


def small(texts: Sequence[Text], printed: float) -> list[str]:
    """Texts of less than 8 points where the figure is ``printed`` at that share of its size."""
    return [f"{text.get_text()!r}: {text.get_fontsize() * printed:.1f} points" for text in texts
            if text.get_fontsize() * printed < LEAST_POINTS - 1e-6]  # fmt: skip


def faint(texts: Sequence[Text], least: float = 3.0) -> list[str]:
    """Texts of less contrast to the figure's white than that, by WCAG 2.1; those in cells of maps are on colours."""
    faults = []
    for text in texts:
        if text.axes is not None and text.axes.images:
            continue
        coded = np.asarray(to_rgb(text.get_color()))
        parts = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
        ratio = 1.05 / (float(parts @ (0.2126, 0.7152, 0.0722)) + 0.05)
        if ratio < least:
            faults.append(f"{text.get_text()!r}: {ratio:.1f}")
    return faults


def overlaps(places: Sequence[Place]) -> list[str]:
    """Texts that lie on each other, but for a tenth of their height and a fiftieth of their width."""
    small = [(text, box.shrunk(0.98, 0.88)) for text, box in places]
    return [f"{one!r} on {other!r}" for (one, a), (other, b) in itertools.combinations(small, 2) if a.overlaps(b)]


def outside(figure: Figure, places: Sequence[Place]) -> list[str]:
    """Texts that run out of the figure by more than a pixel."""
    whole = figure.bbox
    return [
        text for text, box in places
        if box.x0 < whole.x0 - 1 or box.y0 < whole.y0 - 1 or box.x1 > whole.x1 + 1 or box.y1 > whole.y1 + 1
    ]  # fmt: skip


def panels(figure: Figure) -> list[Axes]:
    """The axes that show data."""
    return [axes for axes in figure.axes if axes.get_visible() and axes.axison]


def _titles(axes: Axes) -> list[str]:
    return [axes.get_title(loc=side) for side in ("left", "center", "right")]  # type: ignore[arg-type]


def _parents(axes: Axes) -> Iterable[Any]:
    place: Any = axes.get_figure(root=False)
    while place is not None:
        yield place
        place = place.get_figure(root=False) if isinstance(place, SubFigure) else None


def _neighbours(axes: Axes, name: str) -> list[Axes]:
    """The panels of the same figure in its column, or in its row, itself among them: one label is for all."""
    cell = axes.get_subplotspec()
    if cell is None:  # panels of a video are placed by hand: one label is for a column
        left = axes.get_position().x0
        return [other for other in axes.get_figure(root=False).axes if abs(other.get_position().x0 - left) < 1e-3]
    span = "colspan" if name == "x" else "rowspan"
    return [
        other for other in axes.get_figure(root=False).axes
        if (spec := other.get_subplotspec()) and spec.get_gridspec() is cell.get_gridspec() and other.get_visible()
        and getattr(spec, span).start == getattr(cell, span).start
    ]  # fmt: skip


def _named(axes: Axes, name: str) -> bool:
    """Whether an axis has words for numbers, or nothing at all, at its ticks."""
    ticks = [tick.get_text() for tick in getattr(axes, f"get_{name}ticklabels")() if tick.get_text()]
    return not any(number(tick) is not None for tick in ticks)


def number(text: str) -> float | None:
    """The number that a tick label says, if it says one."""
    digits = text.replace("\N{MINUS SIGN}", "-").replace("$\\mathdefault{", "").replace("}$", "")
    try:
        return float(digits)
    except ValueError:
        return None


def unlabelled(figure: Figure) -> list[str]:
    """Axes of numbers without a label that says what they are, with a unit or as a number without one."""
    faults = []
    for axes in panels(figure):
        if axes.name == "polar":
            continue  # its angles are words, its radius is said in the key
        for name in ("x", "y"):
            if _named(axes, name):
                continue
            labels = [getattr(other, f"get_{name}label")() for other in _neighbours(axes, name)]
            labels += [getattr(part, f"get_sup{name}label")() for part in _parents(axes)]
            texts = [label for label in (*labels, *_titles(axes)) if label]
            if not any(UNIT.search(label) or any(word in label.lower() for word in DIMENSIONLESS) for label in texts):
                faults.append(f"{name} axis of {_titles(axes)}: {texts}")
    return faults


def keys(figure: Figure) -> list[list[Line2D]]:
    """The handles of each key."""
    legends = [*figure.legends, *(inner_legend for part in figure.subfigs for inner_legend in part.legends)]
    legends += [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
    return [[handle for handle in legend.legend_handles if isinstance(handle, Line2D)] for legend in legends]


def missing(figure: Figure, places: Sequence[Place], names: Sequence[str]) -> list[str]:
    """Names that no key, no panel's title and no tick has."""
    titles = {part.get_suptitle() for part in (figure, *figure.subfigs)}
    texts = [text for text, _ in places if text not in titles or len(names) == 1]
    whole = "\n".join([*texts, *(text.replace("\n", " ") for text in texts), *(t.replace("\n", "") for t in texts)])
    return [name for name in names if name not in whole]


def alike(figure: Figure) -> list[str]:
    """Handles of one key that look the same."""
    faults = []
    for handles in keys(figure):
        looks: dict[Any, str] = {}
        for key in handles:
            look = (key.get_color(), key.get_linestyle(), key.get_marker(), key.get_markerfacecolor(),
                    key.get_linewidth(), str(key._dash_pattern), key.get_markersize(), key.get_fillstyle())  # fmt: skip
            if look in looks:
                faults.append(f"{key.get_label()!r} and {looks[look]!r}")
            looks[look] = str(key.get_label())
    return faults


def alike_levels(figure: Figure) -> list[str]:
    """Lines across a panel at different levels, their signs apart, that look the same and have no words beside them."""
    faults = []
    for axes in panels(figure):
        named = {abs(text.xy[1]) for text in axes.texts if isinstance(text, Annotation)}
        levels: dict[Any, float] = {}
        for line in axes.get_lines():
            if line.get_transform() != axes.get_yaxis_transform() or line.get_linestyle() == "-":
                continue
            look, level = (line.get_color(), line.get_linewidth(), str(line._dash_pattern)), abs(line.get_ydata()[0])
            if level and level not in named and levels.setdefault(look, level) != level:
                faults.append(f"{levels[look]:g} and {level:g} in {_titles(axes)}")
    return faults


def hidden(figure: Figure) -> list[str]:
    """Lines that a later one of another colour covers: neither wider, nor is the later one broken."""
    faults = []
    for axes in panels(figure):
        lines = [line for line in axes.get_lines() if len(line.get_xdata()) > 1 and line.get_linestyle() != "None"]
        low, high = axes.get_ylim()
        for earlier, later in itertools.combinations(lines, 2):
            seen_through = later.get_linestyle() not in ("-", earlier.get_linestyle())
            if earlier.get_color() == later.get_color() or seen_through:
                continue
            if not np.array_equal(earlier.get_xdata(), later.get_xdata()):
                continue
            a, b = np.asarray(earlier.get_ydata(), float), np.asarray(later.get_ydata(), float)
            wider = earlier.get_linewidth() >= later.get_linewidth() + 1.0
            dots = earlier.get_marker() != "None" and earlier.get_markersize() >= later.get_markersize() + 1.0
            if np.allclose(a, b, rtol=0.0, atol=0.002 * abs(high - low)) and not (wider or dots):
                faults.append(f"{earlier.get_label()} under {later.get_label()} in {_titles(axes)}")
    return faults


def ordinal(figure: Figure) -> list[str]:
    """Axes whose ticks say numbers and do not stand at them. Grids of cells have one tick a level, wherever it is."""
    faults = []
    for axes in panels(figure):
        if axes.images or axes.name == "polar":
            continue
        for name in ("x", "y"):
            axis = getattr(axes, f"{name}axis")
            for label, at in zip(axis.get_ticklabels(), axis.get_ticklocs(), strict=False):
                value = number(label.get_text())
                if value is not None and abs(value - at) > 0.06 * abs(at) + 1e-9:
                    faults.append(f"{name} axis of {_titles(axes)}: {label.get_text()} at {at:g}")
    return faults
