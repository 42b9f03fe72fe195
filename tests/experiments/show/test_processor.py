"""A processor that is too slow: a model sees every n-th of the camera's frames, which are those of any other model."""

import dataclasses

import numpy as np
import polars as pl
import pytest

from colias_sim import CameraConfig, SceneConfig
from colias_sim.config import ProcessorConfig
from experiments.base.errors import UsageError
from experiments.declare.conditions import Condition
from experiments.live.session import Session
from experiments.settings.models import choose, rate_notes
from experiments.show.robot import is_random
from tests.experiments.kinds.test_sweep import planned as swept
from tests.experiments.show.test_trial import trial_of
from tests.helpers.plans import planned
from tests.helpers.played import Played
from tests.helpers.recordings import columns

CROSSING = Condition("translation", "rightward", 20.0, 8.0)


def model(every=1, **changes):
    """The DSNN on a processor that takes every n-th frame, labelled by that."""
    chosen = choose("dsnn", processor=ProcessorConfig(every=every))
    network = dataclasses.replace(chosen.network, **changes)
    return dataclasses.replace(chosen, label=f"every {every}{''.join(changes)}", network=network)


def trial(*models, seed=7, eye="default"):
    camera = dataclasses.replace(CameraConfig.preset(eye), drop_probability=0.2, jitter_ms=2.0)
    return trial_of(CROSSING, seed, models=models, camera=camera)


@pytest.fixture(scope="module", params=["default", "ov7670"])
def stored(request):
    """Frames of a run in which the model sees all of them, with lost frames and a clock that jitters."""
    return request.param, Played(trial(model(), eye=request.param))


def test_the_responses_are_those_to_every_other_frame_of_a_run_that_shows_all(stored):
    eye, whole = stored
    alone, together = Played(trial(model(2), eye=eye)), Played(trial(model(), model(2), model(2, t_sp=0.1), eye=eye))
    frames = whole.media.images[""]
    for played in (alone, together):
        answer = next(one for one in played.answers if one.model == "every 2")
        network = model().build(frames.shape[1:])
        fresh = [network.step(frame) for frame in frames[answer.phase :: 2]]
        np.testing.assert_array_equal(played.media.images[""], frames)
        assert answer.series.hs.tolist() == [response.hs for response in fresh]
        assert answer.series.hs_spikes.tolist() == [response.hs_spikes for response in fresh]
        assert answer.spikes == sum(response.hs_spikes for response in fresh) != whole.spikes
    assert together.answers[0].series.hs.tolist() == whole.answers[0].series.hs.tolist()


def test_rows_are_of_frames_taken_and_quotients_have_their_rate(stored, tmp_path):
    eye, whole = stored
    played = Played(trial(model(), model(3), eye=eye))
    first, third = played.answers
    table = played.record.frames.filter(model="every 3")
    assert table["frame"].to_list() == list(range(third.phase, whole.frames, 3)) and third.frames == table.height
    np.testing.assert_allclose(table["time_s"], (table["frame"] + 1) / 30)
    seen = (table["stimulus_bearing_deg"].abs() <= 35).to_numpy()
    spikes = np.abs(third.series.hs_spikes)
    expected = {
        "firing_rate_hz": 10 * spikes.mean(), "seconds_in_view": seen.sum() / 10, "spikes_in_view": spikes[seen].sum(),
        "rate_in_view_hz": 10 * spikes[seen].mean() if seen.any() else None,
        "darkest": whole.media.images[""][third.phase :: 3].min(),
    }  # fmt: skip
    assert {name: getattr(third, name) for name in expected} == pytest.approx(expected)
    for name in ("achieved_speed_cm_s", "path_error_mm", "drift_mm", "closest_cm"):  # of the trial, not of a model
        assert getattr(first, name) == getattr(third, name)
    (tmp_path / "trial.rrd").write_bytes(played.recording)
    held = columns(tmp_path / "trial.rrd", static=False)
    lane = held["/models/every\\ 3/hs"]
    assert lane["frame"] == table["frame"].to_list() and np.ravel(lane["scalars"]).tolist() == table["hs"].to_list()
    assert len(held["/world/observer/camera/image"]["frame"]) == whole.frames


def test_what_truly_moved_is_since_the_frame_seen_before(stored):
    """Intervals of three frames are the sums of the three."""
    played = Played(dataclasses.replace(trial(model(), model(3), eye=stored[0]), truth=True))
    each, third = (played.record.frames.filter(model=f"every {every}") for every in (1, 3))
    sums = each.select("frame", pl.col("true_interval_ms").rolling_sum(3))
    both = third.select("frame", "true_interval_ms").drop_nulls().join(sums, "frame")
    assert both.height > 5
    np.testing.assert_allclose(both["true_interval_ms"], both["true_interval_ms_right"])


def test_each_trial_draws_its_phase_where_frames_are_skipped():
    phases = {Played(trial(model(), model(2), seed=seed)).answers[1].phase for seed in range(6)}
    assert phases == {0, 1} and Played(trial(model())).phase == 0
    settings = dataclasses.replace(trial().settings, pose_sd_mm=0.0, heading_sd_deg=0.0, scene=SceneConfig(
        light_sd=0.0, turn_wall=False), camera=CameraConfig.ideal())  # fmt: skip
    assert [is_random(dataclasses.replace(settings, models=(model(every),))) for every in (1, 2)] == [False, True]


def test_a_setting_is_of_every_model_shown_and_stands_in_the_table():
    plan = planned("distance", ("dsnn", "emd"), ("processor.every=2",), 1)
    assert {one.processor.every for spec in plan.trials for one in spec.models} == {2}
    assert plan.parameters["processor.every"] == {"dsnn": 2, "emd": 2}
    assert rate_notes((one, plan.trials[0].fps) for one in plan.models)[0].endswith("30 frames/s assumed, 15 received")
    with pytest.raises(UsageError, match="between 1 and 6"):
        planned("distance", ("dsnn",), ("processor.every=7",), 1)


def test_points_of_a_sweep_share_frames_and_each_has_its_own_phase():
    one, many = swept(["general"], claims=("C14",)), swept(["general"], "processor.every=1,2,3", claims=("C14",))
    assert len(one.specs) == len(many.specs) and len(many.judged) == 3
    assert [shown.processor.every for shown in many.specs[0].models] == [1, 2, 3]
    assert list(many.parameters["processor.every"].values()) == [1, 2, 3]
    rendered = swept(["general"], "processor.every=1,2", "scene.light=1,0.5", claims=("C14",))
    assert len(rendered.specs) == 2 * len(one.specs)


def test_behind_the_page_too(tmp_path):
    """Between two frames that it sees a model's potential stays, and it does not spike."""
    session = Session(["dsnn"], {"processor.every": "3"})
    session.drive("stimulus", 1.0)
    responses = [session.responses["dsnn"] for _ in range(75) if session.step()]
    recorded = session.record(tmp_path / "run")
    phase, frames = recorded.trials["phase"][0], recorded.frames
    assert frames["frame"].to_list() == list(range(phase, 75, 3)) and frames["hs_spikes"].sum() > 0
    taken = frames.select("hs", "hs_spikes").rows()
    held = [(hs, count) for hs, spikes in taken for count in (spikes, 0, 0)][: 75 - phase]
    assert [(one.hs, one.hs_spikes) for one in responses[phase:]] == held and responses[:phase] == [None] * phase
    assert pl.Series(frames["time_s"]).diff().drop_nulls().round(6).unique().to_list() == [0.1]
