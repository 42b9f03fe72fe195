"""Claims of our own about behaviours, judged on episodes. A claim holds where its whole 95 % interval does."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import ClassVar

from colias_sim.envs import ENVS
from experiments.behaviours import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.bench.closed_loop.episode import Setting
from experiments.bench.closed_loop.power import MOST_EPISODES, Pilot, episodes_needed
from experiments.bench.closed_loop.run import BehaviourPlan, Played
from experiments.bench.closed_loop.scores import Row, mean, mean_difference, rate, rate_ratio, scores
from experiments.bench.stats.checks import Check
from experiments.bench.stats.claim import Claim, of_kind
from experiments.bench.stats.scores import Score
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.rows import mixture

PLAYED: Mapping[str, tuple[str, ...]] = {
    AVOIDANCE: ("hybrid", "lgmd", "lgmd-hybrid", "straight"),
    OPTOMOTOR: ("optomotor-pi", "optomotor", "still", "oracle-heading"),
    FIXATION: ("fixation-pi", "fixation", "still", "oracle-target"),
}
"""Env -> who plays there for the report."""

LEAST_SEEDS = 20
"""Seeds that each behaviour of a claim is played at, below which it is not judged: the worlds vary that much."""

PILOT: Mapping[str, Pilot] = {
    "hybrid": Pilot(collisions=14, metres=543.05, episodes=120),
    "lgmd": Pilot(collisions=50, metres=394.73, episodes=120),
}
"""What B2's number of episodes is computed from: whole episodes at seeds 1000 to 1119, which no reproduction judges.

``colias behave hybrid --power lgmd --seed 1000 --episodes 120`` plays them and prints these numbers.
"""
FRAMES_A_SECOND = 30
LGMD_RATIO = 1.0
"""B2's bound: LGMD alone over the hybrid, in collisions a metre."""

Episodes = Mapping[str, Sequence[Row]]
"""Behaviour -> its rows."""


def plans(episodes: int, seed: int, steps: int | None = None) -> list[BehaviourPlan]:
    """Plan what the claims need: every behaviour at the same seeds, for ``steps`` frames, or fewer in a shorter env."""
    behaviour_plans = []
    for env, names in PLAYED.items():
        whole = ENVS[env].max_episode_steps
        frames = whole if steps is None else min(steps, whole)
        behaviour_plans.append(BehaviourPlan(tuple(Setting(name, env, steps=frames) for name in names), episodes, seed))
    return behaviour_plans


def judge(by_env: Mapping[str, Episodes]) -> list[Verdict]:
    """Judge every claim on the episodes there are: env -> behaviour -> rows."""
    return [_verdict(claim, by_env.get(claim.env, {})) for claim in claims().values()]


def episodes(played: Sequence[Played]) -> dict[str, Episodes]:
    """Return what was played as env -> behaviour -> rows."""
    return {run.env: {standing.name: standing.rows for standing in run.standings} for run in played}


def _verdict(claim: BehaviourClaim, played: Episodes) -> Verdict:
    """Return the verdict, saying too which code played if several did. All episodes together are one replicate."""
    mixed = mixture([row for rows in played.values() for row in rows])
    return Verdict.of(claim, [claim.judge(played).noting([mixed])], experiment=claim.env)


def rarer(played: Episodes, against: str, times: float) -> Outcome:
    """Judge whether ``hybrid`` collides less often per metre than ``against``, by more than ``times``."""
    hybrid, other = played.get("hybrid", ()), played.get(against, ())
    if not hybrid or not other:
        return Outcome.unjudged(f"needs episodes of hybrid and {against}")
    ratio = rate_ratio(other, hybrid)
    measured = (
        f"hybrid {rate(hybrid, 'driven_m')} collisions a metre ({collisions_text(hybrid)}), "
        f"{against} {rate(other, 'driven_m')} ({collisions_text(other)}): {ratio} times"
    )
    asked = Check(f"lower end of the 95 % interval {ratio.low:.3g}", ratio.low, times)
    return _judged(measured, [(ratio, asked)], {"hybrid": hybrid, against: other})


@cache
def lgmd_episodes() -> int:
    """Episodes of each behaviour that B2 takes for a power of 80 %, by the `PILOT`; see `episodes_needed`."""
    return episodes_needed(PILOT["hybrid"], PILOT["lgmd"], LGMD_RATIO) or MOST_EPISODES


