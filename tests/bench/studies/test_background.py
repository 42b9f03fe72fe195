"""The study ``background``: claims asked at one speed of the background at a time, and what it counts."""

import pytest

from experiments.background import SPEEDS
from experiments.bench import registry
from experiments.bench.sources.clip_claims import judge, paper_claims
from experiments.bench.studies import run
from experiments.bench.studies.counts import Counts
from experiments.studies.background import BACKGROUND, BESIDE, NAME, STUDY, answered, at_speed
from tests.helpers.clip_rows import T, row

CLAIMS = paper_claims()


def crossings(vs_at, hs=0.2):
    """Clips of C6 and C8 at every speed; VS as a function of it."""
    return [
        row(f"{grey} {speed} {behind}", model, grey=grey, speed=speed, background_speed=-behind, peak_hs=hs,
            peak_vs=0.9 if model == "dsn2017" else vs_at(behind))
        for grey in (0.0, 255.0)
        for speed in (40.0, 80.0, 120.0)
        for behind in SPEEDS
        for model in ("dsnn", "dsn2017")
    ]  # fmt: skip


def judged_at(claim, speed, rows):
    (asked,) = [of_study for of_study in STUDY.claims if of_study.id == claim]
    return judge(at_speed(asked, {NAME: f"{speed:g}"}), rows, T)


def test_a_claim_is_asked_at_one_speed_of_the_background_at_a_time():
    for claim in ("C6", "C8"):
        still, faster = crossings(lambda behind: 0.0), crossings(lambda behind: behind / 300.0)
        best = "unknown constants" if CLAIMS[claim].of_dsnn else "holds"
        assert {judged_at(claim, speed, still).verdict for speed in SPEEDS} == {best}
        holds = [speed for speed in SPEEDS if judged_at(claim, speed, faster).verdict == best]
        assert holds == [speed for speed in SPEEDS if speed / 300.0 < 0.16]
        slow = [clip_row for clip_row in still if clip_row["background_speed"] > -300.0]
        lacking = judged_at(claim, 300.0, slow)
        assert lacking.verdict == "not shown" and "background_speed -300" in lacking.measured


def test_the_half_of_c7_that_one_speed_can_answer_has_a_name_of_its_own():
    assert "C7" not in {claim.id for claim in STUDY.claims}
    rows = [{**clip_row, "peak_hs": clip_row["speed"] / 1e3} for clip_row in crossings(lambda behind: 0.0)]
    assert {judged_at("C7-rises", speed, rows).verdict for speed in SPEEDS} == {"holds"}
    flat = [{**clip_row, "peak_hs": 0.1} if clip_row["background_speed"] == -300.0 else clip_row for clip_row in rows]
    assert [speed for speed in SPEEDS if judged_at("C7-rises", speed, flat).verdict == "fails"] == [300.0]


def test_the_axis_has_the_speeds_that_the_clips_show():
    speeds = {abs(dict(clip.changes)["background_speed"]) for clip in registry.find("background").clips}
    assert speeds == set(SPEEDS) == {float(label) for label in BACKGROUND.labels}
    assert (min(SPEEDS) / 30, max(SPEEDS) / 30) == (pytest.approx(0.07, abs=0.005), 10.0)


def test_crossings_are_counted_by_the_system_and_the_sign_of_the_strongest_answer():
    """Every model of the run, one that answers the background from 1 px a frame on among them."""
    plan = run.planned(STUDY)
    assert [model.label for model in plan.specs[0].models] == ["dsnn", "dsn2017", "emd", *BESIDE]
    quiet = {"trough_hs": 0.0, "peak_vs": 0.0, "trough_vs": 0.0}
    rows = [
        {"trial": spec.index, "experiment": "background", "model": model, "motion": changes.get("motion", "rightward"),
         "object": changes.get("object", "present"), "background_speed": behind, "peak_hs": 0.2, **quiet,
         **({"trough_hs": -0.3} if model == "emd" and abs(behind) >= 30 else {})}
        for spec in plan.specs
        for changes in [dict(spec.condition.changes)]
        for behind in [changes["background_speed"]]
        for model in ("dsnn", "emd")
    ]  # fmt: skip
    right, wrong = answered(Counts(plan, rows))
    assert right == {"model": "dsnn", **dict.fromkeys(("0.067", "0.27", "0.5", "1", "2", "5", "10"), "25/25")}
    assert [wrong[column] for column in ("0.067", "0.5", "1", "10")] == ["25/25", "25/25", "0/25", "0/25"]
