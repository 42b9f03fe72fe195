"""Escape reflexes: one for each looming model, all the same reflex; their table of survival."""

import csv
import math

import numpy as np
import pytest

from dsnn import MODELS, Response
from experiments.behaviours import AVOIDANCE, BEHAVIOURS, ESCAPES, GROUPS, escape
from experiments.bench.closed_loop.episode import EpisodeSpec, Setting, play_behaviour
from experiments.bench.closed_loop.power import shares_needed
from experiments.bench.closed_loop.run import plan
from experiments.bench.closed_loop.survival import best_against, published, survival, write
from experiments.bench.closed_loop.table import show_survival
from experiments.bench.run.errors import UsageError
from experiments.bench.stats.scores import Standing
from tests.helpers.episodes import rows


def test_every_looming_model_drives_an_escape():
    looming = [name for name, entry in MODELS.items() if entry.channels == ("looming",)]
    assert [behaviour.model for behaviour in ESCAPES] == looming
    assert GROUPS["escape"] == tuple(f"escape-{name}" for name in looming)
    assert all(BEHAVIOURS[name].env == AVOIDANCE for name in GROUPS["escape"])


def test_the_reflex_is_one_and_the_model_differs():
    loom, silent = Response(looming_spikes=1), Response()
    drives = []
    for behaviour in (*ESCAPES, BEHAVIOURS["lgmd"]):
        policy = behaviour.make(np.random.default_rng(5))
        drives.append([policy(loom if i % 20 == 3 else silent) for i in range(80)])
    assert all(drive == drives[0] for drive in drives)
    sides = {math.copysign(1.0, left) for left, right in drives[0] if left == -right}
    assert sides == {1.0, -1.0}, "to either side"


def test_the_escape_of_lgmd1_is_the_reflex_lgmd():
    one, other = (
        play_behaviour(EpisodeSpec(0, 0, 4, Setting(name, AVOIDANCE, steps=40)), images=False)
        for name in ("lgmd", "escape-lgmd1")
    )
    np.testing.assert_array_equal(one.wheels, other.wheels)


def test_a_model_of_one_s_own_drives_one_too():
    behaviour = escape("models/my_model.py")
    assert (behaviour.name, behaviour.model) == ("escape-my_model", "models/my_model.py")


def test_a_group_is_played_at_the_same_seeds_with_what_it_is_held_against():
    behaviour_plan = plan("escape", None, (), 2, 7, True)
    played = [setting.behaviour for setting in behaviour_plan.settings]
    assert played == [*GROUPS["escape"], "hybrid", "straight"]
    seeds = {
        setting: [s.seed for s in behaviour_plan.specs() if s.condition == setting]
        for setting in behaviour_plan.settings
    }
    assert set(map(tuple, seeds.values())) == {(7, 8)}
    assert [setting.behaviour for setting in plan("escape", None, (), 1, 0, False).settings] == list(GROUPS["escape"])
    with pytest.raises(UsageError, match="is a group of behaviours"):
        plan("escape", None, (), 1, 0, True, "lgmd")


def test_survival_has_exact_intervals_and_is_sorted_by_collisions():
    played = [Standing("escape-a", {}, rows(5, 15)), Standing("hybrid", {}, rows(0, 20)),
              Standing("escape-b", {}, rows(20, 0, metres=0.1))]  # fmt: skip
    survivals = {entry.name: entry for entry in survival(played, "hybrid")}
    assert list(survivals) == ["hybrid", "escape-a", "escape-b"]
    assert survivals["hybrid"].survived.low == pytest.approx(0.025 ** (1 / 20)), "Clopper and Pearson's end of 20 in 20"
    assert (survivals["escape-a"].survived.value, survivals["escape-a"].per_metre.value) == (0.75, 0.25)
    assert survivals["hybrid"].ratio is None and survivals["escape-a"].ratio.value == math.inf
    assert survivals["escape-b"].row()["survived"] == 0.0 and survivals["hybrid"].row()["ratio"] is None


def test_the_table_of_survival_is_printed_and_written(tmp_path, capsys):
    standings = [Standing(name, {}, rows(hits, 20 - hits)) for name, hits in (("escape-lplc2", 9), ("hybrid", 2))]
    survivals = survival(standings, "hybrid")
    show_survival(survivals, "escape", write(tmp_path, survivals))
    printed = " ".join(capsys.readouterr().out.split())
    assert "B2 asked of the best of them: escape-lplc2 against hybrid: 4.5" in printed and "not judged" in printed
    with (tmp_path / "survival.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [(row["behaviour"], row["episodes"], row["survived"]) for row in table] == [
        ("hybrid", "20", "0.9"), ("escape-lplc2", "20", "0.55"),
    ]  # fmt: skip
    assert table[0]["ratio"] == "" and float(table[1]["ratio"]) == pytest.approx(4.5)


@pytest.mark.parametrize(
    ("hits", "message"), [((2, 12), "so too"), ((2, 3), "not shown"), ((0, 0), "neither collided")]
)
def test_b2_is_asked_of_the_best_beside(hits, message):
    played = [Standing("hybrid", {}, rows(hits[0], 20 - hits[0], metres=4.0)),
              Standing("escape-a", {}, rows(hits[1], 20 - hits[1])),
              Standing("escape-b", {}, rows(20, 0, metres=0.1))]  # fmt: skip
    told = best_against(survival(played, "hybrid"), ("escape-a", "escape-b"), "hybrid")
    assert "best of them: escape-a" in told and message in told
    assert best_against(survival(played[1:], "hybrid"), ("escape-a",), "hybrid") == ""


def test_published_rates_need_over_a_thousand_encounters():
    """By simulation: with so many of each, the usual test of two shares has a power of four in five."""
    needed = shares_needed(0.961, 0.937)
    assert needed > 1000 and f"{needed:,} encounters" in published(20)
    rng = np.random.default_rng(0)
    first, second = (rng.binomial(needed, share, 4000) / needed for share in (0.961, 0.937))
    middle = (first + second) / 2
    apart = np.abs(first - second) / np.sqrt(2 * middle * (1 - middle) / needed) > 1.96
    assert 0.77 < apart.mean() < 0.83
