"""Play a trial: show each frame of its sources to every model, and tabulate what they respond."""

from __future__ import annotations

import inspect
import math
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

import cv2
import numpy as np
import numpy.typing as npt
import polars as pl
from threadpoolctl import threadpool_limits

from colias_sim.config import EventConfig
from colias_sim.events import Events, joined
from dsnn import Response, ResponseError, ResponseSeries, checked_response
from dsnn.frames import frozen
from dsnn.model import SPIKING
from experiments.base.errors import TrialError
from experiments.base.streams import stream
from experiments.base.user_code import traced
from experiments.settings.models import ConfiguredModel, parse_label
from experiments.store.tables import FRAME, RESPONSES, TrialRecord, recording_of

if TYPE_CHECKING:
    from colias_sim import Truth

FRAMES = pl.Schema({**FRAME, **RESPONSES})
"""Columns of ``frames.parquet``: a row per frame and model."""
ERRORS = ("true_end_point_error_px", "true_angular_error_deg")
"""Columns of a model's local motion against the true flow: see `colias_sim.Truth.errors`."""
FIELDS = tuple(RESPONSES)
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
    pixels
        What each pixel truly shows, where that was asked for.
    since
        What is true instead for a model that takes every n-th frame, of the motion since n frames before: n -> name ->
        value.
    events
        The events since the sample before, of an event camera, where there is one.
    """

    time_s: float
    image: npt.NDArray[np.uint8]
    truth: Mapping[str, Any]
    pixels: Truth | None = None
    since: Mapping[int, Mapping[str, Any]] = field(default_factory=dict)
    events: Events | None = None


NO_IMAGE = np.zeros((0, 0), np.uint8)
"""Placeholder for an image that was not stored."""


class Source(Protocol):
    """Frames that models are shown in one trial: a clip of a stimulus, a trial with the robot before one eye.

    ``fps`` is its rate in 1/s, ``shape`` (R, C) that of a frame in px. ``frame_columns`` are those of
    ``frames.parquet``: `FRAMES`, and the columns of the truth that are stored.
    """

    fps: float
    shape: tuple[int, int]
    frame_columns: pl.Schema

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames in order of time, always the same ones."""

    def columns(self, truth: pl.DataFrame) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``; ``truth`` has a row for each frame."""

    def absent(self) -> AbstractContextManager[Source | None]:
        """Open the same without what moves by itself, at rest but for the camera; ``None`` if nobody knows it."""

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return measures of one model's responses, as columns of ``trials.parquet``.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame that it took: the fields of `dsnn.ResponseSeries`, and of the samples' truth.
        """


def most_common(words: Iterable[str | None]) -> str:
    """Return the motion of most frames of those that move; empty where none does."""
    counts = Counter(word for word in words if word and word != "still")
    return counts.most_common(1)[0][0] if counts else ""


