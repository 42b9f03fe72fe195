"""The figure of a run, drawn again from its tables."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
from matplotlib.figure import Figure

from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips.experiment import Figure as Drawing
from experiments.bench.core.errors import UsageError
from experiments.bench.core.figures.plotting import drawing
from experiments.bench.core.models import rebuilt
from experiments.bench.robot import figure as robot_figure
from experiments.bench.robot.mechanism import excitation, excitation_figure
from experiments.bench.robot.mechanism import figure as mechanism_figure
from experiments.bench.robot.mechanism.parts import NEEDED, WHOLE, without_parts
from experiments.bench.robot.rows import caption, drawable


def draw(folder: Path, said: Mapping[str, Any], trials: pa.Table, frames: pa.Table) -> Figure:
    """Draw the figure that the run's own command drew.

    Parameters
    ----------
    folder
        The run's, for messages.
    said
        Its ``experiment.json``.
    trials, frames
        Its tables.
    """
    declared, rows = said["experiment"], trials.to_pylist()
    if not isinstance(declared, Mapping):
        raise UsageError(f"{folder}: the figure of {declared} is not drawn from its tables; see the pictures there")
    if not rows:
        raise UsageError(f"{folder}: no trial of it is finished")
    try:
        if "clips" in declared:
            shown = [row for row in rows if row["repeat"] == 0]
            thresholds = {model["label"]: _threshold(model) for model in said["models"]}
            title = clips_figure.title(declared["name"], said["seed"], said.get("changed") or {})
            drawn = clips_figure.draw(Drawing(**declared["figure"]), shown, frames, thresholds, title)
        else:
            drawn = _of_robot(said, rows, frames)
    except (KeyError, TypeError, IndexError) as error:
        raise UsageError(f"{folder}: not the files of one run: {type(error).__name__}: {error}") from None
    setattr(drawn, "_repr_png_", lambda: _png(drawn))  # what notebooks look for  # noqa: B010
    return drawn


def _of_robot(said: Mapping[str, Any], rows: list[Any], frames: pa.Table) -> Figure:
    """The figure of trials with the robot."""
    declared, settings = said["experiment"], said["settings"]
    models = {model["label"]: model for model in settings["models"]}
    labels = list(models)
    name, arena, repeats = caption(declared["name"], settings["scene"]["arena"], said["repeats"], rows)
    blind = settings["robot"].get("open_loop", False)  # a run of an older version has no such setting
    changed = said.get("changed") or {}
    if declared["figure"] == "excitation" and set(NEEDED) <= set(models):
        found = excitation.courses(rows, frames, float(models[WHOLE]["network"]["w_i"]))
        if found:
            title = robot_figure.title(name, [WHOLE], arena, repeats, changed, blind)
            return excitation_figure.figure(found, title, _threshold(models[WHOLE]))
    title = robot_figure.title(name, labels, arena, repeats, changed, blind)
    thresholds = {label: _threshold(model) for label, model in models.items()}
    if drawable(declared["figure"], rows) == "mechanism":
        return mechanism_figure.figure(rows, declared["varies"], title, thresholds[labels[0]])
    shown = without_parts(rows) if declared["figure"] == "excitation" else rows
    return robot_figure.figure(shown, frames, declared["varies"], title, thresholds)


def _threshold(model: Mapping[str, Any]) -> float | None:
    """The threshold of a model as ``experiment.json`` tells of it; ``None`` where its file is gone, too."""
    try:
        return rebuilt(model["label"], model["source"], model["network"]).threshold
    except (UsageError, ValueError, TypeError):
        return None


def _png(drawn: Figure) -> bytes:
    made = io.BytesIO()
    with drawing():
        drawn.savefig(made, format="png", dpi=110)
    return made.getvalue()
