"""Off-line experiments: what their clips are, runs from the command line."""

import dataclasses

import pytest

from experiments import NAMES, OFFLINE
from experiments.bench import registry
from experiments.bench.offline import is_random
from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.stats.claim import claims_on


@pytest.mark.parametrize("name", [*NAMES, *OFFLINE])
def test_every_declaration_shows_the_models_that_its_claims_compare_plain_and_on_equal_terms(name):
    experiment = registry.find(name)
    assert experiment.name == name and experiment.summary
    for claim in experiment.claims:
        declared = claims_on("clips" if name in OFFLINE else "robot")[claim]
        assert declared.models | set(declared.equal_terms.values()) <= set(experiment.models)


CLIP = Clip("c", "plain", (("rows", 60), ("columns", 80), ("width", 20), ("height", 30), ("speed", 240.0)))


TREMBLING = dataclasses.replace(CLIP, name="d", jitter_px=1.0)


@pytest.mark.parametrize(("clips", "random"), [((CLIP,), False), ((TREMBLING,), True), ((CLIP, TREMBLING), True)])
def test_clips_are_random_where_any_frame_of_any_clip_is(clips, random):
    """The first frames of all of these are empty, and so equal at every seed."""
    experiment = OfflineExperiment("mine", "", clips, ("dsnn",), repeats=2)
    assert is_random(experiment) is random