Controls = Callable[[Source, Sequence[Sample], int], Iterable[tuple[str, Source]]]
"""Yields the controls of a source: their names and sources. It receives its samples, all shown, and the trial's seed.
"""


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
    truth
        Whether its frames have what truly moved in them. It changes no frame.
    controls
        Shows it to its models again, as controls; ``None``: they see it once.
    events
        The settings of an event camera; ``None``: there is one, at its defaults, where a model senses events.
    """

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Any
    models: tuple[ConfiguredModel, ...]
    truth: bool = field(default=False, kw_only=True, repr=False)  # recordings are known by the rest
    controls: Controls | None = field(default=None, kw_only=True, repr=False)
    events: EventConfig | None = field(default=None, kw_only=True, repr=False)

    def sources(self) -> Iterable[tuple[str, Source, Sequence[ConfiguredModel]]]:
        """Open the source of each eye: its name, empty for the only one, and the models that see by it."""
        yield "", self.condition.open(self.seed), self.models

    def label(self) -> str:
        """Return the condition as tables and messages name it."""
        return str(self.condition.label())

    @property
    def fps(self) -> float:
        """Rate of the frames that its models are shown, 1/s."""
        return float(self.condition.open(self.seed).fps)


class ModelRunner:
    """One model that is shown frames; its responses are checked. An error in it ends its own part alone.

    Parameters
    ----------
    chosen
        The model and its parameters.
    shape
        (R, C) of the frames.
    keep
        Whether responses are stored; footage may be endless.
    phase
        Number of the first frame that its processor takes.

    Attributes
    ----------
    maps
        Whether it is asked for layer maps; only a model whose ``step`` knows this keyword gives them.
    responses
        The responses so far, on the declared channels alone.
    pictures
        Its layer maps so far, as images (4, R, C) of 8 bits, a quarter of the maps' size.
    errors
        Of each frame whose truth is known, the end-point error (px) and the angular error (degrees) of the model's
        ``local_motion`` (R, C, 2), where it has one: see `colias_sim.Truth.errors`.
    seconds
        Time that the model has taken for its steps.
    trouble
        The traceback of what it raised, or the fault of a response; empty while there is none.
    unseen
        The events of the frames since its last step; ``None`` of one without.
    """

    def __init__(self, chosen: ConfiguredModel, shape: tuple[int, int], *, keep: bool = True, phase: int = 0) -> None:
        self.chosen, self.label, self.phase = chosen, chosen.label, phase
        self.maps = False
        self.responses: list[Response] = []
        self.pictures: list[npt.NDArray[np.uint8]] = []
        self.errors: list[tuple[float, float]] = []
        self.seconds = 0.0
        self.trouble = ""
        self.unseen: list[Events | None] = []
        self._shape, self._keep, self._frames = shape, keep, 0
        self._channels = chosen.channels
        model = self._guarded(lambda: chosen.build(shape))
        if not self.trouble and not self._guarded(lambda: callable(getattr(model, "step", None))):
            self.trouble = self.trouble or f"TypeError: build returned a {type(model).__name__} without step(frame)"
        self._model: Any = model
        self._has_maps = not self.trouble and self._guarded(lambda: _takes_maps(model.step))

    @property
    def taken(self) -> slice:
        """Which frames its processor takes."""
        return slice(self.phase, None, self.chosen.processor.every)

    def share(self, others: Sequence[ModelRunner]) -> None:
        """Let it share what it can with one of ``others``, which see each frame before: a network, or its front.

        Models on processors that take other frames have other states.
        """
        if (other := self._like(others, "READOUT")) is not None:
            self._model = SimpleNamespace(step=lambda _: other.read(self.chosen.network))
        elif (other := self._like(others, "AFTER_F")) is not None:
            self._model.follow(other._model)

    def _like(self, others: Iterable[ModelRunner], parameters: str) -> ModelRunner | None:
        """Return a model that differs in those parameters alone, which its class names."""
        kind = type(self._model)
        names = vars(kind).get(parameters, ())  # a class that inherits them may respond in its own way
        for other in others:
            if names and type(other._model) is kind and other.taken == self.taken:
                same = {name: getattr(other.chosen.network, name) for name in names}
                if replace(self.chosen.network, **same) == other.chosen.network:
                    return other
        return None

    def read(self, params: Any) -> Response:
        """Return its response to the last frame with another readout; see `dsnn.DSNN.read`."""
        if self.trouble:
            raise RuntimeError(f"{self.label}, whose network it reads, raised")
        answer: Response = self._model.read(params)
        return answer

    def see(self, luma: npt.NDArray[np.uint8]) -> Response | None:
        """Return the model's response to the next frame (R, C); ``None`` after an error."""
        if self.trouble:
            return None
        asked = {"maps": True} if self.maps and self._has_maps else {}
        began = time.perf_counter()
        answer = self._guarded(lambda: self._model.step(self._sensed(luma), **asked))
        self.seconds += time.perf_counter() - began
        if self.trouble:
            return None
        response: Response | None = self._guarded(
            lambda: checked_response(answer, self._channels, self._shape if asked else None)
        )
        if response is None:
            return None
        self._frames += 1
        if self._keep:
            if (maps := response.maps) is not None:
                self.pictures.append(self._guarded(maps.pictures))
                response = replace(response, maps=None)
            self.responses.append(response)
        return response

    def compare(self, truth: Truth) -> None:
        """Compare the local motion that the model found in its last frame with the flow that is true of it."""
        motion = getattr(self._model, "local_motion", None)
        self.errors.append((math.nan, math.nan) if motion is None else truth.errors(motion))

    def _sensed(self, luma: npt.NDArray[np.uint8]) -> npt.NDArray[Any]:
        """Return what the next step receives: the frame, or the events since the last step."""
        unseen, self.unseen = self.unseen, []
        if self.chosen.declared.senses == "frames":
            return frozen(luma)
        if any(events is None for events in unseen):
            raise ResponseError("films and logs have no events: show this model trials or clips")
        return joined(unseen)

    def series(self) -> ResponseSeries | None:
        """Return the model's responses to all frames; ``None`` after an error."""
        return None if self.trouble else ResponseSeries.from_responses(self.responses)

    def _guarded(self, call: Callable[[], Any]) -> Any:
        try:
            return call()
        except ResponseError as error:
            self.trouble = f"in frame {self._frames}, {error}"
        except (Exception, SystemExit) as error:
            self.trouble = traced(error)
        return None


