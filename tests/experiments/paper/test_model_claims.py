"""The claims of the models' own papers: their words are complete, each check decides as it says, they can be run."""

import json

import pytest

from dsnn import MODELS
from experiments.base.errors import UsageError
from experiments.paper.claims.models import CLIPS, GROUPS, claim_on_clips, model_claims, names
from experiments.paper.reproduce import claims_of, judge_models
from experiments.store.workers import Workers

EVERY = [claim for claims in model_claims().values() for claim in claims]


def model_claim(test, **more):
    more = {"clips": ("dark-looming",), "bound": 1.0, "measure": "spikes", **more}
    return claim_on_clips("GF-1", "lplc2-gf", test, **more)


def rows(numbers, model="lplc2-gf", column="spikes"):
    """A row of each clip of some groups: group -> its clips' numbers, each over again."""
    return [
        {"model": model, "clip": name, "spikes": 0.0, "peak_looming": 0.5, column: values[i % len(values)]}
        for group, values in numbers.items()
        for i, name in enumerate(names((group,)))
    ]


def judged(claim, clip_rows):
    return claim.judge(clip_rows, 0.0)


def test_every_claim_is_about_a_model_and_clips_that_there_are():
    assert set(model_claims()) <= set(MODELS)
    assert len({claim.id for claim in EVERY}) == len(EVERY)
    for claim in EVERY:
        assert set(claim.conditions.get("clip", ())) <= set(CLIPS) and claim.says
        assert all(model.partition(":")[0] in model_claims() for model in claim.models)


def test_every_clip_is_what_the_robot_s_camera_would_see():
    for group, clips in GROUPS.items():
        for clip in clips:
            built = clip.build(0)
            rate = 1000 if "target" in group and "30" not in group else 100 if group == "looming-100" else 30
            assert built.shape == (72, 99) and built.fps == rate


@pytest.mark.parametrize(
    ("claim", "holds", "fails"),
    [
        (model_claim("each"), {"dark-looming": [1, 2, 3]}, {"dark-looming": [3, 0, 3]}),
        (model_claim("none", bound=3.0, control=("light-looming",)),
         {"dark-looming": [3], "light-looming": [1]}, {"dark-looming": [0, 4], "light-looming": [1]}),
        (model_claim("ratio", bound=2.0, against=("translating",)),
         {"dark-looming": [4, 9], "translating": [2, 0]}, {"dark-looming": [9, 4], "translating": [0, 3]}),
        (model_claim("share", bound=0.5, against=("translating",)),
         {"dark-looming": [0, 1], "translating": [2, 9]}, {"dark-looming": [0, 2], "translating": [9, 3]}),
    ],
)  # fmt: skip
def test_a_check_decides_by_the_worst_clip(claim, holds, fails):
    assert judged(claim, rows(holds)).verdict == "holds"
    outcome = judged(claim, rows(fails))
    assert outcome.verdict == "fails" and "needs" in outcome.decided


def test_a_silent_model_keeps_no_claim_of_silence():
    none = model_claim("none", bound=0.0, control=("light-looming",))
    for claim in (none, model_claim("share", against=("translating",))):
        outcome = judged(claim, rows({"dark-looming": [0], "light-looming": [0], "translating": [0]}))
        assert outcome.verdict == "silent model" and "silent in all" in outcome.decided


def test_what_is_compared_with_another_model_takes_that_model_s_rows():
    claim = model_claim("more", measure="peak", bound=2.0, than="other")
    for theirs, verdict in ((0.9, "holds"), (0.6, "fails")):
        clip_rows = rows({"dark-looming": [0.6]}, column="peak_looming")
        clip_rows += rows({"dark-looming": [theirs]}, "other", "peak_looming")
        assert judged(claim, clip_rows).verdict == verdict


def test_the_way_is_that_of_the_strongest_potential():
    claim = model_claim("way", measure="way", clips=("translating",))
    row = {"model": "lplc2-gf", "clip": names(("translating",))[0], "motion": "rightward",
           "peak_hs": 0.3, "trough_hs": -0.1, "peak_vs": 0.2, "trough_vs": 0.0}  # fmt: skip
    assert judged(claim, [row]).verdict == "holds"
    assert judged(claim, [{**row, "trough_hs": -0.4}]).verdict == "fails"
    turned = model_claim("reversed", measure="way", clips=("translating",))
    assert judged(turned, [{**row, "trough_hs": -0.4}]).verdict == "holds"
    assert judged(turned, [row]).verdict == judged(turned, [{**row, "peak_vs": 0.5}]).verdict == "fails"


def test_settings_go_to_every_variant_of_a_model():
    variants = [claim for claim, _ in claims_of(["si-lgmd1:preset=firmware", "lplc2-gf"])]
    assert set.union(*(set(claim.models) for claim in variants)) == {
        "si-lgmd1:preset=firmware", "si-lgmd1:beta_3=0,preset=firmware", "lplc2-gf", "lplc2-gf:fps=100",
    }  # fmt: skip
    assert {name for _, name in claims_of(["all"])} == set(model_claims())
    with pytest.raises(UsageError, match="--model emd: no claims"):
        claims_of(["emd"])


def test_a_model_s_own_claims_are_judged_and_kept(tmp_path):
    verdicts, failures = judge_models(tmp_path / "out", ["si-lgmd1:preset=firmware"], 0, Workers(0, quiet=True))
    assert not failures and [verdict.id for verdict in verdicts] == [claim.id for claim in model_claims()["si-lgmd1"]]
    assert {verdict.outcome.verdict for verdict in verdicts if verdict.outcome.n} <= {"holds", "fails", "silent model"}
    assert [verdict.outcome.verdict for verdict in verdicts if not verdict.outcome.n] == ["not shown"]
    told = json.loads((tmp_path / "out" / "model_claims.json").read_text())
    assert [entry["outcome"]["verdict"] for entry in told["claims"]] == [
        verdict.outcome.verdict for verdict in verdicts
    ]
