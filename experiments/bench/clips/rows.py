"""The tables of clips that were shown."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from dsnn import ResponseSeries
from dsnn.stimuli import ClipParams, Stimulus, Truth
from experiments.bench.clips.experiment import BACKGROUND, Showing
from experiments.bench.run.model_runner import spike_counts
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.store.rows import FrameRow, JobRow, ModelRow, ResponseRow, schema_of

SHOWN = (
    "motion", "grey", "speed", "speed_unit", "background", "background_speed", "object", "movers", "foliage",
    "polarity", "fps",
)  # fmt: skip
"""Parameters of clips that their rows show; null where a stimulus has no such parameter."""


class ClipRow(JobRow):
    """A clip's row begins with what every row does, and what was shown; null where a stimulus has no such parameter."""

    stimulus: str
    clip: str
    motion: str | None
    grey: float | None
    speed: float | None
    speed_unit: str | None
    background: str | None
    """What is behind the object: the photograph, a scene, or the name of a user's own picture."""
    background_speed: float | None
    object: str | None
    movers: str | None
    foliage: str | None
    polarity: str | None
    """Polarity of an edge, ``on`` or ``off``, of two steps ``on-off`` and so on."""
    fps: float | None
    """Frames per second of the clip."""
    background_mean: float | None
    """Mean grey of what the object passes."""


class ShownRow(ClipRow, ModelRow):
    """A row of ``trials.parquet``: one clip, as one model answered it."""

    peak_hs: float
    trough_hs: float
    peak_vs: float
    trough_vs: float
    peak_looming: float
    hs_rightward: float | None
    """The highest HS of the frames in which the truth says rightward; null without such frames."""
    hs_leftward: float | None
    """The lowest HS of those in which it says leftward."""
    hs_against: float | None
    """Distance that HS goes against the truth's direction in either, 0 if it never does; null without such frames."""
    frames: int
    wall_s: float
    """Time that the clip took to show."""
    code: str
    """Digest of the code that computed the row: see `experiments.bench.store.provenance`."""


CLIP_SCHEMA = schema_of(ClipRow, ModelRow, ShownRow)
SERIES_SCHEMA = schema_of(FrameRow, ResponseRow)


def _settings(params: ClipParams) -> dict[str, Any]:
    """Return the parameters of a clip that its rows show; of a picture the file's name."""
    settings = {name: getattr(params, name, None) for name in SHOWN}
    background = settings[BACKGROUND]
    return settings if background is None else {**settings, BACKGROUND: Path(background).name}


def _row(
    showing: Showing, clip: Stimulus[ClipParams], motions: Sequence[str], model: ConfiguredModel,
    series: ResponseSeries, wall_s: float,
) -> dict[str, Any]:  # fmt: skip
    """The row of one model; ``motions`` is the truth's word for each frame."""
    return {
        "experiment": showing.experiment,
        "trial": showing.index,
        "repeat": showing.repeat,
        "seed": showing.seed,
        "model": model.label,
        "stimulus": showing.condition.entry.name,
        "clip": showing.condition.name,
        **_settings(clip.params),
        "background_mean": _background_mean(clip),
        **spike_counts(model, series),
        **{
            f"{end}_{system}": float(getattr(getattr(series, system), "max" if end == "peak" else "min")())
            for system in ("hs", "vs")
            for end in ("peak", "trough")
        },
        "peak_looming": float(series.looming.max()),
        **_by_direction(motions, series.hs),
        "frames": len(clip),
        "wall_s": wall_s,
    }


def _by_direction(motions: Sequence[str], hs: npt.NDArray[np.floating]) -> dict[str, float | None]:
    """The extremes of HS while something moves rightward, while something moves leftward, and against it."""
    words = np.asarray(motions)
    right, left = hs[words == "rightward"], hs[words == "leftward"]
    against = np.concatenate([-right, left])
    return {
        "hs_rightward": float(right.max()) if right.size else None,
        "hs_leftward": float(left.min()) if left.size else None,
        "hs_against": max(float(against.max()), 0.0) if against.size else None,
    }


def _background_mean(clip: Stimulus[ClipParams]) -> float | None:
    """Mean grey of what the object of a clip passes: the band of its rows, over the clip; ``None`` without one."""
    box = next((frame.truth.box for frame in _sampled(clip) if frame.truth.box is not None), None)
    if box is None:
        return None
    rows = slice(max(int(box.top), 0), int(box.top + box.height) + 1)
    means = [float(_outside(frame.luma, frame.truth)[rows].mean()) for frame in _sampled(clip)]
    return float(np.mean(means))


def _sampled(clip: Stimulus[ClipParams]) -> Iterator[Any]:
    """Some ten frames of it."""
    return (clip[i] for i in range(0, len(clip), max(1, len(clip) // 10)))


def _outside(luma: npt.NDArray[np.uint8], truth: Truth) -> npt.NDArray[np.uint8]:
    """The frame without the columns in which the object is."""
    if truth.box is None:
        return luma
    left, right = int(truth.box.left), int(truth.box.left + truth.box.width) + 1
    columns = np.arange(luma.shape[1])
    kept: npt.NDArray[np.uint8] = luma[:, (columns < left) | (columns > right)]
    return kept if kept.size else luma


def _series(index: int, label: str, series: ResponseSeries) -> pa.Table:
    columns = {field.name: getattr(series, field.name) for field in dataclasses.fields(ResponseSeries)}
    frames = len(series.hs)
    table = pa.table({"trial": [index] * frames, "model": [label] * frames, "frame": range(frames), **columns})
    return table.select(SERIES_SCHEMA.names).cast(SERIES_SCHEMA)
