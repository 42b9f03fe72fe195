"""Off-line experiments: clips of a stimulus shown to models, without a robot.

What an experiment of clips is, what one clip comes to, and the rows it leaves.
"""

from __future__ import annotations

import dataclasses
import re
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
from threadpoolctl import threadpool_limits

from dsnn import Response, ResponseSeries
from dsnn.stimuli import ClipParams, Jittered, Stimulus, Truth, stimulus
from experiments.bench.models import Chosen
from experiments.bench.results import Failure, Finished
from experiments.bench.trial import check_finite

SHOWN = ("motion", "grey", "speed", "speed_unit", "background_speed", "object")
"""Parameters of clips that their rows show; null where a stimulus has no such parameter."""

CLIP_SCHEMA = pa.schema(
    {
        "experiment": pa.string(),
        "trial": pa.int64(),
        "repeat": pa.int64(),
        "seed": pa.int64(),
        "model": pa.string(),
        "stimulus": pa.string(),
        "clip": pa.string(),
        **{n: pa.float64() if n in ("grey", "speed", "background_speed") else pa.string() for n in SHOWN},
        "background_mean": pa.float64(),
        "spikes": pa.int64(),
        **{f"{end}_{system}": pa.float64() for system in ("hs", "vs") for end in ("peak", "trough")},
        "peak_looming": pa.float64(),
        "frames": pa.int64(),
        "wall_s": pa.float64(),
    }
)
SERIES_SCHEMA = pa.schema(
    {
        "trial": pa.int64(),
        "model": pa.string(),
        "frame": pa.int64(),
        **{
            field.name: pa.int64() if field.name.endswith("spikes") else pa.float64()
            for field in dataclasses.fields(ResponseSeries)
        },
    }
)


@dataclass(frozen=True, slots=True)
class Clip:
    """A stimulus with changes to its defaults, as (name, value) pairs; ``name`` tells it from the others.

    ``jitter_px`` is the standard deviation of a trembling camera's shifts (`dsnn.stimuli.Jittered`); 0: it stands.
    Raises ``ValueError`` on a stimulus or parameter there is none of, and on a value out of range.
    """

    name: str
    stimulus: str
    changes: tuple[tuple[str, Any], ...] = ()
    jitter_px: float = 0.0

    def __post_init__(self) -> None:
        self.build(0)

    def build(self, seed: int) -> Stimulus[ClipParams]:
        """The clip itself."""
        clip = stimulus(self.stimulus, seed, **dict(self.changes))
        return Jittered(clip, self.jitter_px, seed) if self.jitter_px else clip

    def label(self) -> str:
        """Its name."""
        return self.name


@dataclass(frozen=True, slots=True)
class Figure:
    """How an off-line experiment is drawn: its models' potentials over each clip, or peaks against ``along``.

    Peaks have a line for each value of ``lines``, and a row of panels for each of ``panels``.
    """

    kind: Literal["traces", "peaks"] = "traces"
    along: str = "speed"
    lines: str = "background_speed"
    panels: str = "grey"


@dataclass(frozen=True, slots=True)
class OfflineExperiment:
    """A declaration: every clip shown to every model, ``repeats`` times with other seeds.

    Where nothing in the clips is random, one repeat says it all. Raises ``ValueError`` on a declaration that cannot
    be run as it stands.
    """

    name: str
    summary: str
    clips: tuple[Clip, ...]
    models: tuple[str, ...]
    claims: tuple[str, ...] = ()
    repeats: int = 1
    figure: Figure = Figure()

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]*", self.name):
            raise ValueError(f"experiment {self.name!r}: its name: legal are letters, digits, - and _")
        if not self.clips or not self.models:
            raise ValueError(f"experiment {self.name}: it needs clips and models")
        names = [clip.name for clip in self.clips]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"experiment {self.name}: two clips are called '{twice}'")
        if isinstance(self.repeats, bool) or not isinstance(self.repeats, int) or self.repeats < 1:
            raise ValueError(f"experiment {self.name}: repeats={self.repeats!r}: legal is a whole number from 1 up")


