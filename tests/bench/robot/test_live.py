"""A trial streamed while it runs: the same trial, the same numbers, whatever the viewer does."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import rerun as rr

from experiments.bench.run import viewer
from experiments.bench.run.models import choose
from experiments.bench.run.viewer import program
from experiments.bench.sources.recording import LiveTrial
from experiments.bench.trials import work
from tests.bench.robot.test_trial import same, spec
from tests.helpers.played import Played
from tests.helpers.rerun_viewer import PATIENCE_S, listening

TWO = (choose("dsnn"), choose("emd"))


def rows_of(record) -> list[dict]:
    return [{**row, "wall_s": 0.0} for row in record.rows]


def batches_of(path: Path, entity: str) -> list[pa.RecordBatch]:
    """The rows of an entity, chunk by chunk."""
    chunks = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
    return [chunk.to_record_batch() for chunk in chunks]


def column(path: Path, entity: str, name: str) -> np.ndarray:
    """All values of an entity in order of frame, as rows."""
    batches = batches_of(path, entity)
    frames = np.concatenate([batch["frame"].to_numpy() for batch in batches])
    values = [value for batch in batches for value in batch[name].to_pylist()]
    assert len(frames) == len(set(frames)), f"{entity}: no frame twice"
    return np.array([np.ravel(values[place]) for place in np.argsort(frames)])


def ended(process: subprocess.Popen[bytes], path: Path, entities: Sequence[str], frames: int) -> Path:
    """End a program that saves what it receives, once each entity has all of its frames; return the file, whole.

    A sender is done when all has left it; the program may then still have to write it, and writes nothing more once it
    is told to end. What it has written lacks a footer until it is merged.
    """
    whole, end = path.with_name("whole.rrd"), time.monotonic() + PATIENCE_S
    command = [*program(), "rrd", "merge", str(path), "-o", str(whole)]
    while subprocess.run(command, capture_output=True, timeout=60).returncode or any(
        sum(batch.num_rows for batch in batches_of(whole, entity)) < frames for entity in entities
    ):
        assert time.monotonic() < end, f"{path}: not all of {frames} frames of {', '.join(entities)} arrived"
        time.sleep(0.2)
    process.terminate()
    process.wait(20)
    return whole


def test_what_arrives_is_the_trial(tmp_path):
    """In parts: all frames of it, once each, their pictures, potentials, spikes and poses."""
    asked = spec(models=TWO)
    with listening("--save", str(tmp_path / "live.rrd")) as (address, process):
        live = LiveTrial(asked, address)
        result = Played(asked, maps=True, watch=live.see)
        live.close()
        series = [
            f"{answer.model}/{part}{channel}"
            for answer in result.answers for channel in answer.channels for part in ("", "spikes/")
        ]  # fmt: skip
        entities = [f"/models/{name}" for name in series]
        entities += ["/world/observer/camera/image", "/world/stimulus"]
        entities += [f"/models/dsnn/maps/{name}" for name in result.media.maps]
        path = ended(process, tmp_path / "live.rrd", entities, result.frames)
    assert same(result, Played(asked))
    for answer in result.answers:
        for channel in answer.channels:
            sent = column(path, f"/models/{answer.model}/{channel}", "Scalars:scalars")
            np.testing.assert_array_equal(sent[:, 0], getattr(answer.series, channel))
            spikes = column(path, f"/models/{answer.model}/spikes/{channel}", "Scalars:scalars")
            np.testing.assert_array_equal(spikes[:, 0], getattr(answer.series, f"{channel}_spikes"))
    seen = column(path, "/world/observer/camera/image", "Image:buffer")
    np.testing.assert_array_equal(seen.reshape(result.media.images[""].shape), result.media.images[""])
    for name, images in result.media.maps.items():
        received = column(path, f"/models/dsnn/maps/{name}", "SegmentationImage:buffer").reshape(images.shape)
        np.testing.assert_array_equal(received, images)
    place = column(path, "/world/stimulus", "Transform3D:translation")
    np.testing.assert_allclose(place[:, 0], result.columns.stimulus_x_cm, rtol=1e-6)


def test_numbers_and_recording_do_not_depend_on_a_viewer(tmp_path):
    """A job of a run, without one and with one that is not there."""
    asked, nobody = spec(), f"{viewer.HOST}:{viewer.free_port()}"
    plain = work(asked, recordings=True, frames=True)
    streamed = work(asked, recordings=True, frames=True, viewer=nobody)
    assert rows_of(plain) == rows_of(streamed) and plain.frames.equals(streamed.frames)
    assert isinstance(plain.recording, bytes) and isinstance(streamed.recording, bytes)
    assert work(asked, viewer=nobody).recording is None


def test_a_viewer_that_is_closed_meanwhile_costs_nothing_but_the_rest_of_the_stream(tmp_path):
    asked = spec()
    with listening("--save", str(tmp_path / "live.rrd")) as (address, process):
        live, seen = LiveTrial(asked, address), []

        def see(showing) -> None:
            live.see(showing)
            seen.append(showing.eye)
            if len(seen) == 20:
                process.kill()
                process.wait()

        result = Played(asked, maps=True, watch=see)
        began = time.monotonic()
        live.close()
        assert time.monotonic() - began < 30, "it does not wait for ever"
    assert len(seen) == result.frames and same(result, Played(asked))
