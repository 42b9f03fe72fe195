"""Off-line experiments: clips of a stimulus shown to models, without a robot.

What an experiment of clips is, what one clip comes to, and the rows it leaves.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
from threadpoolctl import threadpool_limits

from dsnn import ResponseSeries
from dsnn.frames import frozen
from dsnn.stimuli import ClipParams, Jittered, Stimulus, StimulusFrame, Truth, stimulus, stimulus_entry
from experiments.bench.contents import Contents, planned_trial
from experiments.bench.declaration import check_declared
from experiments.bench.model_runner import ModelRunner, spike_counts
from experiments.bench.models import Chosen
from experiments.bench.play import Answer, Played
from experiments.bench.results import Failure, Finished

JPEG_QUALITY = 85
"""Of recorded frames: exact ones of a photograph are ten times as large; `colias play` keeps them."""

SHOWN = ("motion", "grey", "speed", "speed_unit", "background_speed", "object")
"""Parameters of clips that their rows show; null where a stimulus has no such parameter."""
DRAWN = ("speed", "grey", "background_speed")
"""Those that a figure of peaks may be drawn against."""
CLIP = "experiments.bench.offline.Clip(name, stimulus, changes, jitter_px)"

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
        **dict.fromkeys(("hs_spikes", "vs_spikes", "looming_spikes"), pa.int64()),
        **{f"{end}_{system}": pa.float64() for system in ("hs", "vs") for end in ("peak", "trough")},
        "peak_looming": pa.float64(),
        "frames": pa.int64(),
        "wall_s": pa.float64(),
        "code": pa.string(),
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
        if not isinstance(self.name, str) or not self.name:
            raise ValueError(f"clip {self.name!r}: its name: legal is a text")
        if not isinstance(self.jitter_px, int | float) or isinstance(self.jitter_px, bool):
            raise ValueError(f"clip {self.name}: jitter_px={self.jitter_px!r}: legal is a number")
        try:
            object.__setattr__(self, "changes", tuple(dict(self.changes).items()))
        except (TypeError, ValueError):
            said = f"changes={self.changes!r}: legal is pairs of a parameter's name and its value"
            raise ValueError(f"clip {self.name}: {said}") from None
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

    def __post_init__(self) -> None:
        if self.kind not in ("traces", "peaks"):
            raise ValueError(f"figure: kind={self.kind!r}: legal is traces, peaks")
        for name in ("along", "lines", "panels"):
            if getattr(self, name) not in DRAWN:
                raise ValueError(f"figure: {name}={getattr(self, name)!r}: legal is {', '.join(DRAWN)}")


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
    recorded: bool = True
    """Whether the first seed's clips are recorded; a grid of long clips would fill a disk."""

    def __post_init__(self) -> None:
        check_declared("experiment", self.name, self.summary, self.repeats, self.claims)
        if isinstance(self.models, str) or not isinstance(self.models, Sequence):
            raise ValueError(f"experiment {self.name}: models={self.models!r}: legal is a tuple of names")
        if isinstance(self.clips, str) or not isinstance(self.clips, Iterable):
            raise ValueError(f"experiment {self.name}: clips={self.clips!r}: legal is a tuple of {CLIP}")
        object.__setattr__(self, "clips", tuple(self.clips))  # a list, or what a generator yields, does as well
        object.__setattr__(self, "models", tuple(self.models))
        if not self.clips or not self.models:
            raise ValueError(f"experiment {self.name}: it needs clips and models")
        for index, clip in enumerate(self.clips):
            if not isinstance(clip, Clip):
                raise ValueError(f"experiment {self.name}: clips[{index}] is {clip!r}: expected {CLIP}")
        for index, model in enumerate(self.models):
            if not isinstance(model, str):
                raise ValueError(f"experiment {self.name}: models[{index}] is {model!r}: expected a name or a path")
        if not isinstance(self.figure, Figure):
            raise ValueError(f"experiment {self.name}: figure={self.figure!r}: legal is a Figure")
        if not isinstance(self.recorded, bool):
            raise ValueError(f"experiment {self.name}: recorded={self.recorded!r}: legal is True or False")
        names = [clip.name for clip in self.clips]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"experiment {self.name}: two clips are called '{twice}'")
        self._check_figure()

    def _check_figure(self) -> None:
        """Peaks are drawn against parameters: every clip has to have them."""
        drawn = (self.figure.along, self.figure.lines, self.figure.panels) if self.figure.kind == "peaks" else ()
        for clip in self.clips:
            known = stimulus_entry(clip.stimulus).params
            for name in drawn:
                if not hasattr(known, name):
                    said = f"'{clip.name}', a {clip.stimulus}, has no {name} to draw peaks against"
                    raise ValueError(f"experiment {self.name}: the clip {said}")


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


