"""How many episodes a comparison of collisions takes: the power of the very interval that judges it."""

import math

import numpy as np
import polars as pl
import pytest
from scipy import stats

from experiments.behaviours import AVOIDANCE
from experiments.bench.closed_loop import claims as closed_loop_claims
from experiments.bench.closed_loop import table
from experiments.bench.closed_loop.power import Pilot, episodes_needed, pilot, power
from experiments.bench.closed_loop.run import Played
from experiments.bench.closed_loop.run import plan as planned
from experiments.bench.closed_loop.scores import STEP_SCHEMA, rate_ratio
from experiments.bench.reproduce import FULL, QUICK, USUAL
from experiments.bench.run.errors import UsageError
from experiments.bench.stats.scores import Standing
from tests.helpers.chapters import ROOT
from tests.helpers.episodes import judged, rows

RARER, OTHER = Pilot(4, 250.0, 60), Pilot(19, 200.0, 60)


def summed(rarer, other, bound, episodes):
    """The power by the interval of `rate_ratio` itself, over every pair of counts that is likely at all."""
    chances = [stats.poisson(behaviour.collisions * episodes / behaviour.episodes) for behaviour in (other, rarer)]
    metres = [behaviour.metres * episodes / behaviour.episodes for behaviour in (other, rarer)]
    total = 0.0
    for more in range(int(chances[0].isf(1e-9)) + 1):
        for fewer in range(int(chances[1].isf(1e-9)) + 1):
            sides = [
                [{"touched": i < count, "driven_m": length / max(count, 1)} for i in range(max(count, 1))]
                for count, length in zip((more, fewer), metres, strict=True)
            ]
            if rate_ratio(*sides).low > bound:
                total += chances[0].pmf(more) * chances[1].pmf(fewer)
    return total


def needed(bound=1.0, target=0.8):
    return episodes_needed(RARER, OTHER, bound, target)


@pytest.mark.parametrize(("bound", "episodes"), [(1.0, 20), (1.0, 60), (2.0, 50)])
def test_the_power_is_that_of_the_interval_which_judges(bound, episodes):
    assert power(RARER, OTHER, bound, episodes) == pytest.approx(summed(RARER, OTHER, bound, episodes), abs=1e-6)


def test_the_power_is_that_of_scipys_exact_binomial_test():
    """Equal stretches and a bound of 1: the collisions of one side are half of all, by chance; one-sided 2.5 %."""
    rarer, other = Pilot(3, 100.0, 30), Pilot(12, 100.0, 30)
    sides = stats.poisson(12.0), stats.poisson(3.0)
    expected = sum(
        sides[0].pmf(more) * sides[1].pmf(fewer)
        for more in range(1, 45)
        for fewer in range(25)
        if stats.binomtest(more, more + fewer, 0.5, "greater").pvalue < 0.025
    )
    assert power(rarer, other, 1.0, 30) == pytest.approx(expected, abs=1e-8)


def test_the_power_is_the_share_of_simulated_experiments_that_show_it():
    """Collisions come at a constant rate a metre; an episode ends with its first, or after 5 m: no Poisson counts."""
    rng, rates, whole, episodes = np.random.default_rng(3), (0.1, 0.02), 5.0, 50
    successes, pilots = 0, []
    for rate in rates:
        hits = 1.0 - math.exp(-rate * whole)
        pilots.append(Pilot(round(1e6 * hits), 1e6 * hits / rate, 1_000_000))
    for _ in range(400):
        sides = []
        for rate in rates:
            until = rng.exponential(1.0 / rate, episodes)
            sides.append([{"touched": x < whole, "driven_m": min(x, whole)} for x in until])
        successes += rate_ratio(*sides).low > 1.0
    low, high = stats.binomtest(successes, 400).proportion_ci(0.999)
    assert 0.3 < power(pilots[1], pilots[0], 1.0, episodes) < 0.99, "a power that could be wrong either way"
    assert low - 0.03 < power(pilots[1], pilots[0], 1.0, episodes) < high + 0.03


def test_the_number_needed_is_the_first_with_the_power():
    first = needed()
    assert power(RARER, OTHER, 1.0, first) >= 0.8 > power(RARER, OTHER, 1.0, first - 1)
    assert all(power(RARER, OTHER, 1.0, n) >= 0.8 for n in range(first, first + 40))
    assert needed(bound=2.0) > first, "a stricter bound takes more"
    assert needed(target=0.95) > first


def test_equal_rates_are_shown_as_seldom_as_the_interval_errs():
    """Either end of an exact 95 % interval misses in 2.5 % at most, however many episodes there are."""
    assert 0.0 < power(OTHER, OTHER, 1.0, 60) < 0.025
    assert episodes_needed(OTHER, OTHER, 1.0) is None


def test_a_pilot_that_says_nothing_is_refused():
    assert pilot(rows(2, 3, metres=2.0)) == Pilot(2, 10.0, 5)
    for wrong in ((1, 0.0, 3), (4, 1.0, 3), (-1, 1.0, 3), (0, 1.0, 0), (0, math.nan, 3)):
        with pytest.raises(ValueError, match="legal are"):
            Pilot(*wrong)


