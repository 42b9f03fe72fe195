"""Every claim that ships: one file each, complete, and found without being named anywhere else."""

import sys

import pytest

import experiments
import experiments.claims
from experiments.bench import registry
from experiments.bench.clips.claims import ClipClaim
from experiments.bench.robot.claims import RobotClaim, outcome
from experiments.bench.robot.experiment import CONDITION_COLUMNS
from experiments.bench.run.errors import UsageError
from experiments.bench.stats.claim_files import BEHAVIOURS, PAPER, claim_ids, claim_module
from experiments.bench.stats.claims import declared, find, of_kind, words
from experiments.bench.stats.paper import cited
from experiments.claims.readings import READINGS

EVERY = (*experiments.NAMES, *experiments.OFFLINE)

NEW = """
from experiments.bench.clips.claims import ClipClaim
from experiments.bench.stats.verdict import Outcome


def judge(rows, threshold):
    return Outcome.unjudged("nothing was shown")


CLAIM = ClipClaim(id="C99", title="A new one", says="it is new", source="simu-clean", judge=judge)
"""


ON_ROBOT = """
from experiments import Check, Claim, Outcome


def judge(rows, threshold):
    fewest = min(row["spikes"] for row in rows)
    return Outcome.of([Check(f"{fewest} spikes", fewest, 0)])


CLAIM = Claim(id="C99", title="A new one", says="it spikes", judge=judge)
"""


def test_the_claims_are_those_of_the_paper_and_four_of_ours():
    assert claim_ids(PAPER) == tuple(f"C{number}" for number in range(1, 32))
    assert claim_ids(BEHAVIOURS) == tuple(f"B{number}" for number in range(1, 5))
    assert claim_ids() == (*claim_ids(PAPER), *claim_ids(BEHAVIOURS))


@pytest.mark.parametrize("claim", claim_ids())
def test_a_file_says_all_of_its_claim(claim):
    first, *others = declared(claim)
    assert not others or claim == "C24", "judged on clips and on the robot"
    for other in others:
        assert (other.says, other.source, other.title) == (first.says, first.source, first.title)
        assert type(other) is not type(first)
    assert first.says and 0 < len(first.title) <= 40
    assert cited(first.source) != first.source or claim in claim_ids(BEHAVIOURS), "a figure or equation of the paper"
    experiment, draws = first.mechanism
    assert (experiment in EVERY and draws) or not (experiment or draws)
    assert bool(first.tried) == bool(first.cause), "why it fails is told where it is told what was tried"
    for declaration in (first, *others):
        assert declaration.judge.__module__ == claim_module(claim).__name__ and not declaration.own
        assert declaration.judge.__doc__.startswith("Judge"), "how the words are read"


def test_every_reading_is_complete():
    for reading in READINGS:
        assert all((reading.says, reading.taken, reading.others, reading.note))
        assert set(reading.claims) <= set(claim_ids(PAPER)) and (reading.used or not reading.of_all)


@pytest.fixture
def new_file(tmp_path, monkeypatch):
    """A claim more in a folder that the package has too, as if it stood beside the others."""
    (tmp_path / "c99_new.py").write_text(NEW)
    monkeypatch.setattr(experiments.claims, "__path__", [*experiments.claims.__path__, str(tmp_path)])
    yield
    sys.modules.pop("experiments.claims.c99_new", None)


def test_a_new_file_is_found_and_nothing_else_is_edited(new_file):
    assert claim_ids(PAPER)[-1] == "C99" and words("C99").title == "A new one"
    assert find("C99", ClipClaim).says == "it is new" and "C99" in of_kind(ClipClaim)
    assert "C99" not in of_kind(RobotClaim)
    with pytest.raises(ValueError, match="one of the paper's claims has that id"):
        experiments.Claim(id="C99", says="mine", judge=lambda rows, threshold: None)


def test_a_new_claim_on_the_robot_counts_its_trials_as_a_claim_of_one_s_own_does(new_file, tmp_path):
    """Its judge may be as plain as the documentation's: it need not say how many trials it read."""
    (tmp_path / "c99_new.py").write_text(ON_ROBOT)
    trial = {"motion": "translation", "direction": "rightward", "speed_cm_s": 8.0, "distance_cm": 6.0, "angle_deg": 0.0}
    trial |= {"spikes": 3, "achieved_speed_cm_s": 8.0, "path_error_mm": 0.0}
    rows = [trial | {name: None for name in CONDITION_COLUMNS if name not in trial} for _ in range(4)]
    assert outcome("C99", rows, 0.2).verdict == "holds"
    assert "needs at least 4 trials" in outcome("C99", rows[:3], 0.2).measured


@pytest.mark.parametrize(("name", "claim"), [("speed", "C1"), ("clean", "C15"), ("clean", "B1"), ("speed", "C77")])
def test_a_claim_that_rows_of_that_kind_cannot_answer_for_is_refused(name, claim):
    from dataclasses import replace

    experiment = replace(registry.find(name), claims=(claim,))
    with pytest.raises(UsageError, match=f"claim '{claim}'"):
        registry.check_claims(experiment, "mine.py")