def underpowered_text(played: Episodes) -> str:
    """Return what is to be said of B2 where its episodes are too few, or too short, for a power of 80 %.

    Episodes that are cut short are worth as many whole ones as they are long together.
    """
    sides = [played["hybrid"], played["lgmd"]]
    whole = ENVS[AVOIDANCE].max_episode_steps / FRAMES_A_SECOND
    longest = max(row["seconds"] for rows in sides for row in rows)  # some episode goes on to the end
    there, needed = min(len(rows) for rows in sides), lgmd_episodes()
    if there * min(longest / whole, 1.0) >= needed:
        return ""
    short = f", of {longest:.0f} s in place of {whole:.0f}" if longest < whole else ""
    return f"; underpowered: {there} of {needed} episodes{short}"


def better_than_still(
    played: Episodes, env: str, name: str, column: str, bound: float, rms: str, beside: Sequence[str] = ()
) -> Outcome:
    """Judge whether a behaviour has a ``column`` above a bound, a smaller RMS than a still robot, and a higher return.

    Each of the three holds where its whole 95 % interval does. The last two are of differences at equal seeds, so in
    equal worlds.

    Parameters
    ----------
    played
        The episodes in ``env``, those of ``still`` among them.
    env, name
        Where they are played, and the behaviour that is judged.
    column, bound
        What is to be above the bound, in the mean over episodes.
    rms
        Column of a root mean square, the less the better.
    beside
        Behaviours of which the same numbers are told.
    """
    rows = {other: [row for row in played.get(other, ()) if row[column] is not None] for other in (name, "still")}
    seeds = set.intersection(*({row["seed"] for row in known} for known in rows.values()))
    rows = {other: [row for row in known if row["seed"] in seeds] for other, known in rows.items()}
    level = mean(rows[name], column)
    smaller = mean_difference(rows["still"], rows[name], rms)
    more = mean_difference(rows[name], rows["still"], "reward")
    if level is None or smaller is None or more is None:
        return Outcome.unjudged(f"needs episodes of {name} and still at equal seeds")
    told = [other for other in (name, *beside, "still") if played.get(other)]
    measured = "; ".join(_measured(other, played, env, rms) for other in told)
    names = {measure.column: measure.name for measure in ENVS[env].all_measures}
    asked = (
        (names[column], level, bound),
        (f"{names[rms]} below that of still", smaller, 0.0),
        ("return above that of still", more, 0.0),
    )
    checks = [
        # Their units differ: each slack is a share of its own mean.
        (score, Check(f"{what}: lower end of the 95 % interval {score.low:.3g}", score.low, least,
                      scale=abs(score.value) or 1.0))
        for what, score, least in asked
    ]  # fmt: skip
    return _judged(measured, checks, rows)


def _measured(name: str, played: Episodes, env: str, rms: str) -> str:
    """Return the scores of a behaviour in words, and by how much it is better than a still robot at equal seeds."""
    rows, still = played[name], played.get("still", ())
    told = ", ".join(f"{measure} {score}" for measure, score in scores(rows, env).items())
    if name == "still":
        return f"{name}: {told}"
    smaller, more = mean_difference(still, rows, rms), mean_difference(rows, still, "reward")
    return f"{name}: {told} (RMS below still's by {smaller}, return above it by {more})"


def _judged(measured: str, asked: Sequence[tuple[Score, Check]], played: Episodes) -> Outcome:
    """Judge scores by a check of each, where every behaviour has enough seeds and every score is a number."""
    n = sum(len(rows) for rows in played.values())
    seeds = {name: len({row["seed"] for row in rows}) for name, rows in played.items()}
    if min(seeds.values()) < LEAST_SEEDS:
        has = ", ".join(f"{count} of {name}" for name, count in seeds.items())
        why = f"needs episodes at {LEAST_SEEDS} seeds or more of each behaviour (has {has})"
        return Outcome.unjudged(f"{why}; measured: {measured}", n=n)
    if any(math.isnan(score.value) or math.isnan(score.low) for score, _ in asked):
        why = "the measure is no number: no episode collided, or one has none"
        return Outcome.unjudged(f"{why}; measured: {measured}", n=n)
    return Outcome.of([check for _, check in asked], measured, n=n)


def collisions_text(rows: Sequence[Row]) -> str:
    """Return how many episodes collided in how many metres, in words."""
    metres = sum(row["driven_m"] for row in rows)
    return f"{sum(bool(row['touched']) for row in rows)} in {metres:.1f} m"


@dataclass(frozen=True, kw_only=True)
class BehaviourClaim(Claim):
    """A claim about behaviours in one env.

    Parameters
    ----------
    env
        The env's id.
    judge
        From behaviour -> its episodes' rows in that env, to an `Outcome`.
    """

    module: ClassVar[str] = "behaviours"

    env: str
    judge: Callable[[Episodes], Outcome]


def claims() -> Mapping[str, BehaviourClaim]:
    """Return our own claims, by id. The paper's are about open loops."""
    return of_kind(BehaviourClaim)
