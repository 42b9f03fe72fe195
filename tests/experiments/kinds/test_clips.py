"""Off-line experiments: what their clips are, runs from the command line."""

import dataclasses

import numpy as np
import pytest

from experiments import Check, Claim
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.judge.verdict import Count
from experiments.kinds import registry
from experiments.kinds.clips import verdicts
from experiments.kinds.registry import claims_on
from experiments.kinds.tables import NAMES, OFFLINE
from experiments.show.clips import BOX, open_clip, recorded
from tests.helpers.plans import planned


@pytest.mark.parametrize("name", [*NAMES, *OFFLINE])
def test_every_declaration_shows_the_models_that_its_claims_compare_plain_and_on_equal_terms(name):
    experiment = registry.find(name)
    assert experiment.name == name and experiment.summary
    for claim in experiment.claims:
        declared = claims_on("clips" if name in OFFLINE else "robot")[claim]
        assert declared.models | set(declared.equal_terms.values()) <= set(experiment.models)


CLIP = Clip("c", "plain", (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0)))


def test_a_recorded_clip_has_its_own_clock_and_no_outline_where_there_is_no_object():
    clip = Clip("two", "street", {"movers": "opposite", "fps": 20.0, "rows": 90, "columns": 160, "height": 60.0})
    samples = list(open_clip(clip, 0))[:-20]
    frames, (_, boxes) = recorded(samples, {})
    np.testing.assert_allclose(frames.time_s, np.arange(len(samples)) / 20)
    held, outlines = boxes.to_record_batch(), [[sample.truth[name] for name in BOX] for sample in samples]
    assert 0 < outlines.count([None] * 4) < len(outlines)
    for centres, halves, (left, top, width, height) in zip(
        *(held[f"Boxes2D:{name}"].to_pylist() for name in ("centers", "half_sizes")), outlines, strict=True
    ):
        drawn = np.add(centres, np.outer([-1, 1], halves[0])) if centres else np.zeros((0, 2))
        true = [(left, top), (left + width, top + height)] if width else np.zeros((0, 2))
        np.testing.assert_allclose(drawn, true, atol=1e-4)


def test_each_replicate_is_judged_on_the_clips_of_its_own_seed():
    asked = []

    def judge(rows, threshold):
        asked.append([row["repeat"] for row in rows])
        return [Check("-", 1, 0)]

    mine = Claim(id="mine", says="-", on="clips", reads=("spikes",), judge=judge)
    plan = planned(OfflineExperiment("mine", "", (TREMBLING,), ("dsnn",), (mine,), repeats=2), seed=3)
    row = {"model": "dsnn", "object": "present", "clip": "d", "motion": "rightward", "spikes": 3}
    (found,) = verdicts(plan, [row | {"trial": trial.index, "repeat": trial.repeat} for trial in plan.trials])
    assert asked == [[0], [1]] and found.count == Count(2)


TREMBLING = dataclasses.replace(CLIP, name="d", jitter_px=1.0)


LOOMING = Clip("l", "looming")
"""Its background is even, and no scene."""


@pytest.mark.parametrize(
    ("clips", "random"), [((CLIP, LOOMING), False), ((TREMBLING,), True), ((CLIP, TREMBLING), True)]
)
def test_clips_are_random_where_any_frame_of_any_clip_is(clips, random):
    """The first frames of all of these are empty, and so equal at every seed."""
    assert planned(OfflineExperiment("mine", "", clips, ("dsnn",), repeats=2)).random is random
