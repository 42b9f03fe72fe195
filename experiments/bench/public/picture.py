"""The figure of a run, drawn again from its tables."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
from matplotlib.figure import Figure

from dsnn.model import SPIKING
from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips.experiment import Figure as Drawing
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.terminal import error_console
from experiments.bench.figures.plotting import drawing
from experiments.bench.robot import figure as robot_figure
from experiments.bench.robot.mechanism import excitation, excitation_figure
from experiments.bench.robot.mechanism import figure as mechanism_figure
from experiments.bench.robot.mechanism.parts import NEEDED, WHOLE, without_parts
from experiments.bench.robot.rows import caption, drawable
from experiments.bench.store.description import stored_thresholds


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
            thresholds = _thresholds(folder, said, said["models"])
            title = clips_figure.title(declared["name"], said["seed"], said.get("changed") or {})
            drawn = clips_figure.draw(Drawing(**declared["figure"]), shown, frames, thresholds, title)
        else:
            drawn = _of_robot(folder, said, rows, frames)
    except (KeyError, TypeError, IndexError) as error:
        raise UsageError(f"{folder}: not the files of one run: {type(error).__name__}: {error}") from None
    setattr(drawn, "_repr_png_", lambda: _png(drawn))  # what notebooks look for  # noqa: B010
    return drawn


def _of_robot(folder: Path, said: Mapping[str, Any], rows: list[Any], frames: pa.Table) -> Figure:
    """The figure of trials with the robot."""
    declared, settings = said["experiment"], said["settings"]
    models = {model["label"]: model for model in settings["models"]}
    labels = list(models)
    name, arena, repeats = caption(declared["name"], settings["scene"]["arena"], said["repeats"], rows)
    thresholds = _thresholds(folder, said, settings["models"])
    blind = settings["robot"].get("open_loop", False)  # a run of an older version has no such setting
    changed = said.get("changed") or {}
    if declared["figure"] == "excitation" and set(NEEDED) <= set(models):
        found = excitation.courses(rows, frames, float(models[WHOLE]["network"]["w_i"]))
        if found:
            title = robot_figure.title(name, [WHOLE], arena, repeats, changed, blind)
            return excitation_figure.figure(found, title, thresholds[WHOLE])
    title = robot_figure.title(name, labels, arena, repeats, changed, blind)
    if drawable(declared["figure"], rows) == "mechanism":
        return mechanism_figure.figure(rows, declared["varies"], title, thresholds[labels[0]])
    shown = without_parts(rows) if declared["figure"] == "excitation" else rows
    return robot_figure.figure(shown, frames, declared["varies"], title, thresholds)


def _thresholds(folder: Path, said: Mapping[str, Any], models: Sequence[Mapping[str, Any]]) -> dict[str, float | None]:
    """The threshold of each model's counted channel, as ``experiment.json`` tells; no model's file is run for it."""
    found: dict[str, float | None] = {}
    for model in models:
        own = stored_thresholds(said, model)
        if own is None:
            why = f"experiment.json does not store the threshold of {model['label']}, and no file is run for it"
            note = f"note: {folder}: {why}: the figure has no line of it"
            error_console.print(note, soft_wrap=True, markup=False)
        found[model["label"]] = next((own[channel] for channel in SPIKING if channel in own), None) if own else None
    return found


def _png(drawn: Figure) -> bytes:
    made = io.BytesIO()
    with drawing():
        drawn.savefig(made, format="png", dpi=110)
    return made.getvalue()
