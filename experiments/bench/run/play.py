"""Play a trial: show each frame of a source to every model, and tabulate what they respond."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

import cv2
import numpy as np
import numpy.typing as npt
import polars as pl
from threadpoolctl import threadpool_limits

from dsnn import ResponseSeries
from dsnn.frames import frozen
from experiments.bench.run.errors import TrialError
from experiments.bench.run.model_runner import ModelRunner, spike_counts
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
        What is true of it, by name: the motion shown, the outline of the object.
    """

    time_s: float
    image: npt.NDArray[np.uint8]
    truth: Mapping[str, Any]


class Source(Protocol):
    """Frames that models are shown in one trial: a clip of a stimulus."""

    @property
    def fps(self) -> float:
        """Frames per second."""
        ...

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of a frame, px."""
        ...

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames in order of time, always the same ones."""
        ...

    def columns(self) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``."""
        ...

    def measures(self, frames: pl.DataFrame) -> dict[str, float | None]:
        """Return measures of one model's responses, as columns of ``trials.parquet``.

        Parameters
        ----------
        frames
            A row per frame: the fields of `dsnn.ResponseSeries`, and of the samples' truth.
        """
        ...


class Condition(Protocol):
    """What a trial shows: it opens the source of the frames."""

    def label(self) -> str:
        """Return its name, as tables have it."""
        ...

    def open(self, seed: int) -> Source:
        """Return the source of the frames; ``seed`` is that of every random draw in it."""
        ...


Sink = Callable[[Sample], None]
"""A watcher of the frames, such as a recording: it changes nothing."""


AnyCondition = TypeVar("AnyCondition", bound=Condition)


@dataclass(frozen=True, slots=True)
class Trial(Generic[AnyCondition]):
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
        What is shown.
    models
        The models that it is shown to.
    """

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: AnyCondition
    models: tuple[ConfiguredModel, ...]

    def frame_rates(self) -> Iterable[tuple[ConfiguredModel, float]]:
        """Return each model with the rate of the frames that it is shown, 1/s."""
        rate = self.condition.open(self.seed).fps
        return ((model, rate) for model in self.models)


@dataclass(frozen=True, slots=True)
class Responses:
    """Responses of models to the frames of a source.

    Parameters
    ----------
    series
        Each model that responded to every frame, with its responses.
    truth
        The truth about each frame, in order.
    troubles
        Label of a model that raised -> its traceback.
    """

    series: tuple[tuple[ConfiguredModel, ResponseSeries], ...]
    truth: tuple[Mapping[str, Any], ...]
    troubles: Mapping[str, str]


def respond(source: Source, models: Sequence[ConfiguredModel], *sinks: Sink) -> Responses:
    """Show each frame of a source to every model. A model that raises loses its own responses alone.

    Parameters
    ----------
    source
        The frames.
    models
        The models.
    *sinks
        Called with each sample when the models have responded to it.

    Raises
    ------
    TrialError
        Every model raised; it has their tracebacks.
    """
    runners = [ModelRunner(model, source.shape) for model in models]
    truth = []
    for sample in source:
        image = frozen(sample.image)
        for runner in runners:
            runner.see(image)
        truth.append(sample.truth)
        for sink in sinks:
            sink(sample)
    troubles = {runner.label: runner.trouble for runner in runners if runner.trouble}
    series = tuple((runner.chosen, answer) for runner in runners if (answer := runner.series()) is not None)
    if not series:
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    return Responses(series, tuple(truth), troubles)


class Recording(Protocol):
    """A sink that writes a recording of the trial."""

    def __call__(self, sample: Sample) -> None:
        """Take in a frame."""
        ...

    def written(self, responses: Responses) -> bytes:
        """Return the recording, as the bytes of an .rrd file."""
        ...


def play(trial: Trial[Any], recording: Recording | None = None, *, frames: bool = True) -> TrialRecord:
    """Play one trial.

    Parameters
    ----------
    trial
        The trial.
    recording
        Writes its recording.
    frames
        Whether to keep a row per frame and model.

    Returns
    -------
    TrialRecord
        A row per model, the rows of frames, the recording, and the models that failed.

    Raises
    ------
    TrialError
        Every model raised.
    """
    cv2.setNumThreads(1)  # the cores are the workers'
    began_s = time.perf_counter()
    source = trial.condition.open(trial.seed)
    with threadpool_limits(1):
        responses = respond(source, trial.models, *([recording] if recording else []))
    wall_s = time.perf_counter() - began_s
    shown = source.columns()
    truth = {name: [sample[name] for sample in responses.truth] for name in responses.truth[0]}
    rows, tables = [], []
    for model, series in responses.series:
        table = pl.DataFrame({field: getattr(series, field) for field in FIELDS})
        rows.append({
            "experiment": trial.experiment, "trial": trial.index, "repeat": trial.repeat, "seed": trial.seed,
            "model": model.label, **shown, **spike_counts(model, series),
            **source.measures(table.with_columns(**{name: pl.Series(values) for name, values in truth.items()})),
            "frames": table.height, "wall_s": wall_s,
        })  # fmt: skip
        tables.append(
            table.select(
                pl.lit(trial.index).alias("trial"), pl.lit(model.label).alias("model"),
                pl.int_range(pl.len()).alias("frame"), *FIELDS,
            )
        )  # fmt: skip
    kept = pl.concat(tables).to_arrow().select(FRAMES.names).cast(FRAMES) if frames else FRAMES.empty_table()
    failures = tuple(
        Failure(trial.index, label, trial.condition.label(), trial.seed, trouble)
        for label, trouble in responses.troubles.items()
    )
    written = recording_of(lambda: recording.written(responses)) if recording else None
    return TrialRecord(trial.index, tuple(rows), kept, written, failures)
