"""Models that sense events: what they receive in clips and in trials with the robot, controls, recordings and files."""

from dataclasses import replace

import numpy as np
import pytest

from colias_sim.config import CameraConfig, EventConfig, ProcessorConfig, RobotConfig, SceneConfig
from colias_sim.events import joined
from dsnn import EMDParams, ModelEntry
from dsnn.stimuli import stimulus
from experiments.declare.clip import Clip
from experiments.kinds import data_set
from experiments.settings.models import ConfiguredModel, choose
from experiments.settings.settings import Settings, events_of
from experiments.show.clips import ClipSource, ClipTrial, record
from experiments.show.controls import controls
from experiments.show.play import play, show
from experiments.show.robot import RobotTrial, forget_simulations
from experiments.store.asked import Asked
from experiments.store.recordings import chunks
from tests.colias_sim.envs.test_envs_events import Counter
from tests.experiments.show.test_processor import CROSSING
from tests.helpers.chapters import titled

IDEAL = EventConfig.preset("ideal")
EDGE = Clip("edge", "edge", {"rows": 12, "columns": 32, "speed": 60.0, "dark_grey": 40.0, "light_grey": 200.0})
ALL = 12 * 32 * 8
"""Its events: 8 thresholds in each pixel."""


def counter(**changes):
    entry = ModelEntry("counter", "counts events", Counter, EMDParams())
    return ConfiguredModel("counter", "counter", entry.robot, entry, **changes)


def hs(trial):
    (showing,) = show(trial)
    ((_, series),) = showing.series()
    return series.hs, [sample.events for sample in showing.samples]


def test_a_clip_is_sampled_between_its_frames_and_an_edge_is_the_closed_form():
    """At 60 px/s, 2 px a frame: 8 thresholds in every pixel, at the place where the edge is then."""
    events = joined([sample.events for sample in ClipSource(EDGE, EDGE.build(0), events=IDEAL)])
    assert len(events) == ALL and (events["polarity"] == 1).all()
    for column in (0, 7, 31):
        at = events[(events["x"] == column) & (events["y"] == 5)]["t"]
        shares = (40.0 * np.exp(0.2 * np.arange(1, 9)) - 40.0) / 160.0
        np.testing.assert_allclose(at, 0.3 + (column + shares) / 60.0, atol=0.001)


@pytest.mark.parametrize("name", ["plain", "cluttered", "looming", "grating", "edge", "bar", "street", "foliage"])
def test_a_moment_between_two_frames_is_the_frame_of_a_clip_that_is_twice_as_fast(name):
    slow, fast = (stimulus(name, 3, rows=40, columns=60, fps=fps) for fps in (20.0, 40.0))
    there = fast[41].luma.astype(int)
    assert slow.is_continuous and np.abs(there - slow.at(20.5).luma).max() <= 2
    steps = stimulus("reverse-phi", rows=20, columns=20)
    assert not steps.is_continuous and np.array_equal(steps.at(12.7).luma, steps[12].luma)


def test_a_model_receives_each_event_once_whatever_its_processor_skips():
    every, events = hs(ClipTrial("test", 0, 0, 1, EDGE, (counter(),), events=IDEAL))
    assert every.tolist() == [len(one) for one in events] and every.sum() == ALL
    third, _ = hs(ClipTrial("test", 0, 0, 1, EDGE, (counter(processor=ProcessorConfig(every=3)),), events=IDEAL))
    taken = [sum(every[max(at - 2, 0) : at + 1]) for at in range(len(every))]
    assert any(third.tolist() == taken[phase::3] for phase in range(3))


def test_controls_have_the_events_of_their_own_way():
    source = ClipSource(EDGE, EDGE.build(0), events=IDEAL)
    samples = list(source)
    last = samples[-1].time_s
    seen = joined([sample.events for sample in samples])
    again = {name: joined([one.events for one in control]) for name, control in controls(source, samples, 0)}
    assert again["frozen"].size == 0
    assert np.array_equal(np.sort(31 - again["mirrored"]["x"]), np.sort(seen["x"]))
    back = again["reversed"]
    assert (back["polarity"] == -1).all() and len(back) == len(seen)
    np.testing.assert_allclose(back["t"], last - seen["t"][::-1])
    assert np.array_equal(back["x"], seen["x"][::-1])
    assert len(again["shuffled"]) == len(seen) and np.diff(again["shuffled"]["t"]).min() >= -1e-9


def test_trials_have_an_event_camera_where_a_model_senses_events():
    few = EventConfig(supersample_columns=2)
    settings = Settings((counter(),), RobotConfig(), CameraConfig(), SceneConfig(), 1.0, 1.0, few)
    values, _ = hs(RobotTrial("test", 0, 0, 7, CROSSING, settings))
    assert values.sum() > 1000
    assert RobotTrial("test", 0, 0, 7, CROSSING, replace(settings, models=(choose("emd"),))).events is None
    forget_simulations()


def test_recordings_have_the_events_of_each_frame(tmp_path):
    trial = ClipTrial("test", 0, 0, 0, EDGE, (counter(),), events=IDEAL)
    file = tmp_path / "clip.rrd"
    file.write_bytes(play(trial, record).recording)
    _, events = hs(trial)
    found = [chunk for entity, chunk in chunks(file) if entity.endswith("camera/events") and not chunk.is_static]
    places = [row for chunk in found for row in chunk.to_record_batch()["Points2D:positions"].to_pylist()]
    assert [len(row or ()) for row in places] == [len(one) for one in events]


def test_events_of_a_run_are_written_and_settings_reach_them(tmp_path):
    values = {"events.preset": "ideal", "events.pos_thres": "0.4"}
    assert events_of(values) == replace(IDEAL, pos_thres=0.4)
    data_set.write_events(Asked(kind="clips", what=("clean",), repeats=1, values=values), 0, tmp_path / "out")
    data = np.load(tmp_path / "out" / "camera" / "events.npz")
    assert data["shape"].tolist() == [180, 320] and data["t"].max() <= data["frame_s"][-1]
    assert (data["polarity"] < 0).sum() == pytest.approx(2 * (data["polarity"] > 0).sum(), rel=0.2)


def test_the_model_of_the_page_sees_dark_objects_approach(tmp_path):
    (tmp_path / "event_looming.py").write_text(titled("event_looming.py"), encoding="utf-8")
    model, spikes = choose(str(tmp_path / "event_looming.py")), []
    for changes in ({}, {"motion": "receding"}, {"grey": 200.0, "background_grey": 60.0}):
        clip = Clip("clip", "looming", {"l_over_v_s": 0.06, **changes})
        ((_, series),) = show(ClipTrial("test", 0, 0, 0, clip, (model,)))[0].series()
        spikes.append(series.looming_spikes.sum())
    assert spikes[0] >= 5 and spikes[1:] == [0, 0]
