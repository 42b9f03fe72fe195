"""Look of the series of a recording's plots: a colour a model, lines and dots for its channels, thresholds by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import rerun as rr

from dsnn.model import SPIKING
from experiments.bench.figures.palette import colours

LIMIT_COLOUR = (140, 140, 140)
THRESHOLD = "threshold/"
"""Where thresholds are logged, each model's below its name."""
CHANNELS_OF = "channels"
"""The component of a threshold that lists the channels whose it is, as `Level.owners` has it."""
Colour = tuple[int, int, int]
LINE_WIDTH, DOT_SIZE, MARK_SIZE = 1.5, 2.0, 3.0
"""Width of series, of their dots, and of the marks of spikes, in points of the screen."""
DOTS = {
    "hs": rr.components.MarkerShape.Square,
    "vs": rr.components.MarkerShape.Circle,
    "looming": rr.components.MarkerShape.Up,
}
"""Channel -> its dots, where another channel of the same model has the line."""
DOT_NAMES = {"hs": "squares", "vs": "dots", "looming": "triangles"}
"""Channel -> what its dots are called."""
SHADES = {"hs": 255, "vs": 255, "looming": 0}
"""Channel -> the grey that its dots' colour is mixed with: white, or black."""
SHADE = 0.45
"""Share of that grey."""
LEVEL_SHADE = 0.35
"""Share of white in the colour of a threshold: it is its model's, and lighter than the potential."""
TOP, ROW = 1.05, 0.16
"""Largest potential in a lane, and the distance of the rows of spikes beyond it, above and below."""
ON, OFF, STILL = (255, 138, 31), (66, 158, 255), (24, 26, 32)
"""Colours of brighter, darker and unchanged pixels: warm, cool and dark."""


@dataclass(frozen=True, slots=True)
class Line:
    """A series of a recording: a potential, an azimuth, the number of spikes of each frame, or the marks of spikes.

    Parameters
    ----------
    entity, title
        Where it is logged, and what the plot's key calls it.
    field
        The `dsnn.Response` field that it shows; of marks, the field that says where there are spikes.
    colour
        Its model's, which has a lane to itself.
    dots
        The shape of its dots; ``None``: it is a line.
    row
        Height in the lane of the marks of positive spikes, those of negative ones are as far below 0; ``None``: the
        series has the values of its field.
    shown
        Whether a view draws it. The number of spikes of each frame is there to be read.
    """

    entity: str
    title: str
    field: str
    colour: Colour
    dots: rr.components.MarkerShape | None = None
    row: float | None = None
    shown: bool = True

    def style(self) -> rr.SeriesLines | rr.SeriesPoints:
        """Return how a viewer draws it."""
        if self.dots is None:
            return rr.SeriesLines(colors=self.colour, names=self.title, widths=LINE_WIDTH)
        size = DOT_SIZE if self.row is None else MARK_SIZE
        return rr.SeriesPoints(colors=self.colour, names=self.title, markers=self.dots, marker_sizes=size)


def rgb(colour: str) -> Colour:
    """Return ``#rrggbb`` as three numbers from 0 to 255."""
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)


def to_hex(colour: Colour) -> str:
    """Return three numbers from 0 to 255 as ``#rrggbb``."""
    return "#{:02x}{:02x}{:02x}".format(*colour)


def lines(model: str, channels: Sequence[str], models: Sequence[str]) -> list[Line]:
    """Return the series of a model's declared channels.

    A model has one colour, that of the figures. Its first spiking channel is a line, the others are dots in lighter
    (VS) and darker (looming) shades of the colour. A channel has its potential, its spikes per frame, and marks where
    there are spikes: of preferred motion (right, down) above the potentials, of null motion below them.

    Parameters
    ----------
    model
        Its label.
    channels
        Those that it declares.
    models
        The labels of all models of the recording. Titles name the model where there are several.
    """
    colour = rgb(colours(models)[model])
    name, prefix = rr.escape_entity_path_part(model), f"{model} " if len(models) > 1 else ""
    first = next((channel for channel in channels if channel in SPIKING), "")
    series = []
    for channel in channels:
        title = prefix + _name(channel)
        if channel not in SPIKING:
            series.append(Line(f"{channel}/{name}", title, channel, colour))
            continue
        dots, tone = (None, colour) if channel == first else (DOTS[channel], _shade(colour, SHADES[channel]))
        series.append(Line(f"potential/{name}/{channel}", title, channel, tone, dots))
        field, row = f"{channel}_spikes", _row(channel, channels)
        series.append(Line(f"spikes/{name}/{channel}", f"{title} spikes", field, tone, dots, shown=False))
        series.append(Line(f"raster/{name}/{channel}", f"{title} spikes", field, tone, DOTS[channel], row))
    return series


