"""The part of the leaderboard for looming models: which models stand where, alarms, and scores of made-up rows."""

import math
from itertools import count

import numpy as np
import pytest

from dsnn import MODELS
from dsnn.stimuli import stimulus
from experiments.bench.engine.alarms import alarm_count, first_alarm_s, poisson_interval
from experiments.bench.leaderboard.kinds import DIRECTION, LOOMING
from experiments.bench.leaderboard.looming_scores import (
    BACKGROUND,
    GRATING,
    MEASURES,
    RECEDING,
    TRANSLATION,
    ShownClip,
    alarm_rate,
    answered,
    ranked,
    scores,
    separation,
    shown,
    time_to_contact,
)
from experiments.bench.leaderboard.looming_stimuli import L_OVER_V_S, looming_experiments
from experiments.bench.leaderboard.run import of_kinds
from experiments.bench.stats.scores import Score, Standing

CLIPS = count()


def row(motion, peak=0.5, stimulus="looming", absent=False):
    return {
        "experiment": "looming", "clip": f"clip {next(CLIPS)}", "stimulus": stimulus, "motion": motion,
        "object": "absent" if absent else "present", "peak_looming": peak,
    }  # fmt: skip


def clip(motion, alarms=0, seconds=30.0, contact_s=None, shade="", **of):
    return ShownClip(row(motion, **of), seconds, alarms, contact_s, shade)


def test_each_model_stands_where_it_answers():
    directional, looming = of_kinds(list(MODELS))
    assert set(directional) & set(looming) == {"hybrid"}
    assert set(directional) | set(looming) == set(MODELS)
    assert {name for name in MODELS if "looming" in MODELS[name].channels} == set(looming)
    assert of_kinds(["lgmd1"]) == ([], ["lgmd1"]) and of_kinds(["emd"]) == (["emd"], [])


def test_what_a_clip_showed():
    assert [shown(row(motion)) for motion in ("looming", "receding", "upward")] == ["looming", RECEDING, TRANSLATION]
    assert shown(row(None, stimulus="grating")) == GRATING
    assert shown(row("looming", absent=True)) == shown(row(None, stimulus="foliage")) == BACKGROUND
    robot = {"direction": "straight", "peak_looming": 0.5}
    assert shown({**robot, "motion": "approach"}) == "looming" and shown({**robot, "motion": "recession"}) == RECEDING


def test_the_clips_are_what_the_help_says():
    plain, moving = looming_experiments(["lgmd1"])
    assert (len(plain.clips), plain.repeats, len(moving.clips), moving.repeats) == (48, 1, 32, 5)
    for experiment in (plain, moving):
        assert all(clip_spec.build(0).shape == (72, 99) for clip_spec in experiment.clips)
    alone = [
        clip_spec.build(0)
        for clip_spec in moving.clips
        if "before" not in clip_spec.name and "grating" not in clip_spec.name
    ]
    assert [len(frames) for frames in alone] == [151] * 4, "backgrounds of five seconds"
    assert all(frame.truth.box is None for frames in alone for frame in frames)


def test_an_alarm_is_a_spike_after_half_a_second_of_silence():
    """At 30 frames/s: 15 frames apart are one alarm, 16 are two."""
    spikes = np.zeros(60, int)
    assert alarm_count(spikes, 30.0) == 0
    spikes[[10, 11, 12, 27]] = 1
    assert alarm_count(spikes, 30.0) == 1
    spikes[43] = 2
    assert alarm_count(spikes, 30.0) == 2
    assert alarm_count(np.ones(300, int), 30.0) == 1


def test_the_first_alarm_is_told_by_the_time_to_contact():
    contact = np.array([math.nan, 0.3, 0.2, 0.1, 0.0, -0.1])
    assert first_alarm_s(np.array([1, 0, 1, 1, 0, 0]), contact) == 0.2, "before the approach it answers nothing"
    assert first_alarm_s(np.array([0, 0, 0, 0, 1, 1]), contact) is None, "after contact it is too late"


@pytest.mark.parametrize(("count", "low", "high"), [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)])
def test_the_interval_of_a_count_is_garwood_s(count, low, high):
    assert poisson_interval(count) == pytest.approx((low, high), abs=2e-3)


@pytest.mark.parametrize("l_over_v", L_OVER_V_S)
def test_a_detector_of_an_angle_is_told_by_its_angle(l_over_v):
    """What fires at a full angle of 40 degrees does so at (l / v) / tan(20 deg) before contact."""
    clip = stimulus("looming", l_over_v_s=l_over_v, fps=300)
    sizes = np.array([0.0 if f.truth.box is None else f.truth.box.width for f in clip])
    fired = (2 * np.degrees(np.arctan(sizes / 2 / 70.7)) >= 40.0).astype(int)
    assert first_alarm_s(fired, clip.contact_s()) == pytest.approx(l_over_v / math.tan(math.radians(20.0)), abs=1 / 300)


def test_contact_goes_on_after_the_square_stops_and_is_none_of_what_recedes():
    contact = stimulus("looming", l_over_v_s=0.08).contact_s()
    assert np.isnan(contact[:9]).all() and contact[-1] < 0.0
    np.testing.assert_allclose(np.diff(contact[9:]), -1 / 30)
    for changes in ({"motion": "receding"}, {"object": "absent"}):
        assert np.isnan(stimulus("looming", **changes).contact_s()).all()


def test_scores_of_an_ideal_detector_and_of_a_silent_one():
    clips = [clip("looming", 1, peak=0.9, contact_s=t, shade="dark") for t in (0.2, 0.4, 1.0)]
    clips += [clip("receding", peak=0.6), clip("upward", peak=0.55), clip(None, stimulus="grating", alarms=3)]
    ideal = scores([], clips, {"us_99x72": [4.0]}, spikes=True)
    assert ideal["auc_translation"].value == ideal["auc_recession"].value == ideal["auc_background"].value == 1.0
    assert (ideal["answered"].value, ideal["answered"].n) == (1.0, 3)
    assert ideal["contact_dark_s"] == Score(0.4, 0.2, 1.0, 3) and ideal["contact_light_s"] is None
    assert (ideal["alarms_translation"].value, ideal["alarms_gratings"].value) == (0.0, 6.0)
    assert ideal["alarms_background"] is None and ideal["auc_translation_robot"] is None
    silent = scores([], [clip("looming"), clip("upward"), clip("receding")], {}, spikes=True)
    assert (silent["auc_translation"].value, silent["answered"].value) == (0.5, 0.0)
    assert silent["contact_dark_s"] is None
    unspiking = scores([], clips, {}, spikes=False)
    assert unspiking["answered"] is unspiking["alarms_gratings"] is None and unspiking["auc_recession"].value == 1.0
    assert set(ideal) == set(MEASURES) == {name for table in LOOMING.tables for name in table}


def test_parts_without_clips_have_no_score():
    assert separation([row("looming")], TRANSLATION) is None
    assert answered([]) is alarm_rate([], GRATING) is time_to_contact([], "dark") is None


def test_ranking_by_the_areas_then_by_what_is_answered():
    def standing(name, area, hits):
        given = {"auc_translation": Score(area, 0, 1, 9), "answered": hits and Score(hits, 0, 1, 9)}
        return Standing(name, dict.fromkeys(MEASURES) | given)

    given = [standing("c", 0.5, 0.9), standing("b", 0.9, 0.2), standing("a", 0.9, 0.8), standing("d", 0.9, None)]
    assert [model.name for model in ranked(given)] == ["a", "b", "d", "c"]
    assert LOOMING.ranked is ranked and DIRECTION.table != LOOMING.table
