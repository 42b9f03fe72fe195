"""The figure of a run, drawn again from its tables."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pyarrow as pa
from matplotlib.figure import Figure

from experiments.bench.clips import figure as clips_figure
from experiments.bench.clips.experiment import Figure as Drawing
from experiments.bench.core.errors import UsageError
from experiments.bench.core.models import rebuilt
from experiments.bench.core.plotting import STYLE
from experiments.bench.robot import figure as robot_figure
from experiments.bench.robot.mechanism import figure as mechanism_figure


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
            drawn = clips_figure.draw(Drawing(**declared["figure"]), shown, frames, thresholds)
        else:
            settings = said["settings"]
            labels = [model["label"] for model in settings["models"]]
            blind = settings["robot"].get("open_loop", False)  # a run of an older version has no such setting
            title = robot_figure.title(
                declared["name"], labels, settings["scene"]["arena"], said["repeats"], open_loop=blind
            )
            threshold = _threshold(settings["models"][0])
            if declared["figure"] == "mechanism":
                drawn = mechanism_figure.figure(rows, declared["varies"], title, threshold)
            else:
                drawn = robot_figure.figure(rows, frames, declared["varies"], title, threshold)
    except (KeyError, TypeError, IndexError) as error:
        raise UsageError(f"{folder}: not the files of one run: {type(error).__name__}: {error}") from None
    setattr(drawn, "_repr_png_", lambda: _png(drawn))  # what notebooks look for  # noqa: B010
    return drawn


def _threshold(model: Mapping[str, Any]) -> float | None:
    """The threshold of a model as ``experiment.json`` tells of it; ``None`` where its file is gone, too."""
    try:
        return rebuilt(model["label"], model["source"], model["network"]).threshold
    except (UsageError, ValueError, TypeError):
        return None


def _png(drawn: Figure) -> bytes:
    made = io.BytesIO()
    with mpl.rc_context(STYLE):
        drawn.savefig(made, format="png", dpi=110)
    return made.getvalue()
