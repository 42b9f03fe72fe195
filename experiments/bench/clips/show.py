"""Show a clip to models, and collect their responses."""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Sequence
from functools import partial

import cv2
import numpy as np
import pyarrow as pa
from threadpoolctl import threadpool_limits

from dsnn import ResponseSeries
from dsnn.frames import frozen
from dsnn.stimuli import ClipParams, Stimulus, StimulusFrame
from experiments.bench.clips.experiment import Showing
from experiments.bench.clips.play import ClipAnswer, Played
from experiments.bench.clips.rows import SERIES_SCHEMA, _row, _series
from experiments.bench.run.errors import TrialError
from experiments.bench.run.model_runner import ModelRunner
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.store.rows import Failure, TrialRecord, recording_of

JPEG_QUALITY = 85
"""JPEG quality of recorded frames: exact ones of a photograph are ten times as large; `colias play` keeps them."""


def show(showing: Showing, *, record: bool = False) -> TrialRecord:
    """Show one clip to every model, and ``record`` it.

    A model that raises loses its own answer alone; if all do, `TrialError` says why.
    """
    cv2.setNumThreads(1)
    began = time.perf_counter()
    clip = showing.condition.build(showing.seed)
    with threadpool_limits(1):
        watching = [ModelRunner(chosen, clip.shape) for chosen in showing.models]
        frames: list[StimulusFrame] = []
        motions: list[str] = []
        for frame in clip:
            luma = frozen(frame.luma)
            for watcher in watching:
                watcher.see(luma)
            motions.append(frame.truth.motion)
            if record:
                frames.append(frame)
    answers = [(watcher.chosen, series) for watcher in watching if (series := watcher.series()) is not None]
    troubles = {watcher.label: watcher.trouble for watcher in watching if watcher.trouble}
    if not answers:
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    wall_s = time.perf_counter() - began
    rows = tuple(_row(showing, clip, motions, model, series, wall_s) for model, series in answers)
    tables = pa.concat_tables([_series(showing.index, model.label, series) for model, series in answers])
    failures = tuple(
        Failure(showing.index, label, showing.condition.label(), showing.seed, trouble)
        for label, trouble in troubles.items()
    )
    recording = recording_of(partial(_recording, showing, clip, frames, answers)) if record else None
    return TrialRecord(showing.index, rows, tables, recording, failures)


def _recording(
    showing: Showing, clip: Stimulus[ClipParams], frames: Sequence[StimulusFrame],
    answers: Sequence[tuple[ConfiguredModel, ResponseSeries]],
) -> bytes:  # fmt: skip
    from experiments.bench.clips import recording as clips_recording

    played = Played(
        showing.condition.name,
        clip.params,
        clip.seed,
        np.stack([frame.luma for frame in frames]),
        tuple(frame.truth for frame in frames),
        np.arange(len(frames)) / clip.fps,
        tuple(ClipAnswer.of(model, series) for model, series in answers),
    )
    return clips_recording.record(played, f"{showing.experiment}-{showing.index}-{showing.seed}", JPEG_QUALITY)


def show_first_seed(showing: Showing, *, record: bool) -> TrialRecord:
    """Show one clip; ``record`` it if it is one of the first seed's."""
    return show(showing, record=record and showing.repeat == 0)


def show_without_frames(showing: Showing) -> TrialRecord:
    """Show one clip, and keep no row a frame."""
    return dataclasses.replace(show(showing), frames=SERIES_SCHEMA.empty_table())