def clip_contents(shown: Sequence[Showing], recorded: Iterable[int] = (), *, frames: bool = True) -> Contents:
    """What a run of these clips may hold; the ``recorded`` ones leave recordings."""
    with_recording = frozenset(recorded)
    known: dict[int, Mapping[str, Any]] = {}  # clips of all repeats are the same few objects
    trials = {}
    for showing in shown:
        clip = showing.condition
        if id(clip) not in known:
            params = clip.build(showing.seed).params
            known[id(clip)] = {
                "stimulus": clip.stimulus, "clip": clip.name, **{name: getattr(params, name, None) for name in SHOWN}
            }  # fmt: skip
        labels = (model.label for model in showing.models)
        trials[showing.index] = planned_trial(showing, labels, showing.index in with_recording, **known[id(clip)])
    return Contents(trials, frames)


def show(showing: Showing, *, record: bool = False) -> Finished:
    """Show one clip to every model, and ``record`` it.

    A model that raises loses its own answer alone; if all do, ``RuntimeError`` says why.
    """
    cv2.setNumThreads(1)
    began = time.perf_counter()
    clip = showing.condition.build(showing.seed)
    with threadpool_limits(1):
        watching = [ModelRunner(chosen, clip.shape) for chosen in showing.models]
        frames: list[StimulusFrame] = []
        for frame in clip:
            luma = frozen(frame.luma)
            for each in watching:
                each.see(luma)
            if record:
                frames.append(frame)
    answers = [(each.chosen, series) for each in watching if (series := each.series()) is not None]
    troubles = {each.label: each.trouble for each in watching if each.trouble}
    if not answers:
        raise RuntimeError("; ".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    wall_s = time.perf_counter() - began
    rows = tuple(_row(showing, clip, model, series, wall_s) for model, series in answers)
    tables = pa.concat_tables([_series(showing.index, model.label, series) for model, series in answers])
    failures = tuple(
        Failure(showing.index, label, showing.condition.label(), showing.seed, 1, trouble)
        for label, trouble in troubles.items()
    )
    recording = _recording(showing, clip, frames, answers) if record else None
    return Finished(showing.index, rows, tables, recording, failures)


def _recording(
    showing: Showing, clip: Stimulus[ClipParams], frames: Sequence[StimulusFrame],
    answers: Sequence[tuple[Chosen, ResponseSeries]],
) -> bytes:  # fmt: skip
    from experiments.bench import log_clip

    played = Played(
        showing.condition.name,
        {**dataclasses.asdict(clip.params), "seed": clip.seed},
        np.stack([frame.luma for frame in frames]),
        tuple(frame.truth for frame in frames),
        np.arange(len(frames)) / clip.fps,
        tuple(Answer.of(model, series) for model, series in answers),
    )
    return log_clip.record(played, f"{showing.experiment}-{showing.index}-{showing.seed}", JPEG_QUALITY)


def _row(
    showing: Showing, clip: Stimulus[ClipParams], model: Chosen, series: ResponseSeries, wall_s: float
) -> dict[str, Any]:
    shown: Mapping[str, Any] = {name: getattr(clip.params, name, None) for name in SHOWN}
    return {
        "experiment": showing.experiment,
        "trial": showing.index,
        "repeat": showing.repeat,
        "seed": showing.seed,
        "model": model.label,
        "stimulus": showing.condition.stimulus,
        "clip": showing.condition.name,
        **shown,
        "background_mean": _background_mean(clip),
        "spikes": series.accumulated_spikes(model.counted),
        **spike_counts(series, model.channels),
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
