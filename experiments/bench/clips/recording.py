"""A clip and what models answered to it, as a Rerun recording."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import partial

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dsnn.stimuli import Truth
from experiments.bench.clips.play import Played
from experiments.bench.recording import jpegs, lanes, page, potentials, recorded, timelines, video

BOX_COLOUR = (214, 39, 40)


def record(played: Played, identity: str | None = None, quality: int | None = None) -> bytes:
    """The recording, as the bytes of an .rrd file: frames, object, potentials, thresholds, spikes.

    Frames are exact, or JPEG of a ``quality`` up to 100; ``identity`` tells the recording from others in a viewer.
    """
    return recorded(partial(_write, played, quality), _blueprint(played), played.name, identity)


def _write(played: Played, quality: int | None, recording: rr.RecordingStream) -> None:
    # Rerun holds a name to the first type it has in a process, and two stimuli may have one as int and as float.
    settings = {**dataclasses.asdict(played.params), "seed": played.seed}
    recording.send_property("stimulus", rr.DynamicArchetype(type(played.params).__name__, components=settings))
    times = timelines(played.times_s, np.arange(len(played.times_s)))
    if quality is None:
        video(recording, "clip", played.frames, times)
    else:
        jpegs(recording, "clip", played.frames, times, quality)
    _object(recording, played.truths, times)
    potentials(recording, played.answers, played.times_s)


def _object(recording: rr.RecordingStream, truths: Sequence[Truth], times: list[rr.TimeColumn]) -> None:
    """The object's outline; an empty list of boxes while there is none, or the last would stay."""
    boxes = [truth.box for truth in truths]
    present = [box for box in boxes if box is not None]
    if not present:
        return
    recording.log("clip/object", rr.Boxes2D.from_fields(colors=[BOX_COLOUR], radii=[0.5]), static=True)
    columns = rr.Boxes2D.columns(
        centers=[[box.left + box.width / 2, box.top + box.height / 2] for box in present],
        half_sizes=[[box.width / 2, box.height / 2] for box in present],
    )
    recording.send_columns("clip/object", times, columns.partition([int(box is not None) for box in boxes]))


def _blueprint(played: Played) -> rrb.Blueprint:
    view = rrb.Spatial2DView(origin="clip", name=played.name)
    return page(view, lanes(played.answers), shares=[3, 2])
