"""Places of the panels of a video's frames, and ranges of data that they show."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from experiments.bench.video.pictures import Floats
from experiments.bench.video.reading import Reel, Trace
from scenes import ARENA_RADIUS_CM

LONGEST_WHOLE_S, WINDOW_S = 30.0, 20.0
"""Up to this length the traces' axis has all of a recording. Of a longer one it has the last seconds, and moves on."""
PLAIN_HEIGHT = 720
"""Height of a frame, in pixels, at which type and lines have their plain size."""
LEFT, RIGHT, BELOW = 78.0, 30.0, 50.0
"""Room about the traces for the numbers of their axes, at plain size."""
TOGETHER, ONE_ROW = 3, 4
"""Models that share a panel of potentials at most; of more each has one of its own, so many in one row."""
KEYS_A_ROW, KEY_ROW_PX = 7, 23.0
"""Sizes of the key above the panel of all potentials: entries in a row, and its height at plain size."""
BETWEEN, TITLE_PX = 54.0, 26.0
"""Room between the panels of two models, and above those in the second row."""
ROOM_CM = 7.0
"""Room about the robots of a plan that does not show the whole arena."""


@dataclass(frozen=True, slots=True)
class Panel:
    """A rectangle of the frame, and the range of data that it shows.

    Parameters
    ----------
    left, top, width, height
        In pixels, from the top left of the frame.
    x, y
        The data at the left and right edge, and at the bottom and top edge.
    """

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float] = (0.0, 1.0)
    y: tuple[float, float] = (0.0, 1.0)

    def pixels(self, x: Floats, y: Floats) -> npt.NDArray[np.float64]:
        """Return where data points are in the frame, (N, 2): column and row."""
        across = self.left + self.width * (np.asarray(x) - self.x[0]) / (self.x[1] - self.x[0])
        down = self.top + self.height * (self.y[1] - np.asarray(y)) / (self.y[1] - self.y[0])
        return np.column_stack([across, down])


@dataclass(frozen=True, slots=True)
class Layout:
    """Places of everything in a frame.

    Parameters
    ----------
    width, height
        Of the frame, in pixels.
    eyes
        A panel for each eye.
    plan
        The arena from above in cm, if robots were recorded.
    traces
        ``potential`` and ``spikes`` -> their panels, if there are such traces; of a panel for one model alone
        ``potential/MODEL``. Their x is the time in s, or that before now where they move on.
    moving
        Whether the traces' axes move on.
    scale
        Size of type and lines, 1 at `PLAIN_HEIGHT`.
    """

    width: int
    height: int
    eyes: tuple[Panel, ...]
    plan: Panel | None
    traces: Mapping[str, Panel]
    moving: bool
    scale: float


def lay_out(reel: Reel, aspects: Sequence[float], width: int, height: int) -> Layout:
    """Place the panels of a recording in a frame: eyes and plan above, traces below.

    Parameters
    ----------
    reel
        The recording.
    aspects
        Width over height of each eye's pictures.
    width, height
        Of the frame, in pixels.

    Returns
    -------
    Layout
        The panels.
    """
    scale = min(height / PLAIN_HEIGHT, width / 800)
    pad, head = 14.0 * scale, 38.0 * scale
    kinds = trace_kinds(reel)
    seen = bool(aspects) or bool(reel.tracks)
    top = (0.56 * height if kinds else height - pad) if seen else head
    eyes, plan = _upper(reel, aspects, (pad, head + 22 * scale, width - pad, top), scale)
    lower = trace_panels(reel, (LEFT * scale, top + 34 * scale, width - RIGHT * scale, height - BELOW * scale), scale)
    return Layout(width, height, eyes, plan, lower, moves_on(reel), scale)


def trace_kinds(reel: Reel) -> list[str]:
    """Return which of ``potential`` and ``spikes`` a recording has."""
    return [kind for kind in ("potential", "spikes") if any(trace.place == kind for trace in reel.traces)]


def moves_on(reel: Reel) -> bool:
    """Tell whether a recording is too long to show its traces whole."""
    return float(np.ptp(reel.time_s)) > LONGEST_WHOLE_S


def _upper(
    reel: Reel, aspects: Sequence[float], box: tuple[float, float, float, float], scale: float
) -> tuple[tuple[Panel, ...], Panel | None]:
    """Return the eyes side by side and the plan, which is square, as large as the box allows."""
    left, top, right, bottom = box
    every = [*aspects, *([1.0] if reel.tracks else [])]
    if not every:
        return (), None
    gap = 20.0 * scale
    high = min(bottom - top, (right - left - gap * (len(every) - 1)) / sum(every))
    across = left + (right - left - sum(every) * high - gap * (len(every) - 1)) / 2
    down = top + (bottom - top - high) / 2
    panels = []
    for aspect in every:
        panels.append(Panel(round(across), round(down), round(aspect * high), round(high)))
        across += aspect * high + gap
    plan = None
    if reel.tracks:
        place = panels.pop()
        x, y = ground(reel)
        plan = Panel(place.left, place.top, place.width, place.height, x, y)
    return tuple(panels), plan


