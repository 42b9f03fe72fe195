"""The figure of a run with the robot: which of the three it has, and its title."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pyarrow as pa
from matplotlib.figure import Figure

from experiments.bench.robot import figure as robot_figure
from experiments.bench.robot.mechanism import excitation_figure
from experiments.bench.robot.mechanism import figure as mechanism_figure
from experiments.bench.sources.experiment import Drawing
from experiments.bench.sources.rows import caption, drawable
from experiments.bench.stats.excitation import WHOLE, Course, without_parts
from experiments.bench.stats.judging import Rows


@dataclass(frozen=True, slots=True)
class RunFigure:
    """The figure of a run, with what it needs beside the run's rows.

    Parameters
    ----------
    drawing
        The kind of figure that the experiment declares.
    name, arena, repeats
        Of the run, as it was planned.
    varies
        The column along the axes.
    thresholds
        Label of each model, the first one first -> its spiking threshold; ``None``: it does not spike.
    changed
        The parameters that are not at their defaults.
    open_loop
        Whether the robots' wheels were driven open loop.
    """

    drawing: Drawing
    name: str
    arena: str
    repeats: int
    varies: str
    thresholds: Mapping[str, float | None]
    changed: Mapping[str, Any]
    open_loop: bool

    def draw(self, rows: Rows, frames: Callable[[], pa.Table], courses: Sequence[Course] = ()) -> Figure:
        """Draw the figure.

        Parameters
        ----------
        rows
            Of ``trials.parquet``.
        frames
            Reads ``frames.parquet``, which one of the three figures needs.
        courses
            Excitation and inhibition in each condition; without any the figure is another than that of excitation.

        Returns
        -------
        matplotlib.figure.Figure
            Of ``figure.svg``.
        """
        name, arena, repeats = caption(self.name, self.arena, self.repeats, rows)
        labels = [WHOLE] if courses else list(self.thresholds)
        title = robot_figure.title(name, labels, arena, repeats, self.changed, self.open_loop)
        if courses:
            if others := [label for label in self.thresholds if label.partition(":")[0] != WHOLE]:
                title += f"\nof {WHOLE} alone, so not drawn: {', '.join(others)}"
            return excitation_figure.figure(courses, title, self.thresholds[WHOLE])
        if drawable(self.drawing, rows) == "mechanism":
            return mechanism_figure.figure(rows, self.varies, title, self.thresholds[labels[0]])
        drawn_rows = without_parts(rows) if self.drawing == "excitation" else rows
        return robot_figure.figure(drawn_rows, frames(), self.varies, title, self.thresholds)
