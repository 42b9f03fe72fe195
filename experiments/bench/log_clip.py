"""A clip and what models answered to it, as a Rerun recording. With `log`, the only module that imports rerun."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from dsnn.stimuli import Truth
from experiments.bench import log
from experiments.bench.play import Played

BOX_COLOUR = (214, 39, 40)


def record(played: Played) -> bytes:
    """The recording, as the bytes of an .rrd file: frames, object, potentials, thresholds, spikes."""
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        path = Path(folder) / "clip.rrd"
        with rr.RecordingStream(log.APPLICATION) as recording:
            log.save(recording, path, _blueprint(played.name))
            recording.send_recording_name(played.name)
            recording.send_property("stimulus", rr.AnyValues(**played.settings))
            times = log.timelines(played.times_s, np.arange(len(played.times_s)))
            log.video(recording, "clip", played.frames, times)
            _object(recording, played.truths, times)
            log.potentials(recording, played.answers, played.times_s)
            recording.flush()
            recording.disconnect()
        return path.read_bytes()


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


def _blueprint(name: str) -> rrb.Blueprint:
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Spatial2DView(origin="clip", name=name),
            rrb.TimeSeriesView(
                origin="potential", name="membrane potential", axis_y=rrb.ScalarAxis(range=(-1.05, 1.05))
            ),
            rrb.TimeSeriesView(origin="spikes", name="spikes per frame"),
            row_shares=[3, 2, 1],
        ),
        rrb.TimePanel(state="collapsed", timeline="sim_time"),
        collapse_panels=True,
    )
