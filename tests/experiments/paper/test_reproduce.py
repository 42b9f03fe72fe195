"""A reproduction with a model and an experiment of one's own: each claim has a verdict, and the page says it once."""

import json
import re
import shutil
from contextlib import contextmanager

import polars as pl
import pytest

from experiments.declare.claim import PAPER, claim_ids
from experiments.declare.study import WHOLE
from experiments.judge.verdict import Count, verdicts as stored_verdicts
from experiments.kinds import registry
from experiments.kinds.result import plan_of
from experiments.paper import reproduce
from experiments.paper.page import FULL, QUICK, USUAL, Scale
from experiments.paper.reproduce import judge, pooled, verdicts
from experiments.paper.studies.robot import SENSITIVITY
from experiments.show import play
from experiments.show.robot import RobotTrial
from experiments.store.asked import Asked
from tests.experiments.judge.test_replicates import rows_of
from tests.helpers import user_files
from tests.helpers.inside import inside
from tests.helpers.paper import design, every

COMMAND = ("reproduce", "--quick", "--workers", "0", "--out", "out", "--model", "my_model.py",
           "--experiment", "my_experiment.py")  # fmt: skip
SMALL = Scale(2, 5, moves=False, offline_replicates=1, episodes=1, steps=5, offline=("clean",))


PLACES = ("general", "speed")
simulated = {}
"""(Condition, settings) -> its one trial."""


@contextmanager
def small():
    """The paper in two experiments with the robot, of whose conditions each is simulated once, and one of clips."""
    show = play.show

    def once(trial, **more):
        if not isinstance(trial, RobotTrial):
            return show(trial, **more)
        key = trial.condition, trial.settings
        if key not in simulated:
            simulated[key] = show(trial, **{**more, "maps": True})
        return simulated[key]

    answering = {claim: name for name in PLACES for claim in registry.load(name).claims}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(play, "show", once)
        patch.setattr(play, "recording_of", lambda make: b"")
        patch.setattr(registry, "paper_experiments", lambda: PLACES)
        patch.setattr(registry, "answering", lambda: answering)
        patch.setattr(reproduce, "SHOWN", ())
        patch.setattr(reproduce, "SCALES", {"quick": SMALL})
        yield patch


def run(folder, *more):
    with small():
        return inside(folder, (*COMMAND, *more))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("reproduce")
    for name in ("my_experiment.py", "my_model.py"):
        (folder / name).write_text(user_files.FILES[name])
    done = run(folder)
    assert done.returncode == 0, done.stderr
    return folder / "out"


def claims(folder, name="claims"):
    return {claim.id: claim for claim in stored_verdicts(json.loads((folder / f"{name}.json").read_text()))}


def test_every_claim_of_the_registry_has_a_verdict_and_says_why_where_it_has_none(folder):
    found = claims(folder) | claims(folder, "behaviours")
    assert list(found) == list(claim_ids())
    judged = {"C1", "C2", "C3", "C13", "C14", "C15", "C29"}
    assert {claim for claim, verdict in found.items() if verdict.count.judged} == judged
    assert found["C14"].count.replicates == found["C13"].count.replicates == 2, "replicate 0 and another"
    assert all(verdict.outcome.measured for verdict in found.values())
    assert not any(found[claim].count.random for claim in ("C1", "C2", "C3")), "nothing in their clips is random"
    models = pl.read_parquet(folder / "general" / "trials.parquet")["model"]
    assert set(models) == {"dsnn", "dsn2017", "gradient"}, "one's own sees the paper's experiment"
    troughs = pl.read_csv(folder / "general" / "summary.csv").filter(quantity="trough_hs")
    assert troughs["ci_low"].min() < 0.0, "what can be negative is not cut at 0"


def test_the_page_names_each_claim_once_and_needs_nothing_from_outside(folder):
    page = (folder / "report.html").read_text()
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    assert sorted(name for name in ids if name in claim_ids()) == sorted(claim_ids())
    assert "figure-my_experiment" in ids, "an experiment of one's own is shown"
    targets = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert all(target.startswith("data:") or target[1:] in ids for target in targets)
    assert "<script" not in page and "@import" not in page and "url(" not in page
    assert all(re.search(r'\balt="[^"]+"', picture) for picture in re.findall(r"<img [^>]*>", page))


def test_a_resumed_reproduction_equals_an_undisturbed_one(folder):
    """Without an experiment and without clips it runs these again; of a whole one it runs nothing."""
    undisturbed = claims(folder)
    for name in ("general", "clean"):
        shutil.rmtree(folder / name)
    assert run(folder.parent).returncode == 0 and claims(folder) == undisturbed
    written = (folder / "general" / "trials.parquet").stat().st_mtime_ns
    assert run(folder.parent).returncode == 0 and claims(folder) == undisturbed
    assert (folder / "general" / "trials.parquet").stat().st_mtime_ns == written
    other = run(folder.parent, "--seed", "3")
    assert (other.returncode, "seed" in other.stderr) == (2, True)


def test_a_trial_that_fails_is_counted_and_gives_the_status_1(tmp_path):
    def broken(trial, **_):
        raise ValueError("no light")

    with small() as patch:
        patch.setattr(play, "show", broken)
        done = inside(tmp_path, ("reproduce", "--quick", "--robot-only", "--quiet", "--workers", "0", "--out", "out"))
    assert done.returncode == 1 and "no light" in (tmp_path / "out" / "report.html").read_text()
    assert claims(tmp_path / "out")["C13"].count == Count(0, 0, {"not shown": 2})


# The whole plan.


def test_every_experiment_that_declares_a_claim_is_run_and_judges_it():
    where = registry.answering()
    assert set(SENSITIVITY.claims) <= set(where)
    plan = design(2)
    assert {spec.experiment for spec in plan.specs} == set(registry.paper_experiments())
    replicates = every(plan, rows_of(plan.specs))
    found = {verdict.id: verdict for verdict in verdicts(replicates, [])}
    assert set(found) == set(claim_ids(PAPER))
    assert {claim for claim, verdict in found.items() if verdict.experiment} == set(pooled(replicates))
    (empty,) = every(design(1, 1), [])
    assert {judge(claim, empty).verdict for claim in where} == {"not shown"}


def test_each_scale_is_of_whole_replicates_but_the_quick_one():
    assert all(scale.repeats == WHOLE and scale.moves for scale in (USUAL, FULL)) and QUICK.repeats < WHOLE
    parts = plan_of(Asked(kind="reproduction", seed=7)).parts
    others = parts["replicates"].declared
    assert (others.seed, others.study.replicates) == (8, 4), "replicate 0 is not run twice"
    assert len(others.specs) == 4 * sum(len(parts[name].trials) for name in registry.paper_experiments())