@dataclass(frozen=True, slots=True)
class Showing:
    """One clip to show, wholly determined: `show` is a pure function of it."""

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Clip
    models: tuple[Chosen, ...]


def showings(experiment: OfflineExperiment, models: tuple[Chosen, ...], repeats: int, seed: int) -> list[Showing]:
    """Every clip of every repeat. Repeat r has the seed ``seed + r`` throughout: one background for all its clips."""
    clips = experiment.clips
    return [
        Showing(experiment.name, index, index // len(clips), seed + index // len(clips), clip, models)
        for index, clip in enumerate(clips * repeats)
    ]


def show(showing: Showing) -> Finished:
    """Show one clip to every model. A model that raises loses its own answer alone; if all do, the first raises."""
    cv2.setNumThreads(1)
    began = time.perf_counter()
    clip = showing.condition.build(showing.seed)
    answers: dict[str, ResponseSeries] = {}
    troubles: dict[str, str] = {}
    with threadpool_limits(1):
        for chosen, given in zip(showing.models, _answers(showing.models, clip), strict=True):
            if isinstance(given, str):
                troubles[chosen.label] = given
            else:
                answers[chosen.label] = given
    if not answers:
        raise RuntimeError("; ".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    wall_s = time.perf_counter() - began
    rows = tuple(_row(showing, clip, label, series, wall_s) for label, series in answers.items())
    tables = pa.concat_tables([_series(showing.index, label, series) for label, series in answers.items()])
    failures = tuple(
        Failure(showing.index, label, showing.condition.label(), showing.seed, 1, trouble)
        for label, trouble in troubles.items()
    )
    return Finished(showing.index, rows, tables, None, failures)


def _answers(models: tuple[Chosen, ...], clip: Stimulus[ClipParams]) -> Iterator[ResponseSeries | str]:
    """Each model's answer to the whole clip, or what went wrong. The clip is painted once, a frame at a time."""
    built: list[Any] = []
    for chosen in models:
        try:
            built.append(chosen.build(clip.shape))
        except (Exception, SystemExit) as error:
            built.append(f"{type(error).__name__}: {error}")
    responses: list[list[Response]] = [[] for _ in models]
    for frame in clip:
        for place, model in enumerate(built):
            if isinstance(model, str):
                continue
            try:
                responses[place].append(model.step(frame.luma))
            except (Exception, SystemExit) as error:
                built[place] = f"{type(error).__name__}: {error}"
    for model, given in zip(built, responses, strict=True):
        yield model if isinstance(model, str) else _stacked(given)


def _stacked(responses: Sequence[Response]) -> ResponseSeries | str:
    """The answers as columns, or what is wrong with them: a row of NaN would pass for a number in every table."""
    try:
        series = ResponseSeries.from_responses(responses)
        check_finite(series)
    except Exception as error:  # an answer that is no Response, or holds no numbers
        return f"{type(error).__name__}: {error}"
    return series


def _row(
    showing: Showing, clip: Stimulus[ClipParams], label: str, series: ResponseSeries, wall_s: float
) -> dict[str, Any]:
    shown: Mapping[str, Any] = {name: getattr(clip.params, name, None) for name in SHOWN}
    return {
        "experiment": showing.experiment,
        "trial": showing.index,
        "repeat": showing.repeat,
        "seed": showing.seed,
        "model": label,
        "stimulus": showing.condition.stimulus,
        "clip": showing.condition.name,
        **shown,
        "background_mean": _background_mean(clip),
        "spikes": int(np.abs(series.hs_spikes).sum() + series.looming_spikes.sum()),
        **{
            f"{end}_{system}": float(getattr(getattr(series, system), "max" if end == "peak" else "min")())
            for system in ("hs", "vs")
            for end in ("peak", "trough")
        },
        "peak_looming": float(series.looming.max()),
        "frames": len(clip),
        "wall_s": wall_s,
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
