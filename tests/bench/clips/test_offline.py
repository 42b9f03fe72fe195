"""Off-line experiments: what their clips are, runs from the command line."""

import dataclasses

import numpy as np
import pytest

from dsnn import DSNN, DSNNParams
from experiments import OFFLINE
from experiments.bench import registry
from experiments.bench.offline import plan, play_clip
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import choose
from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.stats.claim import claims_on


@pytest.mark.parametrize("name", OFFLINE)
def test_every_declaration_can_be_shown_and_judged(name):
    experiment = registry.find(name)
    assert experiment.name == name and experiment.summary
    for claim in experiment.claims:
        assert claims_on("clips")[claim].models <= set(experiment.models)
    with pytest.raises(UsageError, match=name):
        registry.load(name)


CLIP = Clip("c", "plain", (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0)))


def test_a_row_is_what_the_model_says_of_the_clip():
    """And the mean of the ground that an object passes leaves the object out."""
    experiment = OfflineExperiment("mine", "", (CLIP,), ("dsnn",))
    (showing,) = experiment.trials((choose("dsnn", "offline"),), 1, 0)
    done = play_clip(showing)
    clip = CLIP.build(0)
    series = DSNN(clip.shape, DSNNParams.offline()).run(frame.luma for frame in clip)
    (clip_row,) = done.rows
    assert (clip_row["peak_hs"], clip_row["trough_vs"]) == (series.hs.max(), series.vs.min())
    assert clip_row["spikes"] == np.abs(series.hs_spikes).sum()
    assert (clip_row["motion"], clip_row["grey"], clip_row["background_speed"]) == ("rightward", 40.0, None)
    assert clip_row["background_mean"] == 200.0 and clip_row["fps"] == 30.0 and clip_row["polarity"] is None
    np.testing.assert_array_equal(done.frames["hs"].to_numpy(), series.hs)


def test_repeats_share_a_background_and_differ_between_each_other():
    clips = tuple(Clip(str(speed), "cluttered", (("speed", speed), ("columns", 80))) for speed in (300.0, 600.0))
    all_showings = OfflineExperiment("mine", "", clips, ("dsnn",)).trials((choose("dsnn", "offline"),), 2, 5)
    assert [s.seed for s in all_showings] == [5, 5, 6, 6]
    first = [s.condition.build(s.seed)[0].luma for s in all_showings]
    assert np.array_equal(first[0], first[1]) and not np.array_equal(first[0], first[2])


TREMBLING = dataclasses.replace(CLIP, name="d", jitter_px=1.0)


@pytest.mark.parametrize(("clips", "random"), [((CLIP,), False), ((TREMBLING,), True), ((CLIP, TREMBLING), True)])
def test_clips_are_random_where_any_frame_of_any_clip_is(clips, random):
    """The first frames of all of these are empty, and so equal at every seed."""
    experiment = OfflineExperiment("clean", "", clips, ("dsnn",))
    assert plan(experiment, experiment.models, (), 1, 0).is_random() is random
