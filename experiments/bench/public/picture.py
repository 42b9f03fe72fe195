"""The figure of a run, drawn again from its tables."""

from __future__ import annotations

import io
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from dsnn.model import SPIKING
from experiments.bench.figures.plotting import drawing
from experiments.bench.report import behaviours as behaviours_figure
from experiments.bench.report import clips as clips_figure
from experiments.bench.report import robot as robot_figure
from experiments.bench.run.errors import UsageError
from experiments.bench.sources import excitation
from experiments.bench.sources.clips import Figure as Drawing
from experiments.bench.sources.excitation import NEEDED, WHOLE
from experiments.bench.sources.rows import drawable
from experiments.bench.store.description import THRESHOLDS
from experiments.bench.store.kinds import CLIPS, EPISODES, MEASURED, TRIALS, Kind
from scenes import arena_name

if TYPE_CHECKING:
    from experiments.bench.store.record import Record


def draw(run: Record) -> Figure:
    """Draw the figure that the run's own command drew; `UsageError` where it is not drawn from the tables."""
    drawer = _DRAWERS.get(run.kind)
    if drawer is None:
        raise UsageError(
            f"{run.folder}: the figure of {run.kind.what} is not drawn from its tables; see the pictures there"
        )
    rows = run.trials.to_dicts()
    if not rows:
        raise UsageError(f"{run.folder}: no trial of it is finished")
    try:
        drawn = drawer(run, rows)
    except (KeyError, TypeError, IndexError) as error:
        raise UsageError(f"{run.folder}: not the files of one run: {type(error).__name__}: {error}") from None
    setattr(drawn, "_repr_png_", lambda: _png(drawn))  # what notebooks look for  # noqa: B010
    return drawn


def _of_clips(run: Record, rows: list[Any]) -> Figure:
    """Return the figure of clips."""
    declared = run.description["experiment"]
    thresholds = _thresholds(run, run.description["models"])
    title = clips_figure.title(declared["name"], run.description["seed"], run.description.get("changed") or {})
    return clips_figure.draw(Drawing(**declared["figure"]), run.trials, run.frames, thresholds, title)


def _of_robot(run: Record, rows: list[Any]) -> Figure:
    """Return the figure of trials with the robot."""
    declared, settings = run.description["experiment"], run.description["settings"]
    models = {model["label"]: model for model in settings["models"]}
    courses = []
    if declared["figure"] == "excitation" and set(NEEDED) <= set(models):
        courses = excitation.courses(rows, run.frames, float(models[WHOLE]["network"]["w_i"]))
    changed = run.description.get("changed") or {}
    title = robot_figure.title(declared["name"], arena_name(settings["scene"]["arena"]), rows, changed,
                               open_loop=settings["robot"]["open_loop"])  # fmt: skip
    return robot_figure.draw(drawable(declared["figure"], rows), rows, run.frames, declared["varies"],
                             _thresholds(run, settings["models"]), title, excitation.table(courses))  # fmt: skip


def _of_episodes(run: Record, rows: list[Any]) -> Figure:
    """Return the figure of behaviours."""
    told = run.description
    caption = behaviours_figure.caption(told["env"], told["options"], told["episodes"], told["seed"])
    return behaviours_figure.of_episodes(run.trials, run.frames, caption)


_DRAWERS: Mapping[Kind, Callable[[Record, list[Any]], Figure]] = {
    TRIALS: _of_robot, MEASURED: _of_robot, CLIPS: _of_clips, EPISODES: _of_episodes,
}  # fmt: skip
"""How the figure of a kind is drawn from its tables."""


def _thresholds(run: Record, models: Sequence[Mapping[str, Any]]) -> dict[str, float | None]:
    """Read the threshold of each model's counted channel, as ``run.json`` tells; no model's file is run."""
    stored = {model["label"]: run.description[THRESHOLDS][model["label"]] for model in models}
    return {
        label: next((levels[channel] for channel in SPIKING if channel in levels), None)
        for label, levels in stored.items()
    }


def _png(drawn: Figure) -> bytes:
    buffer = io.BytesIO()
    with drawing():
        drawn.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()
