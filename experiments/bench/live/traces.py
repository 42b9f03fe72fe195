"""The running traces of the page: HS and VS against T, and spikes, in the colours of the figures."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import viser
from viser import uplot

from dsnn.model import SPIKING
from experiments.bench.live.session import Session, View
from experiments.bench.report.palette import marks
from experiments.bench.run.record import mixed, rgb, to_hex

SHOWN_FRAMES = 180
"""Frames of the running traces."""
GREY, GHOST = "#8c8c8c", "#b9a88a"
LIGHTER = 0.5
"""Share of white in the colours on a dark page: the darkest hues could not be told from it."""
LEAST_HS, LEAST_SPIKES = 0.3, 2.0
"""The least ends of the two scales."""
ENDS = (1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0)
DASHES: dict[str, list[float]] = {"hs": [], "vs": [6, 4], "looming": [2, 3]}
Floats = npt.NDArray[np.float64]


class Traces:
    """The two plots.

    Attributes
    ----------
    dark
        Whether the page is dark; `paint` colours the traces for it.

    Parameters
    ----------
    gui
        Where they are added.
    session
        Whose models are shown; other models need other plots.
    dark
        Whether the page is dark.
    """

    def __init__(self, gui: viser.GuiApi, session: Session, dark: bool) -> None:
        self._session, self.dark = session, dark
        models = [runner.chosen for runner in session.watching]
        self._x = (np.arange(SHOWN_FRAMES) - SHOWN_FRAMES + 1) * session.interval_s
        blank = [0.0] * SHOWN_FRAMES
        self._potentials = {
            (model.label, channel): deque(blank, SHOWN_FRAMES)
            for model in models for channel in [c for c in DASHES if c in model.channels] or model.channels
        }  # fmt: skip
        self._spikes = {
            (model.label, channel): deque(blank, SHOWN_FRAMES)
            for model in models for channel in SPIKING if channel in model.channels
        }  # fmt: skip
        self._limits = self._thresholds()
        self._ghost: Floats | None = None
        axes = (uplot.Axis(stroke=GREY), uplot.Axis(stroke=GREY))
        shared: dict[str, Any] = {"axes": axes, "legend": uplot.Legend(live=False), "padding": (12, 16, 0, 0)}
        lines, counts = self._series()
        self._ends, self._redrawn = (LEAST_HS, LEAST_SPIKES), 0
        hs, spikes = self._scales()
        self._plots = (
            gui.add_uplot(self._curves(), lines, scales=hs, height=195, **shared),
            gui.add_uplot(self._counts(), counts, scales=spikes, height=120, **shared),
        )

    def _thresholds(self) -> list[float]:
        """Return T and -T of the models, by their parameters as they are now."""
        now = (replace(runner.chosen, network=runner.network).threshold for runner in self._session.watching)
        return [sign * limit for limit in dict.fromkeys(now) if limit is not None for sign in (1, -1)]

    def _series(self) -> tuple[tuple[uplot.Series, ...], tuple[uplot.Series, ...]]:
        looks = marks(runner.label for runner in self._session.watching)
        colour = {label: on_dark(mark.colour) if self.dark else mark.colour for label, mark in looks.items()}
        x = uplot.Series(label="s")
        ghost = [uplot.Series(label="before", stroke=GHOST, width=2)] if self._ghost is not None else []
        lines = [
            uplot.Series(
                label=f"{label} {channel.upper()}", stroke=colour[label], width=2, dash=DASHES.get(channel, [])
            )
            for label, channel in self._potentials
        ]
        limits = [
            uplot.Series(label=f"T = {limit:g}" if limit > 0 else "-T", stroke=GREY, width=1, dash=[3, 3])
            for limit in self._limits
        ]
        counts = [
            uplot.Series(
                label=f"{label} {channel.upper()} spikes", stroke=colour[label], width=2, dash=DASHES[channel],
                fill=f"{colour[label]}40",
            )
            for label, channel in self._spikes
        ]  # fmt: skip
        return (x, *ghost, *lines, *limits), (x, *counts)

    def _scales(self) -> tuple[dict[str, uplot.Scale], dict[str, uplot.Scale]]:
        x, (hs, spikes) = uplot.Scale(time=False, range=(float(self._x[0]), 1e-6 * (self._redrawn % 2))), self._ends
        return {"x": x, "y": uplot.Scale(range=(-hs, hs))}, {"x": x, "y": uplot.Scale(range=(-spikes, spikes))}

    def _curves(self) -> tuple[Floats, ...]:
        ghost = [] if self._ghost is None else [self._ghost]
        limits = [np.full(SHOWN_FRAMES, limit) for limit in self._limits]
        return (self._x, *ghost, *map(np.array, self._potentials.values()), *limits)

    def _counts(self) -> tuple[Floats, ...]:
        return (self._x, *map(np.array, self._spikes.values()))

    def add(self, view: View) -> None:
        """Draw the answers to a frame."""
        for (label, channel), trace in self._potentials.items():
            answer = view.answers[label]
            trace.append(0.0 if answer is None else getattr(answer, channel))
        for (label, channel), trace in self._spikes.items():
            answer = view.answers[label]
            trace.append(0.0 if answer is None else getattr(answer, f"{channel}_spikes"))
        if (limits := self._thresholds()) != self._limits:
            self._limits = limits
            self.paint()
        curves, counts = self._curves(), self._counts()
        fitting = _end(curves[1:], LEAST_HS), _end(counts[1:], LEAST_SPIKES)
        if fitting != self._ends:
            self._ends = fitting
            self.redraw()
        for plot, data in zip(self._plots, (curves, counts), strict=True):
            plot.data = data

    def redraw(self) -> None:
        """Let browsers draw the plots anew, on scales that are not equal to those before."""
        self._redrawn += 1
        for plot, scales in zip(self._plots, self._scales(), strict=True):
            plot.scales = scales

    def freeze(self) -> None:
        """Keep the present trace of the first model's first channel as a ghost behind the others."""
        if self._potentials:
            self._ghost = np.array(next(iter(self._potentials.values())))
            self.paint()

    def paint(self) -> None:
        """Colour the traces for a light or a dark page."""
        curves = self._curves(), self._counts()
        for plot, data, series in zip(self._plots, curves, self._series(), strict=True):
            plot.data, plot.series = data, series

    def remove(self) -> None:
        """Take the plots off the page."""
        for plot in self._plots:
            plot.remove()


def on_dark(colour: str) -> str:
    """Return a colour ``#rrggbb`` with `LIGHTER` of white in it."""
    return to_hex(mixed(rgb(colour), (255, 255, 255), LIGHTER))


def _end(curves: Iterable[Floats], least: float) -> float:
    """Return the end of a scale that has all curves: one of `ENDS` times a power of ten."""
    most = max((float(np.abs(curve).max()) for curve in curves), default=0.0)
    if most <= least:
        return least
    power = 10.0 ** math.floor(math.log10(most))
    return next(end for factor in ENDS if (end := factor * power) >= most)