def _row(channel: str, channels: Sequence[str]) -> float:
    """Return the height of the marks of a channel's positive spikes: those of the first are the lowest."""
    return TOP + ROW * (0.5 + [known for known in channels if known in SPIKING].index(channel))


def ends(channels: Sequence[str]) -> tuple[float, float]:
    """Return the lower and the upper end of the lane of a model with these channels.

    Beyond all potentials there is a row of spikes for each channel. Looming has no direction, so nothing below 0.
    """
    spiking = [channel for channel in channels if channel in SPIKING]
    end = TOP + ROW * max(len(spiking), 1)
    return -0.05 if spiking == ["looming"] else -end, end


def _shade(colour: Colour, grey: int, share: float = SHADE) -> Colour:
    return mixed(colour, (grey, grey, grey), share)


def mixed(colour: Colour, other: Colour, share: float) -> Colour:
    """Return a colour with a ``share`` of another in it."""
    red, green, blue = (round((1 - share) * part + share * more) for part, more in zip(colour, other, strict=True))
    return red, green, blue


def _name(channel: str) -> str:
    return channel.upper() if channel in ("hs", "vs") else channel


@dataclass(frozen=True, slots=True)
class Level:
    """A line at a threshold of a model.

    Parameters
    ----------
    model
        The model's label.
    value
        On the potential.
    channels
        The channels of the model whose threshold it is.
    colour
        The model's, lighter.
    """

    model: str
    value: float
    channels: tuple[str, ...]
    colour: Colour

    @property
    def entity(self) -> str:
        """Return where it is logged."""
        sign = "plus" if self.value > 0 else "minus"
        size = f"{abs(self.value):g}".replace(".", "_")
        return f"{THRESHOLD}{rr.escape_entity_path_part(self.model)}/{sign}_{size}"

    def style(self) -> rr.SeriesLines:
        """Return how a viewer draws it."""
        title = f"threshold {self.value:g} of {self.model} ({', '.join(map(_name, self.channels))})"
        return rr.SeriesLines(colors=self.colour, names=title, widths=1.0)

    def owners(self) -> rr.AnyValues:
        """Return what tells a reader of the recording which channels it is of."""
        return rr.AnyValues(channels=list(self.channels))


def levels(thresholds: Mapping[str, Mapping[str, float | None]]) -> list[Level]:
    """Return the thresholds to draw, of each model the lowest first.

    Parameters
    ----------
    thresholds
        Model -> channel -> its threshold: of HS and VS it counts with either sign, of looming the positive one alone.
    """
    signs, tints = {"hs": (1, -1), "vs": (1, -1), "looming": (1,)}, colours(thresholds)
    drawn = []
    for model, channels in thresholds.items():
        of_value: dict[float, list[str]] = {}
        for channel, level in channels.items():
            if channel in signs and level is not None:
                for sign in signs[channel]:
                    of_value.setdefault(sign * level, []).append(channel)
        colour = _shade(rgb(tints[model]), 255, LEVEL_SHADE)
        drawn += [Level(model, value, tuple(of_value[value]), colour) for value in sorted(of_value)]
    return drawn


def heading(
    model: str, channels: Sequence[str], thresholds: Mapping[str, float | None], *, narrow: bool = False
) -> str:
    """Return the heading of a model's lane, which does the work of a legend: one would cover the traces.

    Parameters
    ----------
    model
        Its label.
    channels
        Those that it declares.
    thresholds
        Channel -> its threshold.
    narrow
        Whether there is room for the name and the thresholds alone, as in lanes in many columns.
    """
    spiking = [channel for channel in channels if channel in SPIKING]
    shapes = ["line", *(DOT_NAMES[channel] for channel in spiking[1:])]
    series = ", ".join(f"{_name(channel)} ({shape})" for channel, shape in zip(spiking, shapes, strict=False))
    words = [] if narrow else [series]
    of_value: dict[float, list[str]] = {}
    for channel in spiking:
        if (level := thresholds.get(channel)) is not None:
            of_value.setdefault(level, []).append(channel)
    for level, owners in of_value.items():
        sign = "" if owners == ["looming"] else "±"
        words.append(
            f"threshold {sign}{level:.3g}" + (f" of {', '.join(map(_name, owners))}" if len(of_value) > 1 else "")
        )
    if of_value and not narrow:
        words.append("spikes on top" if spiking == ["looming"] else "spikes on top (right, down), below (left, up)")
    return f"{model}: {'; '.join(words)}" if words else model
