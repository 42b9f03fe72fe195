"""The one writer of Rerun recordings, by the functions that Rerun keeps to itself: these tests tell when they move."""

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb

from experiments.bench.engine.terminal import program
from experiments.bench.recording import recorded, send_layout, timelines

LAYOUT = rrb.Blueprint(rrb.TimeSeriesView(origin="wave", name="a wave"), rrb.TimePanel(state="collapsed"))


def wave(recording: rr.RecordingStream) -> None:
    frames = np.arange(50)
    recording.send_columns("wave", timelines(frames / 30, frames), rr.Scalars.columns(scalars=np.sin(frames)))


def stores(path: Path) -> dict[str, list[str]]:
    """The entities of a file's data, and those of its layout."""
    reader = rr.chunk.RrdReader(path)
    return {
        str(kind): [str(chunk.entity_path) for entry in entries for chunk in reader.stream(store=entry).to_chunks()]
        for kind, entries in (("data", reader.recordings()), ("layout", reader.blueprints()))
    }


def test_a_recording_holds_its_data_and_its_layout(tmp_path):
    data = recorded(wave, LAYOUT, "a wave", "wave-1")
    assert data.startswith(b"RRF2") and b"RRF2FOOT" in data[-12:], "closed"
    (tmp_path / "wave.rrd").write_bytes(data)
    held = stores(tmp_path / "wave.rrd")
    assert "/wave" in held["data"]
    assert any(entity.startswith("/view/") for entity in held["layout"])


def test_a_saved_layout_is_the_one_that_rerun_itself_saves(tmp_path):
    """But for the names, drawn anew each time, of its views."""
    for name in ("ours", "theirs"):
        stream = rr.RecordingStream("colias-sim", recording_id="wave-2")
        stream.save(tmp_path / name, default_blueprint=None if name == "ours" else LAYOUT)
        if name == "ours":
            send_layout(stream, LAYOUT)
        wave(stream)
        stream.disconnect()
    ours, theirs = (
        sorted("/".join(entity.split("/")[:2]) for entity in stores(tmp_path / name)["layout"])
        for name in ("ours", "theirs")
    )
    assert ours == theirs and len(ours) >= 4
    # Without this message a viewer has the layout and does not open with it.
    orders = []
    for name in ("ours", "theirs"):
        command = [*program(), "rrd", "print", str(tmp_path / name)]
        printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        orders.append(re.findall(r"BlueprintActivationCommand.*(make_active.*)", printed))
    assert orders[0] == orders[1] == ["make_active: false, make_default: true)"]


def test_recordings_leave_no_thread_behind():
    def threads() -> int:
        return len(list(Path("/proc/self/task").iterdir()))

    recorded(wave, LAYOUT, "a wave")
    before = threads()
    for _ in range(10):
        recorded(wave, LAYOUT, "a wave")
    assert threads() <= before


def test_what_fails_in_writing_is_told():
    def fail(_: rr.RecordingStream) -> None:
        raise LookupError("no such thing")

    with pytest.raises(LookupError, match="no such thing"):
        recorded(fail, LAYOUT, "nothing")
