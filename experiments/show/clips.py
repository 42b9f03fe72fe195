"""Clips of synthetic stimuli: the frames that their trials show, their columns and recordings."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from colias_sim.config import EventConfig
from colias_sim.events import LONGEST_SAMPLE_S, EventPixels, Light
from dsnn.stimuli import SCENES, ClipParams, Jitter, Stimulus, StimulusFrame, Truth
from dsnn.stimuli.background import PHOTOGRAPH
from dsnn.stimuli.still import Still, without_object
from experiments.base.streams import stream
from experiments.declare.clip import BACKGROUND, Clip, OfflineExperiment
from experiments.settings.models import ConfiguredModel, event_camera
from experiments.settings.pictures import Pictures, digests
from experiments.show.play import FRAMES, Controls, Sample, Showing, Trial, most_common
from experiments.store.tables import COUNTS, JOB, PEAKS, peaks

if TYPE_CHECKING:
    from rerun.chunk import Chunk

    from dsnn import ResponseSeries
    from experiments.show.record import Frames

BOX = ("left_px", "top_px", "width_px", "height_px")
NEAR_PX = 5.0
"""Distance from a target's outline up to which a response is on it, as the papers of small-target models count."""
BOX_COLOUR = (214, 39, 40)


SHOWN: Mapping[str, type] = {
    "motion": str, "grey": float, "speed": float, "speed_unit": str, "background": str, "background_speed": float,
    "object": str, "movers": str, "foliage": str, "polarity": str, "fps": float,
}  # fmt: skip
"""Columns that are parameters of clips, null where its stimulus has no such.

``background`` is the photograph, a scene, or the name of a user's own picture; ``polarity`` of an edge is on or off.
"""
TRIALS = pl.Schema(
    {
        **JOB,
        "stimulus": str,
        "clip": str,
        **SHOWN,
        "background_mean": float,  # mean grey of what the object passes
        **COUNTS,
        **PEAKS,
        "hs_rightward": float,  # the highest HS of the frames in which the truth says rightward
        "hs_leftward": float,  # the lowest HS of those in which it says leftward
        "peak_target": float,  # strongest response to a small target
        "on_target": float,  # share of the frames with an object in which that response is within 5 px of its outline
        "hs_against": float,  # distance that HS goes against the truth's direction in either, 0 if it never does
        "frames": int,
        "wall_s": float,  # time that the clip took to show
    }
)
"""Columns of ``trials.parquet`` of clips: a row per clip and model."""

TRUE = ("true_flow_x", "true_flow_y", "true_time_to_contact_s", "true_interval_ms")
TRUE_FRAMES = pl.Schema({**FRAMES, **dict.fromkeys(TRUE, pl.Float64())})
"""Columns of ``frames.parquet`` of clips with truth."""


class ClipTrial(Trial):
    """A clip as a trial: its condition is an `experiments.Clip`."""

    def sources(self) -> Iterable[tuple[str, Any, Sequence[ConfiguredModel]]]:
        """Return the frames of the clip, and all models."""
        events = self.events or event_camera(self.models, EventConfig())
        yield "", ClipSource(self.condition, self.condition.build(self.seed), self.truth, events), self.models

    @property
    def fps(self) -> float:
        """The clip's frame rate, 1/s."""
        return float(self.condition.build(self.seed).fps)

    def way(self) -> str:
        """Return the true motion of most frames that move, of some; empty where none does."""
        clip = self.condition.build(self.seed)
        return most_common(clip[index].truth.motion for index in some(clip))


def open_clip(clip: Clip, seed: int) -> ClipSource:
    """Return the source of a clip's frames, with the columns and measures of their trial; ``seed`` is 0 or more."""
    return ClipSource(clip, clip.build(seed))


def trials_of(
    experiment: OfflineExperiment, models: tuple[ConfiguredModel, ...], repeats: int, seed: int,
    pictures: Pictures | None = None, *, truth: bool = False, controls: Controls | None = None,
    events: EventConfig | None = None,
) -> tuple[ClipTrial, ...]:  # fmt: skip
    """Return every clip of every repeat. Repeat r has the seed ``seed + r``, and so one scene for all its clips.

    Parameters
    ----------
    experiment
        The clips.
    models
        The models, with their parameters.
    repeats, seed
        Number of repeats, and the seed of the first.
    pictures
        Shown in place of the scenes.
    truth, controls, events
        Whether frames have what truly moved, what is shown beside them, and the event camera: as of a `Trial`.

    Returns
    -------
    tuple of ClipTrial
        The trials, repeats outermost.
    """
    whole = [(repeat, clip) for repeat in range(repeats) for clip in clips_of(experiment.clips, repeat, pictures)]
    return tuple(
        ClipTrial(experiment.name, index, r, seed + r, clip, models, truth=truth, controls=controls, events=events)
        for index, (r, clip) in enumerate(whole)
    )