def _takes_maps(step: Any) -> bool:
    try:
        parameters = inspect.signature(step).parameters.values()
    except (TypeError, ValueError):
        return False
    return any(p.name == "maps" or p.kind is inspect.Parameter.VAR_KEYWORD for p in parameters)


def phase_of(model: ConfiguredModel, seed: int) -> int:
    """Return the first frame of a trial that a model's processor takes; nothing is drawn where it takes all."""
    every = model.processor.every
    return int(stream("trial.processor", seed).integers(every)) if every > 1 else 0


def _held(response: Response | None) -> Response | None:
    """Return what a model responds to a frame that it does not see: its potentials stay, and it does not spike."""
    return response and replace(response, hs_spikes=0, vs_spikes=0, looming_spikes=0)


class Showing:
    """Frames that a source has shown so far, and the models that respond to them. Iterating shows one more.

    A model that raises loses its own responses alone.

    Attributes
    ----------
    runners
        The models.
    sample
        The last frame.
    samples
        The frames so far, where ``keep`` is set.
    responses
        What each model responded to the last frame; ``None`` of one that raised, or has taken none yet.

    Parameters
    ----------
    source, eye, control
        The frames, the name of the eye that sees them, and that of the control that they are, if any.
    models
        The models.
    keep, images
        Whether frames and responses are stored, and with the frames their images: a trial by hand may be endless,
        and a film long.
    seed
        Seed of the trial.
    """

    def __init__(
        self,
        source: Source,
        models: Sequence[ConfiguredModel],
        eye: str = "",
        control: str = "",
        *,
        keep: bool = True,
        images: bool = True,
        seed: int = 0,
    ) -> None:
        self.source: Any = source
        self.eye, self.control, self._keep, self._images = eye, control, keep, images
        self.runners = [ModelRunner(model, source.shape, keep=keep, phase=phase_of(model, seed)) for model in models]
        for place, runner in enumerate(self.runners):
            runner.share(self.runners[:place])
        self.sample: Sample | None = None
        self.samples: list[Sample] = []
        self.responses: list[Response | None] = [None] * len(models)

    def __iter__(self) -> Iterator[Sample]:
        for number, sample in enumerate(self.source):
            image = frozen(sample.image)
            for runner in self.runners:
                runner.unseen.append(sample.events)
            self.responses = [
                runner.see(image) if runner.chosen.processor.takes(number, runner.phase) else _held(before)
                for runner, before in zip(self.runners, self.responses, strict=True)
            ]
            for runner in self.runners:
                if sample.pixels is not None and runner.chosen.processor.every == 1:
                    runner.compare(sample.pixels)
            self.sample = sample
            if self._keep:
                self.samples.append(sample if self._images else replace(sample, image=NO_IMAGE, pixels=None))
            yield sample

    def series(self) -> list[tuple[ConfiguredModel, ResponseSeries]]:
        """Return each model that responded to every frame that it took, with its responses."""
        return [(runner.chosen, series) for runner in self.runners if (series := runner.series()) is not None]

    def taken(self) -> dict[str, slice]:
        """Return the label of each model with the frames that it took."""
        return {runner.label: runner.taken for runner in self.runners}

    def truth(self, every: int = 1) -> pl.DataFrame:
        """Return what is true of the frames, a row each, for models that take every n-th."""
        shown = [{**sample.truth, **sample.since.get(every, {})} for sample in self.samples]
        return pl.DataFrame({name: [truth[name] for truth in shown] for name in shown[0]}, strict=False)


Watch = Callable[[Showing], None]
"""Watcher of a trial, such as a viewer: called after each frame; it changes nothing."""
Record = Callable[[Any, Sequence[Showing], Sequence[Mapping[str, Any]]], bytes]
"""Writes the recording of a trial from what it showed and its rows, as the bytes of an .rrd file."""


@contextmanager
def one_thread() -> Iterator[None]:
    """Keep OpenCV and BLAS to one thread: the cores are the workers', and a second saves a sixth of the time."""
    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        with threadpool_limits(1):
            yield
    finally:
        cv2.setNumThreads(before)


