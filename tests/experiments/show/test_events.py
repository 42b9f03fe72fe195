"""Models that sense events: what they receive in clips and in trials with the robot, controls, recordings and files."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from colias_sim.config import CameraConfig, EventConfig, ProcessorConfig, RobotConfig, SceneConfig
from colias_sim.events import joined
from dsnn import ModelEntry, Response
from dsnn.stimuli import stimulus
from experiments.base.errors import TrialError, UsageError
from experiments.declare.clip import Clip
from experiments.kinds import data_set
from experiments.settings.models import ConfiguredModel, choose
from experiments.settings.settings import Settings, events_of
from experiments.show.clips import ClipSource, ClipTrial, open_clip, record
from experiments.show.controls import controls
from experiments.show.play import play, show
from experiments.show.robot import RobotTrial, forget_simulations
from experiments.store.asked import Asked
from experiments.store.recordings import chunks
from tests.experiments.show.test_processor import CROSSING

IDEAL = EventConfig.preset("ideal")
FEW = EventConfig(supersample_columns=2)
SMALL = {"rows": 24, "columns": 32, "speed": 60.0, "dark_grey": 40.0, "light_grey": 200.0}


@dataclass(frozen=True)
class Parameters:
    t_sp: float = 10.0


class Counter:
    """A model whose HS is the number of events since its last step."""

    senses = "events"

    def __init__(self, shape, parameters):
        self.shape = shape

    def step(self, events):
        assert not events.flags.writeable and (np.diff(events["t"]) >= 0).all()
        return Response(hs=float(len(events)))

    def reset(self):
        pass


def counter(**changes):
    entry = ModelEntry("counter", "counts events", Counter, Parameters())
    return ConfiguredModel("counter", "counter", Parameters(), entry, **changes)


def hs(trial):
    (showing,) = show(trial)
    ((_, series),) = showing.series()
    return series.hs, [sample.events for sample in showing.samples]


@pytest.mark.parametrize("polarity", ["on", "off"])
def test_a_clip_is_sampled_between_its_frames_and_an_edge_is_the_closed_form(polarity):
    """An edge at 60 px/s, 2 px a frame: 8 thresholds in every pixel, at the place where it is then."""
    clip = Clip("edge", "edge", SMALL | {"polarity": polarity})
    events = joined([sample.events for sample in ClipSource(clip, clip.build(0), events=IDEAL)])
    assert len(events) == 24 * 32 * 8 and (events["polarity"] == (1 if polarity == "on" else -1)).all()
    ground, behind = (40.0, 200.0) if polarity == "on" else (200.0, 40.0)
    levels = ground * np.exp((0.2 if polarity == "on" else -0.2) * np.arange(1, 9))
    for column in (0, 7, 31):
        at = events[(events["x"] == column) & (events["y"] == 5)]["t"]
        expected = 0.3 + (column + (levels - ground) / (behind - ground)) / 60.0
        np.testing.assert_allclose(at, expected, atol=0.001)


def test_a_stimulus_that_moves_in_steps_has_its_events_at_its_frames():
    clip = stimulus("reverse-phi", rows=20, columns=20)
    assert not clip.is_continuous and np.array_equal(clip.at(12.7).luma, clip[12].luma)
    moving = stimulus("edge", **SMALL)
    assert moving.is_continuous and not np.array_equal(moving.at(12.5).luma, moving[12].luma)


@pytest.mark.parametrize("name", ["plain", "cluttered", "looming", "grating", "edge", "bar", "street", "foliage"])
def test_a_moment_between_two_frames_is_the_frame_of_a_clip_that_is_twice_as_fast(name):
    whole = {
        "plain": 30,
        "cluttered": 30,
        "looming": 20,
        "edge": 20,
        "bar": 20,
        "grating": 20,
        "street": 10,
        "foliage": 10,
    }
    slow, fast = (stimulus(name, 3, rows=40, columns=60, fps=fps) for fps in (20.0, 40.0))
    index = whole[name]
    there, here = fast[2 * index + 1].luma.astype(int), slow.at(index + 0.5).luma
    assert np.abs(there - here).max() <= 2 and slow.is_continuous


def test_a_model_receives_each_event_once_whatever_its_processor_skips():
    clip = Clip("edge", "edge", SMALL)
    every, events = hs(ClipTrial("test", 0, 0, 1, clip, (counter(),), events=IDEAL))
    assert every.tolist() == [len(one) for one in events] and every.sum() == 24 * 32 * 8
    third, _ = hs(ClipTrial("test", 0, 0, 1, clip, (counter(processor=ProcessorConfig(every=3)),), events=IDEAL))
    taken = [sum(every[max(at - 2, 0) : at + 1]) for at in range(len(every))]
    assert any(third.tolist() == taken[phase::3] for phase in range(3))


def test_films_have_no_events_and_the_model_s_own_part_alone_ends():
    trial = ClipTrial("test", 0, 0, 0, Clip("edge", "edge", SMALL), (counter(), choose("emd")))
    object.__setattr__(trial, "sources", lambda: [("", open_clip(trial.condition, 0), trial.models)])
    (showing,) = show(trial)
    assert "show this model trials or clips" in showing.runners[0].trouble and not showing.runners[1].trouble
    with pytest.raises(TrialError, match="no events"):
        object.__setattr__(trial, "models", (counter(),))
        show(trial)


def test_controls_have_the_events_of_their_own_way():
    clip = Clip("edge", "edge", SMALL)
    source = ClipSource(clip, clip.build(0), events=IDEAL)
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
    order = np.diff(again["shuffled"]["t"])
    assert len(again["shuffled"]) == len(seen) and (order >= -1e-9).all()


@pytest.fixture(scope="module")
def crossing():
    settings = Settings((counter(),), RobotConfig(), CameraConfig(), SceneConfig(), 1.0, 1.0, FEW)
    trial = RobotTrial("test", 0, 0, 7, CROSSING, settings)
    yield trial
    forget_simulations()


def test_trials_have_an_event_camera_where_a_model_senses_events_and_the_same_frames(crossing):
    (showing,) = show(crossing)
    ((_, series),) = showing.series()
    frames = replace(crossing.settings, models=(choose("emd"),))
    plain = replace(crossing, settings=frames, events=None)
    (without,) = show(plain)
    assert plain.events is None and all(sample.events is None for sample in without.samples)
    for one, other in zip(showing.samples, without.samples, strict=True):
        assert np.array_equal(one.image, other.image)
    assert series.hs.sum() == sum(len(sample.events) for sample in showing.samples) > 1000


def test_recordings_have_the_events_of_each_frame(tmp_path):
    trial = ClipTrial("test", 0, 0, 0, Clip("edge", "edge", SMALL), (counter(),), events=IDEAL)
    file = tmp_path / "clip.rrd"
    file.write_bytes(play(trial, record).recording)
    _, events = hs(trial)
    found = [
        chunk.to_record_batch() for entity, chunk in chunks(file)
        if entity == "world/observer/camera/events" and not chunk.is_static
    ]  # fmt: skip
    places = [row for batch in found for row in batch["Points2D:positions"].to_pylist()]
    assert [len(row or ()) for row in places] == [len(one) for one in events]


def test_events_of_a_run_are_written_as_they_were_and_settings_reach_them(tmp_path):
    values = {"events.preset": "ideal", "events.pos_thres": "0.4"}
    assert events_of(values) == EventConfig(pos_thres=0.4, sigma_thres=0.0, leak_rate_hz=0.0)
    asked = Asked(kind="clips", what=("clean",), repeats=1, values=values)
    data_set.write_events(asked, 0, tmp_path / "out")
    data = np.load(tmp_path / "out" / "camera" / "events.npz")
    assert set(data) == {"t", "x", "y", "polarity", "shape", "frame_s"} and data["shape"].tolist() == [180, 320]
    on, off = ((data["polarity"] == sign).sum() for sign in (1, -1))
    assert off == pytest.approx(2 * on, rel=0.2) and data["t"].max() <= data["frame_s"][-1]
    with pytest.raises(UsageError, match="must be a run of trials or clips"):
        data_set.write_events(Asked(kind="episodes", what=("stop",), repeats=1), 0, tmp_path / "none")