def some(clip: Stimulus[ClipParams]) -> range:
    """Return the indices of some ten frames of a clip, from the first on."""
    return range(0, len(clip), max(1, len(clip) // 10))


class ClipSource:
    """The frames of a clip, with their truth: motion, and the outline of the object in px."""

    def __init__(
        self, clip: Clip, stimulus: Stimulus[ClipParams], truth: bool = False, events: EventConfig | None = None
    ) -> None:
        self.clip, self.stimulus, self._truth, self._events = clip, stimulus, truth, events
        self.frame_columns = TRUE_FRAMES if truth else FRAMES
        self.fps, self.shape = stimulus.fps, stimulus.shape

    def __len__(self) -> int:
        return len(self.stimulus)

    def __iter__(self) -> Iterator[Sample]:
        eye = EventPixels(self.shape, self._events) if self._events else None
        names = ("motion", *BOX, *(TRUE if self._truth else ()))
        if eye:
            parts = eye.config.samples_per_step * int(np.ceil(1.0 / (self.fps * LONGEST_SAMPLE_S)))
            eye.restart(self.stimulus[0].luma, 0.0, stream("trial.events", self.stimulus.seed))
        for index, frame in enumerate(self.stimulus):
            truth = truth_of(frame.truth, index, self.fps)
            if eye and index:
                eye.sample(partial(self._light, index - 1), index / self.fps, parts)
            events = eye.take() if eye else None
            yield Sample(index / self.fps, frame.luma, {name: truth[name] for name in names}, events=events)

    def _light(self, index: int, share: float) -> Light:
        return self.stimulus.at(index + share).luma

    @contextmanager
    def absent(self) -> Iterator[ClipSource]:
        """Open the clip's first frame without its object, throughout: only a trembling camera moves."""
        away, seed = without_object(self.stimulus.params), self.stimulus.seed
        still = Still(replace(self.clip, changes=dict(self.clip.changes) | away, jitter_px=0.0).build(seed))
        trembling = Jitter(still, self.clip.jitter_px, seed) if self.clip.jitter_px else still
        yield ClipSource(self.clip, trembling, truth=self._truth, events=self._events)

    def columns(self, _truth: pl.DataFrame) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``."""
        shown: dict[str, Any] = {name: getattr(self.stimulus.params, name, None) for name in SHOWN}
        if shown[BACKGROUND] is not None:
            shown[BACKGROUND] = Path(shown[BACKGROUND]).name
        named = {"stimulus": self.clip.entry.name, "clip": self.clip.name}
        return {**named, **shown, "background_mean": self._background_mean()}

    def _background_mean(self) -> float | None:
        """Mean grey of the rows that the object passes, without the object; ``None`` without an object."""
        sampled = [self.stimulus[index] for index in some(self.stimulus)]
        box = next((frame.truth.box for frame in sampled if frame.truth.box is not None), None)
        if box is None:
            return None
        rows = slice(max(int(box.top), 0), int(box.top + box.height) + 1)
        return float(np.mean([float(_beside_object(frame)[rows].mean()) for frame in sampled]))

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, float | None]:
        """Return peaks and troughs of a model's potentials, and HS by the direction of motion.

        Parameters
        ----------
        frames
            A row per frame: ``hs``, ``vs``, ``looming`` and the truth's ``motion``.
        """
        hs, motion = frames["hs"].to_numpy(), frames["motion"].to_numpy()
        right, left = hs[motion == "rightward"], hs[motion == "leftward"]
        against = np.concatenate([-right, left])
        return {
            **peaks(frames),
            "hs_rightward": float(right.max()) if right.size else None,
            "hs_leftward": float(left.min()) if left.size else None,
            "hs_against": max(float(against.max()), 0.0) if against.size else None,
            **(self._of_target(frames) if "target" in model.channels else {"peak_target": None, "on_target": None}),
        }

    def _of_target(self, frames: pl.DataFrame) -> dict[str, float | None]:
        """Measure how strong the responses to a small target are, and how many are at the object."""
        shown = frames.drop_nulls(BOX[0])
        off = np.zeros(shown.height)
        for (start, size), channel, length in zip((BOX[::2], BOX[1::2]), ("azimuth", "elevation"), self.shape[::-1],
                                                  strict=True):  # fmt: skip
            at, first, extent = (shown[name].to_numpy() for name in (channel, start, size))
            place = (at + 1.0) / 2.0 * length
            off = np.hypot(off, np.maximum(np.maximum(first - place, place - first - extent), 0.0))
        near = (off <= NEAR_PX) & (shown["target"].to_numpy() > 0.0)
        return {
            "peak_target": float(frames["target"].to_numpy().max()),
            "on_target": float(near.mean()) if near.size else None,
        }


def truth_of(truth: Truth, index: int, fps: float) -> dict[str, Any]:
    """Return what is true of frame ``index``, as columns: ``None`` where there is no object, or no contact.

    Those of `TRUE` have the names and the meaning that trials with the robot have.
    """
    box, (across, down) = truth.box, truth.velocity or (None, None)
    outline = (None,) * 4 if box is None else (box.left, box.top, box.width, box.height)
    ways = zip(("background_x_px_s", "background_y_px_s"), truth.background_velocity, strict=True)
    contact, moved = truth.time_to_contact_s, (index and truth.velocity) or None
    return {
        "motion": truth.motion, **dict(zip(BOX, outline, strict=True)), "velocity_x_px_s": across,
        "velocity_y_px_s": down, **dict(ways), "time_to_contact_s": contact,
        "true_flow_x": moved and moved[0] / fps, "true_flow_y": moved and moved[1] / fps,
        "true_time_to_contact_s": contact if contact is not None and contact > 0.0 else None,
        "true_interval_ms": 1000.0 / fps if index else None,
    }  # fmt: skip


def _beside_object(frame: StimulusFrame) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return the columns of a frame in which the object is not; all of them where it fills the frame."""
    box = frame.truth.box
    if box is None:
        return frame.luma
    columns = np.arange(frame.luma.shape[1])
    beside = frame.luma[:, (columns < int(box.left)) | (columns > int(box.left + box.width) + 1)]
    return beside if beside.size else frame.luma


def record(trial: Trial, showings: Sequence[Showing], _rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a clip that was shown in a trial, as the bytes of an .rrd file."""
    import rerun as rr  # not before: it takes its time to load, and declarations need this file

    from experiments.show import record as rerun

    (showing,), stimulus = showings, showings[0].source.stimulus
    responses = {model.label: series for model, series in showing.series()}
    frames, boxes = recorded(showing.samples, responses)
    # Rerun holds a name to the first type it has in a process: two stimuli may have one as int and as float.
    settings = {**asdict(stimulus.params), "seed": stimulus.seed}
    shown = rr.DynamicArchetype(type(stimulus.params).__name__, components=settings)
    content = rerun.Content(tuple(rerun.RecordedModel.of(model) for model, _ in showing.series()), eyes=("",))
    identity = f"{trial.experiment}-{trial.index}-{trial.seed}"
    about, name = rerun.note(settings), trial.condition.name
    return rerun.write(content, frames, name, identity, {"stimulus": shown}, boxes, about)


def recorded(
    samples: Sequence[Sample], responses: Mapping[str, ResponseSeries], first: int = 0
) -> tuple[Frames, list[Chunk]]:
    """Return frames from number ``first`` on as a recording has them, and the outline of their object."""
    import rerun as rr

    from experiments.show import record as rerun

    time_s, numbers = np.array([sample.time_s for sample in samples]), first + np.arange(len(samples))
    images, events = {"": rerun.jpegs(sample.image for sample in samples)}, {"": [one.events for one in samples]}
    frames = rerun.Frames(time_s, numbers, responses, images, events=events)
    there = [sample.truth.get(BOX[0]) is not None for sample in samples]
    if not any(there):
        return frames, []
    shown = itertools.compress(samples, there)
    boxes = np.array([[sample.truth[name] for name in BOX] for sample in shown])
    columns = rr.Boxes2D.columns(centers=boxes[:, :2] + boxes[:, 2:] / 2, half_sizes=boxes[:, 2:] / 2)
    place = f"{rerun.CAMERA}/stimulus"
    look = rerun.fixed(place, rr.Boxes2D.from_fields(colors=[BOX_COLOUR], radii=[0.5]))
    # No box where there is no object, or the last would stay.
    return frames, [look, rerun.chunk(place, rerun.times(time_s, numbers), columns.partition(there))]


def clips_of(clips: Sequence[Clip], replicate: int, pictures: Pictures | None = None) -> list[Clip]:
    """Return clips as a replicate shows them: replicate r has scene r.

    Replicate 0 has the stimulus's own background, the photograph. Those from 1 on go through the kinds of
    `dsnn.stimuli.SCENES`, one after another and again, and the replicate's seed makes the scene. With ``pictures``
    each has one of those instead, replicate 0 too. A clip that names its background keeps it.
    """
    if pictures is None and not replicate:
        return list(clips)
    image = {BACKGROUND: _image(replicate, pictures)}
    return [replace(clip, changes=dict(clip.changes) | image) if clip.takes_scene() else clip for clip in clips]


def _image(replicate: int, pictures: Pictures | None) -> str:
    """Return the background of a replicate's clips that name none."""
    if pictures:
        return pictures[replicate % len(pictures)]  # after the last one the first comes again
    return list(SCENES)[(replicate - 1) % len(SCENES)] if replicate else PHOTOGRAPH


def described_scenes(clips: Iterable[Clip], replicates: int, pictures: Pictures | None) -> dict[str, list[str]]:
    """Return what ``run.json`` has of the scenes of clips; nothing where none of them takes one.

    ``backgrounds`` has the background of each replicate, ``pictures`` each of a user's own with its digest.
    """
    if not any(clip.takes_scene() for clip in clips):
        return {}
    names = [Path(_image(replicate, pictures)).name for replicate in range(replicates)]
    return {"backgrounds": names, **({"pictures": digests(pictures)} if pictures else {})}
