"""Look of the series of a recording's plots: a colour a model, lines and dots for its channels, thresholds by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import rerun as rr

from dsnn.model import SPIKING
from experiments.bench.figures.palette import colours

LIMIT_COLOUR = (140, 140, 140)
Colour = tuple[int, int, int]
LINE_WIDTH, DOT_SIZE = 1.5, 2.0
"""Width of series, in points of the screen."""
DOTS = {
    "hs": rr.components.MarkerShape.Square,
    "vs": rr.components.MarkerShape.Circle,
    "looming": rr.components.MarkerShape.Up,
}
"""Channel -> its dots, where another channel of the same model has the line."""
SHADES = {"hs": 255, "vs": 255, "looming": 0}
"""Channel -> the grey that its dots' colour is mixed with: white, or black."""
SHADE = 0.45
"""Share of that grey."""
OWNERS = "models"
"""The component of a threshold that lists its models: `Level.owners`."""
MOST_NAMED = 3
"""Models that the name of a threshold lists."""


@dataclass(frozen=True, slots=True)
class Line:
    """A series of a recording's plots.

    Parameters
    ----------
    entity, title
        Where it is logged, and what the plot's key calls it.
    field
        The `dsnn.Response` field that it shows.
    colour, width
        Those of its model: figures have markers, for which a recording has widths.
    dots
        The shape of its dots; ``None``: it is a line.
    """

    entity: str
    title: str
    field: str
    colour: Colour
    width: float
    dots: rr.components.MarkerShape | None = None

    def style(self) -> rr.SeriesLines | rr.SeriesPoints:
        """Return how a viewer draws it."""
        if self.dots is None:
            return rr.SeriesLines(colors=self.colour, names=self.title, widths=self.width)
        size = DOT_SIZE * self.width / LINE_WIDTH
        return rr.SeriesPoints(colors=self.colour, names=self.title, markers=self.dots, marker_sizes=size)


def rgb(colour: str) -> Colour:
    """Return ``#rrggbb`` as three numbers from 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def lines(model: str, channels: Sequence[str], models: Sequence[str]) -> list[Line]:
    """Return the series of a model's declared channels.

    A model has one colour, that of the figures. Its first spiking channel is a line, the others are dots in lighter
    (VS) and darker (looming) shades of the colour.

    Parameters
    ----------
    model
        Its label.
    channels
        Those that it declares.
    models
        The labels of all models of the recording. Titles name the model where there are several.
    """
    tints = colours(models)
    earlier = list(tints)[: list(tints).index(model)]
    turn = sum(tints[other] == tints[model] for other in earlier)
    colour, width = rgb(tints[model]), LINE_WIDTH * (1 + turn)
    name, prefix = rr.escape_entity_path_part(model), f"{model} " if len(models) > 1 else ""
    first = next((channel for channel in channels if channel in SPIKING), "")
    series = []
    for channel in channels:
        title = prefix + _said(channel)
        if channel not in SPIKING:
            series.append(Line(f"{channel}/{name}", title, channel, colour, width))
            continue
        dots, tone = (None, colour) if channel == first else (DOTS[channel], _shade(colour, SHADES[channel]))
        series.append(Line(f"potential/{name}/{channel}", title, channel, tone, width, dots))
        series.append(Line(f"spikes/{name}/{channel}", f"{title} spikes", f"{channel}_spikes", tone, width, dots))
    return series


def _shade(colour: Colour, grey: int) -> Colour:
    red, green, blue = (round((1 - SHADE) * part + SHADE * grey) for part in colour)
    return red, green, blue


def _said(channel: str) -> str:
    return channel.upper() if channel in ("hs", "vs") else channel


@dataclass(frozen=True, slots=True)
class Level:
    """A line at a threshold.

    Parameters
    ----------
    value
        On the potential.
    title
        Says whose threshold it is.
    models
        The labels of all models whose it is.
    """

    value: float
    title: str
    models: tuple[str, ...] = ()

    @property
    def entity(self) -> str:
        """Return where it is logged."""
        sign = "plus" if self.value > 0 else "minus"
        return f"potential/threshold/{sign}_{abs(self.value):g}".replace(".", "_")

    def style(self) -> rr.SeriesLines:
        """Return how a viewer draws it."""
        return rr.SeriesLines(colors=LIMIT_COLOUR, names=self.title, widths=1.0)

    def owners(self) -> rr.AnyValues:
        """Return what tells a reader of the recording whose it is: the title names some models alone."""
        return rr.AnyValues(models=list(self.models))


def levels(thresholds: Mapping[str, Mapping[str, float | None]]) -> list[Level]:
    """Return the thresholds to draw, lowest first: of either sign for HS and VS, of looming the positive one alone.

    Parameters
    ----------
    thresholds
        Model -> channel -> its threshold. Equal ones are one line, which names their models.
    """
    signs = {"hs": (1, -1), "vs": (1, -1), "looming": (1,)}
    owners: dict[float, dict[str, list[str]]] = {}
    for model, channels in thresholds.items():
        for channel, level in channels.items():
            if channel in signs and level is not None:
                for sign in signs[channel]:
                    owners.setdefault(sign * level, {}).setdefault(model, []).append(channel)
    return [Level(value, _whose(value, owners[value], thresholds), tuple(owners[value])) for value in sorted(owners)]


def _whose(
    value: float, owners: Mapping[str, Sequence[str]], thresholds: Mapping[str, Mapping[str, float | None]]
) -> str:
    """Say whose threshold it is: models, and their channels where these have several thresholds."""
    names = []
    for model, channels in owners.items():
        several = len({level for level in thresholds[model].values() if level is not None}) > 1
        names.append(f"{model} ({', '.join(map(_said, channels))})" if several else model)
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return f"{'' if value > 0 else '-'}T = {abs(value):g} of {', '.join(names[:MOST_NAMED])}{more}"