def ground(reel: Reel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Find the square of ground in cm that a plan shows: an episode's whole arena, or what is near a trial's robots."""
    if "env" in reel.properties:
        half = ARENA_RADIUS_CM + 2.0
        return (-half, half), (-half, half)
    places = np.concatenate([track.poses[:, :2] for track in reel.tracks])
    middle, half = (places.max(0) + places.min(0)) / 2, float(np.ptp(places, axis=0).max()) / 2 + ROOM_CM
    return (middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)


def traces_of(reel: Reel, key: str) -> list[Trace]:
    """Return the traces of a panel: a key of `Layout.traces`."""
    kind, _, model = key.partition("/")
    return [trace for trace in reel.traces if trace.place == kind and model in ("", trace.model)]


def levels_of(reel: Reel, key: str) -> list[float]:
    """Return the thresholds of a panel: of potentials, those of its model where the recording tells whose they are."""
    kind, _, model = key.partition("/")
    if kind != "potential":
        return []
    return [level for level in reel.levels if not model or model in reel.owners.get(level, (model,))]


def apart(reel: Reel) -> bool:
    """Tell whether each model has panels of its own."""
    return len(reel.models) > TOGETHER


def key_rows(reel: Reel) -> int:
    """Tell how many rows the key above the panel of all potentials takes."""
    return 1 if apart(reel) else math.ceil((len(traces_of(reel, "potential")) + 1) / KEYS_A_ROW)


def trace_panels(reel: Reel, box: tuple[float, float, float, float], scale: float) -> dict[str, Panel]:
    """Place the traces' panels in a box (left, top, right, bottom), in pixels.

    Up to `TOGETHER` models share a panel of potentials, and each has a row for its spikes. Of more, each has both, in a
    grid of one row or two.
    """
    left, top, right, bottom = box
    if not apart(reel):
        top += (key_rows(reel) - 1) * KEY_ROW_PX * scale
        rows = list(reel.models) if len(reel.models) > 1 else [""]
        return _stacked(reel, "", rows, (left, top, right, bottom), scale)
    panels: dict[str, Panel] = {}
    down = 1 if len(reel.models) <= ONE_ROW else 2
    across = math.ceil(len(reel.models) / down)
    wide = (right - left - BETWEEN * scale * (across - 1)) / across
    high = (bottom - top - TITLE_PX * scale * (down - 1)) / down
    for place, model in enumerate(reel.models):
        row, column = divmod(place, across)
        start, head = left + column * (wide + BETWEEN * scale), top + row * (high + TITLE_PX * scale)
        panels |= _stacked(reel, f"/{model}", [model], (start, head, start + wide, head + high), scale)
    return panels


def _stacked(
    reel: Reel, whose: str, spiking: Sequence[str], box: tuple[float, float, float, float], scale: float
) -> dict[str, Panel]:
    """Return a panel of potentials, ``whose`` being the end of its key, above a panel for the spikes of each model."""
    left, top, right, bottom = box
    kinds = trace_kinds(reel)
    spikes = [f"spikes/{model}" if model else "spikes" for model in spiking]
    keys = [key for key in (f"potential{whose}", *spikes) if key.partition("/")[0] in kinds and traces_of(reel, key)]
    shares = {key: 0.68 if key.startswith("potential") else 0.32 / len(spikes) for key in keys}
    gap = (12.0 if len(spikes) == 1 and not whose else 5.0) * scale
    room = bottom - top - gap * (len(keys) - 1)
    x = (-WINDOW_S, 0.0) if moves_on(reel) else (float(reel.time_s[0]), float(reel.time_s[-1]) + 1e-6)
    panels = {}
    for key in keys:
        high = room * shares[key] / sum(shares.values())
        panels[key] = Panel(left, top, right - left, high, x, _range(reel, key))
        top += high + gap
    return panels


def _range(reel: Reel, key: str) -> tuple[float, float]:
    """Return the values that a panel shows: equal in all panels of a kind, but for potentials beyond -1 .. 1."""
    kind, _, model = key.partition("/")
    traces, every = traces_of(reel, key), traces_of(reel, kind)
    levels = levels_of(reel, key)
    if kind == "spikes":
        traces = every
    elif model and all(map(_bounded, traces)):
        traces, levels = [trace for trace in every if _bounded(trace)], list(reel.levels)
    values = [trace.values for trace in traces]
    low = min([float(np.nanmin(value)) for value in values] + [*levels, 0.0])
    high = max([float(np.nanmax(value)) for value in values] + [*levels, 0.0])
    if kind == "spikes":
        low, high = min(low, -1.0 if low < 0 else 0.0), max(high, 1.0)
    room = 0.08 * max(high - low, 0.1)
    return low - room, high + room


def _bounded(trace: Trace) -> bool:
    """Tell whether a potential stays where those of networks are: that of optic flow counts pixels."""
    return bool(np.nanmax(np.abs(trace.values)) <= 1.0)
