"""A clip and what models answered to it, as a Rerun recording. With `log`, the only module that imports rerun."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import rerun as rr
import rerun.blueprint as rrb
import rerun_bindings

from dsnn.stimuli import Truth
from experiments.bench import log
from experiments.bench.play import Played

BOX_COLOUR = (214, 39, 40)


def record(played: Played, identity: str | None = None, quality: int | None = None) -> bytes:
    """The recording, as the bytes of an .rrd file: frames, object, potentials, thresholds, spikes.

    Frames are exact, or JPEG of a ``quality`` up to 100; ``identity`` tells the recording from others in a viewer.
    """
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        path = Path(folder) / "clip.rrd"
        _write(path, played, identity, quality)
        rerun_bindings.flush_and_cleanup_orphaned_recordings()  # or Rerun keeps all it was sent (rerun#2116)
        return path.read_bytes()


def _write(path: Path, played: Played, identity: str | None, quality: int | None) -> None:
    recording = rr.RecordingStream(log.APPLICATION, recording_id=identity)
    log.save(recording, path, _blueprint(played))
    recording.send_recording_name(played.name)
    recording.send_property("stimulus", rr.AnyValues(**played.settings))
    times = log.timelines(played.times_s, np.arange(len(played.times_s)))
    if quality is None:
        log.video(recording, "clip", played.frames, times)
    else:
        _jpeg(recording, played, times, quality)
    _object(recording, played.truths, times)
    log.potentials(recording, played.answers, played.times_s)
    recording.flush()
    recording.disconnect()


def _jpeg(recording: rr.RecordingStream, played: Played, times: list[rr.TimeColumn], quality: int) -> None:
    blobs = [cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, quality])[1].tobytes() for image in played.frames]
    recording.log("clip", rr.EncodedImage.from_fields(media_type="image/jpeg"), static=True)
    recording.send_columns("clip", times, rr.EncodedImage.columns(blob=blobs))


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
    return rrb.Blueprint(
        rrb.Vertical(rrb.Spatial2DView(origin="clip", name=played.name), log.plots(played.answers), row_shares=[3, 2]),
        rrb.TimePanel(state="collapsed", timeline="sim_time"),
        collapse_panels=True,
    )
