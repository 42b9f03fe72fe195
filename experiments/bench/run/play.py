"""Play a trial: show each frame of its sources to every model, and tabulate what they respond."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import cv2
import numpy as np
import numpy.typing as npt
import polars as pl
from threadpoolctl import threadpool_limits

from dsnn import Response, ResponseSeries
from dsnn.frames import frozen
from experiments.bench.run.errors import TrialError
from experiments.bench.run.model_runner import ModelRunner, change, spike_counts
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.store.rows import Failure, FrameRow, ResponseRow, TrialRecord, recording_of, schema_of

FRAMES = schema_of(FrameRow, ResponseRow)
"""Columns of ``frames.parquet``: a row per frame and model."""
FIELDS = tuple(ResponseRow.__annotations__)
"""Fields of a `dsnn.ResponseSeries`, as the rows of frames have them."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One frame of a source, and what is true of it.

    Parameters
    ----------
    time_s
        Time of the frame since the trial began, s.
    image
        The frame, (R, C) uint8.
    truth
        What is true of it, by name: poses, the motion shown, the outline of the object.
    changes
        Parameters that models have from this frame on: model -> parameter -> text. They begin anew, from rest.
    """

    time_s: float
    image: npt.NDArray[np.uint8]
    truth: Mapping[str, Any]
    changes: Mapping[str, Mapping[str, str]] = field(default_factory=dict)


class Source(Protocol):
    """Frames that models are shown in one trial: a clip of a stimulus, a trial with the robot before one eye.

    ``fps`` is its rate in 1/s, ``shape`` (R, C) that of a frame in px. ``frame_columns`` are those of
    ``frames.parquet``: `FRAMES`, and those of the truth that are kept.
    """

    fps: float
    shape: tuple[int, int]
    frame_columns: pl.Schema

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames in order of time, always the same ones."""
        ...

    def columns(self) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``."""
        ...

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return measures of one model's responses, as columns of ``trials.parquet``.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame: the fields of `dsnn.ResponseSeries`, and of the samples' truth.
        """
        ...


@dataclass(frozen=True, slots=True)
class Trial:
    """One trial, wholly determined: `play` is a pure function of it.

    Parameters
    ----------
    experiment
        Name of the experiment.
    index
        Number of the trial in the run.
    repeat
        Number of the repeat of the condition.
    seed
        Seed of every random draw.
    condition
        What is shown. Its ``label()`` is its name in tables, its ``open(seed)`` the source of the frames.
    models
        The models that it is shown to.
    """

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Any
    models: tuple[ConfiguredModel, ...]

    def sources(self) -> Iterable[tuple[str, Source, Sequence[ConfiguredModel]]]:
        """Open the source of each eye: its name, empty for the only one, and the models that see by it."""
        yield "", self.condition.open(self.seed), self.models

    def frame_rates(self) -> Iterable[tuple[ConfiguredModel, float]]:
        """Return each model with the rate of the frames that it is shown, 1/s."""
        rate = self.condition.open(self.seed).fps
        return ((model, rate) for model in self.models)


class Showing:
    """Frames that a source has shown so far, and the models that respond to them. Iterating shows one more.

    A model that raises loses its own responses alone.

    Attributes
    ----------
    runners
        The models.
    samples
        The frames so far, where ``keep`` is set.
    responses
        What each model responded to the last frame; ``None`` of one that raised.

    Parameters
    ----------
    source, eye
        The frames, and the name of the eye that sees them.
    models
        The models.
    keep
        Whether frames and responses are kept; a trial by hand may be endless.
    """

    def __init__(self, source: Source, models: Sequence[ConfiguredModel], eye: str = "", *, keep: bool = True) -> None:
        self.source: Any = source
        self.eye, self._keep = eye, keep
        self.runners = [ModelRunner(model, source.shape, keep=keep) for model in models]
        self.samples: list[Sample] = []
        self.responses: list[Response | None] = []

    def __iter__(self) -> Iterator[Sample]:
        for sample in self.source:
            for model, values in sample.changes.items():
                change(self.runners, model, values)
            image = frozen(sample.image)
            self.responses = [runner.see(image) for runner in self.runners]
            if self._keep:
                self.samples.append(sample)
            yield sample

    def series(self) -> list[tuple[ConfiguredModel, ResponseSeries]]:
        """Return each model that responded to every frame, with its responses."""
        return [(runner.chosen, series) for runner in self.runners if (series := runner.series()) is not None]

    def troubles(self) -> dict[str, str]:
        """Return the label of each model that raised, with its traceback."""
        return {runner.label: runner.trouble for runner in self.runners if runner.trouble}

    def truth(self, first: int = 0) -> pl.DataFrame:
        """Return what is true of the frames from the ``first`` on, a row each."""
        shown = self.samples[first:]
        return pl.DataFrame({name: [sample.truth[name] for sample in shown] for name in shown[0].truth}, strict=False)


