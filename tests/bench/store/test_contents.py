"""What a run's folder has to hold: whole recordings, and frames without gaps but where a model has no such channel."""

import pyarrow as pa
import pytest
import rerun as rr

from experiments.bench.store.contents import Misfit, _check_values, is_recording, same_rows


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """The bytes of a recording that Rerun wrote and closed."""
    path = tmp_path_factory.mktemp("recordings") / "trial-0000.rrd"
    with rr.RecordingStream("test") as stream:
        stream.save(path)
        stream.log("text", rr.TextLog("one"))
        stream.disconnect()
    return path.read_bytes()


def test_a_recording_that_rerun_closed_is_whole(recording, tmp_path):
    path = tmp_path / "trial-0000.rrd"
    assert not is_recording(path)
    path.write_bytes(recording)
    assert is_recording(path)


@pytest.mark.parametrize(
    ("columns", "lacking"),
    [
        ({"hs": [0.0, None]}, "hs"),
        ({"x_cm": [0.0, 0.0], "hs": [0.0, None]}, ""),  # a model of looming alone drives
        ({"x_cm": [0.0, None]}, "x_cm"),
        ({"x_cm": [0.0, 0.0], "reward": [0.0, None]}, "reward"),
        ({"grey": [0.0, None]}, "grey"),
    ],
    ids=["HS of a trial", "HS of an episode", "the place", "the reward", "another column"],
)
def test_frames_have_every_value_but_the_channels_that_an_episode_s_model_lacks(columns, lacking):
    part = pa.table({name: pa.array(values, pa.float64()) for name, values in columns.items()})
    if not lacking:
        _check_values(part, {}, "here")
        return
    with pytest.raises(Misfit, match=f"here: a frame without {lacking}"):
        _check_values(part, {}, "here")


@pytest.mark.parametrize(
    ("change", "same"),
    [({}, True), ({"wall_s": 9.0, "code": "b"}, True), ({"peak_hs": 0.2}, False), ({"model": "emd"}, False)],
    ids=["again", "at another time, by other code", "another number", "another model"],
)
def test_rows_made_again_are_the_same_but_for_time_and_code(change, same):
    row = {"model": "dsnn", "peak_hs": 0.1, "wall_s": 1.0, "code": "a"}
    assert same_rows([row], [{**row, **change}]) is same
