"""The readings of the paper beside each other, and claims that hang on what is not known of another model."""

import dataclasses
from types import SimpleNamespace

import pytest

from experiments.declare.claim import PAPER, claim_ids
from experiments.declare.outcome import Check, Outcome
from experiments.kinds import registry, sweep, sweep_plan
from experiments.kinds.registry import claims_on
from experiments.paper.claims.clips import ASSUMED, compared
from experiments.paper.claims.readings import CHOSEN_FOR, DELAYS, READINGS, UNITS, WINDOW, bears_on
from experiments.paper.claims.robot import FALLING
from experiments.paper.clips import CLUTTER_SPEED, PER_FRAME, prefix
from experiments.paper.reproduce import other_readings
from experiments.paper.studies.clips import (
    CONSTANTS_2017,
    CONSTANTS_EMD,
    SENSITIVITY as ON_CLIPS,
    along,
    compares_with,
    with_constants,
)
from experiments.paper.studies.robot import SENSITIVITY as ON_ROBOT
from tests.experiments.judge.test_replicates import planned_rows
from tests.helpers.clip_rows import enough, speed_responses
from tests.helpers.paper import every as every_of, first
from tests.helpers.plans import planned

CLAIMS = claims_on("clips")
EMDS = registry.find("constants-emd").models[1:]

COUNTS = {2.0: 10, 4.0: 30, 6.0: 60, 10.0: 40}
"""Spikes of a crossing: C15 holds of them."""


def peaked(rows, model, counts):
    """The rows with a model's spikes at each speed, in the experiments that C15 is judged on."""
    return [
        {**row, "spikes": counts[row["speed_cm_s"]]}
        if row["model"] == model and row["experiment"] in ("speed", "ensembles") and row["speed_cm_s"] in counts
        else row
        for row in rows
    ]


def frames(*repeats):
    """Clips of the experiment clutter-frames that are those of clutter-speed: one set of rows a repeat."""
    plan = planned("clutter-frames", repeats=len(repeats))
    rows = [
        {**row, "clip": prefix(CLUTTER_SPEED) + row["clip"], "speed_unit": "px/frame", "repeat": r}
        for r, clip_rows in enumerate(repeats)
        for row in clip_rows
    ]
    return plan, rows


@pytest.fixture(scope="module")
def evidence():
    """Two replicates: C15 holds, and with falling delays it does in the second alone. C8 fails at the first seed."""
    cases, rows = planned_rows(2)
    rows = peaked(rows, "dsnn", COUNTS)
    second = len(first(cases))
    fails = [row for row in rows if row["trial"] < second]
    holds = [row for row in rows if row["trial"] >= second]
    rows = peaked(fails, FALLING, {**COUNTS, 10.0: 90}) + peaked(holds, FALLING, COUNTS)
    c8 = enough("C8")
    return every_of(cases, rows), [frames([*({**row, "peak_vs": 0.3} for row in c8[:1]), *c8[1:]], c8)]


def read(every, shows, *moved):
    """(claim, other reading) -> what the claim came to under it."""
    return {(row["claim"], row["under"]): row["came_to"] for row in other_readings(every, shows, moved)}


def test_every_other_reading_has_a_source():
    """A level of a study of sensitivity, by its name, or clips and trials of its own; and the claim is judged there."""
    levels = {*ON_ROBOT.axes["moved"], *ON_CLIPS.axes["moved"]}
    on = {claim for study in (ON_ROBOT, ON_CLIPS) for claim in study.claims}
    for reading in set(READINGS) - {DELAYS, UNITS, WINDOW}:
        assert set(READINGS[reading]) <= levels
        beyond = set() if reading in CHOSEN_FOR else {"C12", "C21", "C25", "C30", "C31", "C32"}
        assert set(bears_on(reading)) - on <= beyond
    assert bears_on(UNITS) == tuple(
        claim for claim in claim_ids(PAPER) if any(claim in experiment.claims for experiment in PER_FRAME)
    )