def show(trial: Trial, *, maps: bool = False, images: bool = True, watch: Watch | None = None) -> list[Showing]:
    """Show the frames of a trial to its models, eye by eye, on one thread.

    Parameters
    ----------
    trial
        The trial.
    maps
        Whether the first model's layer maps are stored.
    images
        Whether the frames' images are stored.
    watch
        Watches it.

    Raises
    ------
    TrialError
        Every model raised; it has their tracebacks. Or the trial itself could not be completed.
    """
    showings, seed, stored = [], trial.seed, images or trial.controls is not None
    with one_thread():
        for eye, source, models in trial.sources():
            showing = Showing(source, models, eye, images=stored, seed=seed)
            showing.runners[0].maps = maps and models[0] is trial.models[0]
            for _ in showing:
                if watch:
                    watch(showing)
            showings.append(showing)
            for control, again in trial.controls(source, showing.samples, seed) if trial.controls else ():
                labelled = [replace(model, label=parse_label(model.label).controlled(control)) for model in models]
                showings.append(Showing(again, labelled, eye, control, images=images, seed=seed))
                for _ in showings[-1]:
                    pass
    if not any(showing.series() for showing in showings):
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in troubles(showings).items()))
    return showings


def troubles(showings: Iterable[Showing]) -> dict[str, str]:
    """Return the label of each model that raised, with its traceback."""
    return {one.label: one.trouble for showing in showings for one in showing.runners if one.trouble}


def play(
    trial: Trial, record: Record | None = None, *, frames: bool = True, maps: bool = False, images: bool = True,
    watch: Watch | None = None,
) -> TrialRecord:  # fmt: skip
    """Play one trial.

    Parameters
    ----------
    trial
        The trial.
    record
        Writes its recording.
    frames
        Whether to keep a row per frame and model.
    maps, images, watch
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
    showings = show(trial, maps=maps, images=images, watch=watch)
    wall_s = time.perf_counter() - began_s
    done = tabulate(trial, showings, wall_s, frames=frames)
    if record is None:
        return done
    shown = [showing for showing in showings if not showing.control]
    rows = [row for row in done.rows if not parse_label(row["model"]).control]
    return replace(done, recording=recording_of(lambda: record(trial, shown, rows)))


def _columns(errors: Sequence[tuple[float, float]]) -> dict[str, pl.Series | None]:
    if not errors:
        return dict.fromkeys(ERRORS)
    return {name: pl.Series(values).fill_nan(None) for name, values in zip(ERRORS, np.array(errors).T, strict=True)}


def tabulate(trial: Trial, showings: Sequence[Showing], wall_s: float, *, frames: bool = True) -> TrialRecord:
    """Tabulate what the models responded in a trial: a row per model, in the trial's order, and a row per frame.

    Controls come after the models.

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
        source, taken = showing.source, showing.taken()
        everies = {1, *(runner.chosen.processor.every for runner in showing.runners)}
        truths = {every: showing.truth(every) for every in everies}
        errors = {runner.label: _columns(runner.errors) for runner in showing.runners}
        shown = source.columns(truths[1])
        for model, series in showing.series():
            numbered = truths[model.processor.every].with_row_index("frame")[taken[model.label]]
            table = numbered.with_columns(**{name: getattr(series, name) for name in FIELDS}, **errors[model.label])
            counts = {c: series.accumulated_spikes(c) if c in model.spiking else None for c in SPIKING}
            rows[model.label] = {
                "experiment": trial.experiment, "trial": trial.index, "repeat": trial.repeat, "seed": trial.seed,
                "model": model.label, **shown, "spikes": counts.get(model.counted),
                **{f"{channel}_spikes": count for channel, count in counts.items()}, **source.measures(model, table),
                "frames": table.height, "wall_s": wall_s,
            }  # fmt: skip
            if frames:
                index = table.with_columns(pl.lit(trial.index).alias("trial"), pl.lit(model.label).alias("model"))
                tables[model.label] = index.select(columns.names()).cast(columns)
    labels = [*dict.fromkeys(label for label in (*(model.label for model in trial.models), *rows) if label in rows)]
    kept = pl.concat([tables[label] for label in labels]) if frames else pl.DataFrame(schema=columns)
    return TrialRecord(trial.index, tuple(rows[label] for label in labels), kept, None, troubles(showings))