Watch = Callable[[Showing], None]
"""Watcher of a trial, such as a viewer: called after each frame, and changes nothing."""
Record = Callable[[Any, Sequence[Showing], Sequence[Mapping[str, Any]]], bytes]
"""Writes the recording of a trial from what it showed and its rows, as the bytes of an .rrd file."""


def show(trial: Trial, *, maps: bool = False, watch: Watch | None = None) -> list[Showing]:
    """Show the frames of a trial to its models, eye by eye, on one thread.

    Parameters
    ----------
    trial
        The trial.
    maps
        Whether the first model's layer maps are kept.
    watch
        Watches it.

    Raises
    ------
    TrialError
        Every model raised; it has their tracebacks. Or the trial itself could not be completed.
    """
    cv2.setNumThreads(1)  # the cores are the workers': more threads cost a second core for a sixth of the time
    showings = []
    with threadpool_limits(1):
        for eye, source, models in trial.sources():
            showing = Showing(source, models, eye)
            showing.runners[0].maps = maps and models[0] is trial.models[0]
            for _ in showing:
                if watch:
                    watch(showing)
            showings.append(showing)
    if not any(showing.series() for showing in showings):
        troubles = {label: text for showing in showings for label, text in showing.troubles().items()}
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    return showings


def play(
    trial: Trial, record: Record | None = None, *, frames: bool = True, maps: bool = False, watch: Watch | None = None
) -> TrialRecord:
    """Play one trial.

    Parameters
    ----------
    trial
        The trial.
    record
        Writes its recording.
    frames
        Whether to keep a row per frame and model.
    maps, watch
        As of `show`.

    Returns
    -------
    TrialRecord
        A row per model, the rows of frames, the recording, and the models that failed.

    Raises
    ------
    TrialError
        As of `show`.
    """
    began_s = time.perf_counter()
    showings = show(trial, maps=maps, watch=watch)
    wall_s = time.perf_counter() - began_s
    done = tabulate(trial, showings, wall_s, frames=frames)
    return replace(done, recording=recording_of(lambda: record(trial, showings, done.rows))) if record else done


def tabulate(trial: Trial, showings: Sequence[Showing], wall_s: float, *, frames: bool = True) -> TrialRecord:
    """Tabulate what the models responded in a trial: a row per model, in the trial's order, and a row per frame.

    Parameters
    ----------
    trial, showings
        The trial, and what it showed.
    wall_s
        Time that it took, s.
    frames
        Whether to keep a row per frame and model.
    """
    rows, tables = {}, {}
    columns = showings[0].source.frame_columns
    for showing in showings:
        truth, source = showing.truth(), showing.source
        shown = source.columns()
        for model, series in showing.series():
            table = truth.with_columns(**{name: getattr(series, name) for name in FIELDS})
            measures = source.measures(model, table)
            rows[model.label] = {
                "experiment": trial.experiment, "trial": trial.index, "repeat": trial.repeat, "seed": trial.seed,
                "model": model.label, **shown, **spike_counts(model, series), **measures,
                "frames": table.height, "wall_s": wall_s,
            }  # fmt: skip
            if frames:
                index = table.with_columns(
                    pl.lit(trial.index).alias("trial"), pl.lit(model.label).alias("model"),
                    pl.int_range(pl.len()).alias("frame"),
                )  # fmt: skip
                tables[model.label] = index.select(columns.names()).cast(columns)
    labels = [model.label for model in trial.models if model.label in rows]
    kept = pl.concat([tables[label] for label in labels]) if frames else pl.DataFrame(schema=columns)
    failures = tuple(
        Failure(trial.index, label, trial.condition.label(), trial.seed, trouble)
        for showing in showings
        for label, trouble in showing.troubles().items()
    )
    return TrialRecord(trial.index, tuple(rows[label] for label in labels), kept, None, failures)