def test_the_clips_in_px_a_frame_are_those_of_the_claims_in_that_unit():
    clips_by_name = {clip.name: clip for clip in registry.find("clutter-frames").clips}
    for experiment in PER_FRAME:
        for clip in experiment.clips:
            usual, other = (
                variant.build(3).params for variant in (clip, clips_by_name[prefix(experiment) + clip.name])
            )
            assert dataclasses.replace(usual, speed_unit="px/frame") == other
        assert all(CLAIMS[claim].models <= set(registry.find("clutter-frames").models) for claim in experiment.claims)


def test_each_reading_is_judged_on_its_own_evidence_in_every_replicate(evidence):
    every, shows = evidence
    (falling,), (by_frame,), (sudden, soft) = (READINGS[name] for name in (DELAYS, UNITS, "start acceleration"))
    moved = {((("moved", sudden),), "dsnn", "C13"): (Outcome("fails", "m", n=20, decided="9 of 10 fire"),)}
    found = read(every, shows, SimpleNamespace(outcomes=moved))
    assert "1 of 2 replicates" in found["C15", falling] and "1 of 2 replicates" in found["C8", by_frame]
    assert "9 of 10 fire" in found["C13", sudden]
    assert "not judged" in found["C7", by_frame], "no clip of the model of 2017"
    assert not found.keys() & {("C6", by_frame), ("C13", soft), ("C19", sudden)}, "what was not run says nothing"
    lost = dataclasses.replace(every[0], lost={("ensembles", FALLING): 1})
    assert "not judged in 1" in read([lost, every[1]], shows)["C15", falling]


# Constants of other models.


@pytest.mark.parametrize(
    ("own", "other", "verdict", "settled"),
    [(1, 1, "unknown constants", "holds"), (1, -1, "unknown constants", "fails"), (-1, 1, "fails", "fails"),
     (-1, -1, "fails", "fails")],
)  # fmt: skip
def test_what_hangs_on_unknown_constants_is_not_judged_whichever_way_it_comes_out(own, other, verdict, settled):
    outcome = compared([Check("own part", own, 0)], [Check("other part", other, 0)], "emd")
    assert outcome.verdict == verdict
    assert outcome.settled().verdict == settled, "with the constants assumed"
    assert "own part (needs above 0)" in outcome.decided
    assert [check.reading for check in outcome.checks] == [own, other], "what was asked is kept, whatever decides"
    assert (f"with those assumed {settled}: other part" in outcome.decided) == (verdict == "unknown constants")


def test_the_claims_about_other_models_are_those_of_the_studies_of_constants():
    compared_claims = {claim for claim, declaration in CLAIMS.items() if declaration.models & set(ASSUMED)}
    assert {claim for claim in CLAIMS if compares_with(claim)} == compared_claims
    assert {claim.id for study in (CONSTANTS_2017, CONSTANTS_EMD) for claim in study.claims} == compared_claims


def test_a_study_of_constants_says_with_how_many_a_claim_holds():
    """The EMD as it should be, and one whose peak does not rise with speed for the darkest and lightest object."""
    study = along("constants-emd", "two choices", ("C26",), "emd", EMDS[:2])
    plan = sweep_plan.sweep_of(study, claim_at=with_constants)
    good, flat = speed_responses(), speed_responses(ends=lambda speed: 0.3)
    clips = {clip: number for number, clip in enumerate(dict.fromkeys(row["clip"] for row in good))}
    rows = [row for row in good if row["model"] == "dsnn"]
    for label, source in zip(EMDS, (good, flat), strict=False):
        rows += [{**row, "model": label} for row in source if row["model"] == "emd"]
    rows = [{**row, "trial": clips[row["clip"]], "experiment": "constants-emd"} for row in rows]
    shares = {key: (range(len(clips)), models) for key, (_, models) in plan.shares.items()}
    result = sweep.read(dataclasses.replace(plan, shares=shares), rows)
    assert [found.verdict for (found,) in result.outcomes.values()] == ["holds", "fails"]