# B2.


def test_a_full_reproduction_has_the_episodes_that_b2_takes_and_others_say_how_few_they_have():
    assert FULL.episodes >= closed_loop_claims.lgmd_episodes() > USUAL.episodes > QUICK.episodes
    assert FULL.steps is None, "whole episodes, as the pilot's"


def test_b2_says_where_it_is_underpowered():
    enough = closed_loop_claims.lgmd_episodes()
    played = {"hybrid": rows(1, 19, metres=4.0, seconds=60.0), "lgmd": rows(12, 8, metres=3.0, seconds=60.0)}
    assert judged(**played)["B2"].decided.endswith(f"(needs above 1); underpowered: 20 of {enough} episodes")
    many = {"hybrid": rows(1, enough - 1, seconds=60.0), "lgmd": rows(12, enough - 12, seconds=60.0)}
    assert "underpowered" not in judged(**many)["B2"].decided
    half = {name: [row | {"seconds": 30.0} for row in side] for name, side in many.items()}
    note = f"underpowered: {enough} of {enough} episodes, of 30 s in place of 60"
    assert judged(**half)["B2"].decided.endswith(note)
    few = {name: side[:5] for name, side in played.items()}
    assert "underpowered" not in judged(**few)["B2"].decided, "it is not judged, which is told"


def test_the_documentation_has_the_numbers_of_the_pilot():
    text = (ROOT / "docs" / "behaviours-and-training.md").read_text()
    hybrid, lgmd = closed_loop_claims.PILOT["hybrid"], closed_loop_claims.PILOT["lgmd"]
    for sentence in (
        f"the hybrid collided {hybrid.collisions} times in {hybrid.metres} m, and LGMD alone {lgmd.collisions} times in"
        f" {lgmd.metres} m: a ratio of rates of {lgmd.rate / hybrid.rate:.3g} [",
        f"B2 takes {closed_loop_claims.lgmd_episodes()} episodes of each",
        "| power | " + " | ".join(f"{power(hybrid, lgmd, 1.0, n):.0%}"[:-1] + " %" for n in (10, 20, 33, 60, 120)),
        f"The {FULL.episodes} episodes of `colias reproduce --full` suffice",
    ):
        assert sentence in text, sentence
    sides = [
        [
            {"touched": i < behaviour.collisions, "driven_m": behaviour.metres / behaviour.episodes}
            for i in range(behaviour.episodes)
        ]
        for behaviour in (lgmd, hybrid)
    ]
    low = rate_ratio(*sides).low
    nearer = Pilot(round(1e6 * lgmd.rate / low * hybrid.length), 1e6 * hybrid.length, 1_000_000)
    assert f"if the ratio were {low:.3g}, the lower end" in text
    assert f"that takes {episodes_needed(nearer, lgmd, 1.0)}." in text


# The command.


@pytest.mark.parametrize(
    ("name", "other", "message"),
    [
        (
            "optomotor",
            "still",
            "--power still: Optomotor-v0 counts no collisions; legal is a behaviour in Avoidance-v0",
        ),
        ("hybrid", "hybrid", "--power hybrid: that is the behaviour itself; legal is another one"),
        ("hybrid", "hybird", "no behaviour 'hybird'"),
    ],
)
def test_wrong_uses_of_power_are_refused(name, other, message):
    with pytest.raises(UsageError) as caught:
        planned(name, None, (), 3, 0, True, other)
    assert str(caught.value).startswith(message) and "\n" not in str(caught.value)


def test_a_pilot_plays_the_other_in_place_of_the_baselines():
    behaviour_plan = planned("hybrid", None, ("robots=3",), 3, 1000, True, "lgmd")
    assert [setting.behaviour for setting in behaviour_plan.settings] == ["hybrid", "lgmd"]
    assert {setting.options for setting in behaviour_plan.settings} == {(("robots", 3),)}


def test_the_power_is_told_from_the_episodes_played_as_a_pilot(tmp_path, capsys):
    """The command itself runs in tests/docs/test_docs_behaviours.py."""
    sides = {"hybrid": rows(4, 56, metres=250 / 60), "lgmd": rows(19, 41, metres=200 / 60)}
    standings = [Standing(name, {}, side) for name, side in sides.items()]
    table.show_power(Played(tmp_path, AVOIDANCE, standings, pl.DataFrame(schema=STEP_SCHEMA), []), "lgmd")
    output = " ".join(capsys.readouterr().out.split())
    assert "hybrid: 4 collisions in 250.0 m, 60 episodes lgmd: 19 collisions in 200.0 m, 60 episodes" in output
    assert f"that hybrid collides less often a metre than lgmd, by a whole 95 % interval: {needed()} episodes" in output
    assert f"{power(RARER, OTHER, 1.0, 60):.0%} with 60" in output
    few = [standings[0], Standing("lgmd", {}, rows(0, 9))]
    with pytest.raises(UsageError, match="--power lgmd: it touched nothing in 9 episodes"):
        table.show_power(Played(tmp_path, AVOIDANCE, few, pl.DataFrame(schema=STEP_SCHEMA), []), "lgmd")
