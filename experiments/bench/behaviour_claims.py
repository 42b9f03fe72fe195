"""Claims of our own about behaviours, judged on episodes. A claim holds where its whole 95 % interval does."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from colias_sim.envs import ENVS
from experiments.behaviours import AVOIDANCE, FIXATION, OPTOMOTOR
from experiments.bench.behave import BehaviourPlan, Standing
from experiments.bench.episode_scores import Row, Score, mean, rate, rate_ratio
from experiments.bench.episodes import Setting
from experiments.bench.paper import tried
from experiments.bench.results import mixture

PLAYED: Mapping[str, tuple[str, ...]] = {
    AVOIDANCE: ("hybrid", "lgmd", "lgmd-hybrid", "straight"),
    OPTOMOTOR: ("optomotor", "still", "told-heading"),
    FIXATION: ("fixation", "still", "told-target"),
}
"""Env -> who plays there for the report."""

LEAST_SEEDS = 20
"""Seeds that each behaviour of a claim is played at, below which it is untested: the worlds vary that much."""


@dataclass(frozen=True, slots=True)
class BehaviourClaim:
    """A claim's answer; ``measured`` has the numbers with their intervals, ``n`` counts episodes.

    ``decided`` has the end of the interval that decided, and its bound.
    """

    id: str
    says: str
    verdict: Literal["holds", "fails", "untested"]
    measured: str
    n: int
    env: str
    limits: str = ""
    """If it does not hold, what limits it."""
    decided: str = ""


Episodes = Mapping[str, Sequence[Row]]
"""Behaviour -> its rows."""


def plans(episodes: int, seed: int, steps: int | None = None) -> list[BehaviourPlan]:
    """What the claims need: every behaviour at the same seeds, for ``steps`` frames, or fewer if the env says so."""
    made = []
    for env, names in PLAYED.items():
        whole = ENVS[env].max_episode_steps
        frames = whole if steps is None else min(steps, whole)
        made.append(BehaviourPlan(tuple(Setting(name, env, steps=frames) for name in names), episodes, seed))
    return made


def judge(standings: Sequence[Standing]) -> list[BehaviourClaim]:
    """Every claim, on the episodes there are."""
    by_env: dict[str, dict[str, Sequence[Row]]] = {}
    for standing in standings:
        by_env.setdefault(standing.env, {})[standing.behaviour] = standing.rows
    claims = [_explained(claim(by_env)) for claim in (_b1, _b2, _b3, _b4)]
    return [_admitting(claim, by_env.get(claim.env, {})) for claim in claims]


def _admitting(claim: BehaviourClaim, played: Episodes) -> BehaviourClaim:
    """The claim saying too, if several did, which code played the episodes."""
    mixed = mixture([row for rows in played.values() for row in rows])
    return replace(claim, measured=f"{claim.measured}; {mixed}") if mixed else claim


def _explained(claim: BehaviourClaim) -> BehaviourClaim:
    return replace(claim, limits=tried().get(claim.id, "")) if claim.verdict == "fails" else claim


def _b1(by_env: Mapping[str, Episodes]) -> BehaviourClaim:
    says = "hybrid avoidance collides at least 5 times less often per metre than the straight drive"
    return _rarer("B1", says, by_env.get(AVOIDANCE, {}), "straight", 5.0)


def _b2(by_env: Mapping[str, Episodes]) -> BehaviourClaim:
    says = "hybrid avoidance collides less often per metre than LGMD alone"
    played = by_env.get(AVOIDANCE, {})
    claim = _rarer("B2", says, played, "lgmd", 1.0)
    if claim.verdict == "untested" or not played.get("lgmd-hybrid"):
        return claim
    blind = rate_ratio(played["lgmd-hybrid"], played["hybrid"])
    said = f"the hybrid without direction, a side by chance, {_hits(played['lgmd-hybrid'])}: {blind} times"
    return replace(claim, measured=f"{claim.measured}; {said}")


def _b3(by_env: Mapping[str, Episodes]) -> BehaviourClaim:
    says = "the optomotor reflex's gain is above 0.5"
    return _above("B3", says, OPTOMOTOR, by_env, "optomotor", "optomotor_gain", 0.5)


def _b4(by_env: Mapping[str, Episodes]) -> BehaviourClaim:
    says = "fixation keeps the target in view 80 % of the time"
    return _above("B4", says, FIXATION, by_env, "fixation", "in_view", 0.8)


def _rarer(claim: str, says: str, played: Episodes, against: str, times: float) -> BehaviourClaim:
    own, other = played.get("hybrid", ()), played.get(against, ())
    if not own or not other:
        return BehaviourClaim(claim, says, "untested", f"needs episodes of hybrid and {against}", 0, AVOIDANCE)
    ratio = rate_ratio(other, own)
    measured = (
        f"hybrid {rate(own, 'driven_m')} collisions a metre ({_hits(own)}), {against} {rate(other, 'driven_m')}"
        f" ({_hits(other)}): {ratio} times"
    )
    made = BehaviourClaim(claim, says, "untested", measured, len(own) + len(other), AVOIDANCE)
    return _judged(made, ratio, times, {"hybrid": own, against: other})


def _above(
    claim: str, says: str, env: str, by_env: Mapping[str, Episodes], name: str, column: str, bound: float
) -> BehaviourClaim:  # fmt: skip
    rows = [row for row in by_env.get(env, {}).get(name, ()) if row[column] is not None]
    score = mean(rows, column)
    if score is None:
        return BehaviourClaim(claim, says, "untested", f"needs episodes of {name}", 0, env)
    return _judged(BehaviourClaim(claim, says, "untested", f"{score}", len(rows), env), score, bound, {name: rows})


def _judged(claim: BehaviourClaim, score: Score, bound: float, played: Episodes) -> BehaviourClaim:
    """A claim with its verdict: it holds where the whole interval of ``score`` is above ``bound``."""
    seeds = {name: len({row["seed"] for row in rows}) for name, rows in played.items()}
    if min(seeds.values()) < LEAST_SEEDS:
        has = ", ".join(f"{count} of {name}" for name, count in seeds.items())
        why = f"needs episodes at {LEAST_SEEDS} seeds or more of each behaviour (has {has})"
    elif math.isnan(score.value) or math.isnan(score.low):
        why = "the measure is no number: no episode collided, or one has none"
    else:
        said = f"lower end of the 95 % interval {score.low:.3g} (needs above {bound:g})"
        return replace(claim, verdict="holds" if score.low > bound else "fails", decided=said)
    return replace(claim, measured=f"{why}; measured: {claim.measured}")


def _hits(rows: Sequence[Row]) -> str:
    metres = sum(row["driven_m"] for row in rows)
    return f"{sum(bool(row['touched']) for row in rows)} in {metres:.1f} m"
