"""Scores of episodes with their 95 % intervals, comparisons at equal seeds, and claims about behaviours.

Every table here has rows of a run's ``trials.parquet``; functions of one behaviour get the rows of that alone.
"""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import partial

import polars as pl

from colias_sim.envs import ENVS, RETURN
from colias_sim.envs.measures import FREE_DISTANCE, PER_METRE, PER_MINUTE
from experiments.declare.claim import Claim
from experiments.declare.outcome import Check, Outcome
from experiments.judge.tests import Score, poisson_interval, proportion_interval, summarise
from experiments.judge.verdict import Verdict, verdict_of
from experiments.show.episodes import COLUMNS
from experiments.store.tables import finite

SUMMARY = pl.Schema(
    {"env": str, "behaviour": str, "measure": str, "episodes": int, "value": float, "ci_low": float, "ci_high": float}
)
"""Columns of ``summary.csv``."""
LEAST_SEEDS = 20
"""Seeds that each behaviour of a claim is played at, below which it is not judged: the worlds vary that much."""


def mean(rows: pl.DataFrame, column: str) -> Score | None:
    """Return the mean over episodes, with its interval; ``None`` where the env has no such measure.

    The interval keeps to what the column can be: the mean of shares is at most 1.
    """
    values = rows[column].drop_nulls().to_list()
    return summarise(values, *COLUMNS.get(column, ())) if values else None


def mean_difference(first: pl.DataFrame, second: pl.DataFrame, column: str) -> Score | None:
    """Return by how much a column of the ``first`` exceeds that of the ``second``, a mean over the seeds of both.

    Episodes of equal seed are in equal worlds, so what differs between worlds cancels in their difference. ``None``
    where no seed has both.
    """
    one, other = (rows.select("seed", column).drop_nulls() for rows in (first, second))
    both = one.join(other, on="seed", suffix="_other").sort("seed")
    return summarise((both[column] - both[f"{column}_other"]).to_list()) if both.height else None


def collisions(rows: pl.DataFrame) -> int:
    """Return how many episodes ended by touching something."""
    return int(rows["touched"].sum())


def rate(rows: pl.DataFrame, per: str, unit: float = 1.0) -> Score:
    """Return collisions per ``unit`` of a column's sum, with the exact interval of a Poisson rate (Garwood 1936).

    Every episode ends with its first collision, so they come one by one out of a stretch that is as long as it took.
    """
    count, stretch = collisions(rows), sum(rows[per]) / unit
    if not stretch > 0.0:  # or no number
        return Score(math.nan, math.nan, math.nan, rows.height)
    low, high = poisson_interval(count)
    return Score(count / stretch, low / stretch, high / stretch, rows.height)


def free_distance(rows: pl.DataFrame) -> Score:
    """Return metres driven per collision: the rate's reciprocal, without an upper end where nothing was touched."""
    a_metre = rate(rows, "driven_m")
    value, low, high = (math.inf if end == 0.0 else 1.0 / end for end in (a_metre.value, a_metre.high, a_metre.low))
    return Score(value, low, high, a_metre.n)


OF_COLLISIONS: Mapping[str, Callable[[pl.DataFrame], Score]] = {
    PER_MINUTE: partial(rate, per="seconds", unit=60.0),
    PER_METRE: partial(rate, per="driven_m"),
    FREE_DISTANCE: free_distance,
}
"""The scores of `colias_sim.envs.measures.COLLISIONS`."""


def survival(rows: pl.DataFrame) -> Score:
    """Return the share of episodes without a collision, with its exact interval (Clopper and Pearson 1934)."""
    unharmed = rows.height - collisions(rows)
    return Score(unharmed / rows.height, *proportion_interval(unharmed, rows.height), rows.height)


def rate_ratio(first: pl.DataFrame, second: pl.DataFrame) -> Score:
    """Return how many times more often a metre the ``first`` collide than the ``second``, with the exact interval.

    Given their sum, the count of the first is binomial, its chance set by the ratio and the two stretches.
    """
    counts = [collisions(rows) for rows in (first, second)]
    stretches = [sum(rows["driven_m"]) for rows in (first, second)]
    total = sum(counts)
    if total == 0 or not all(stretch > 0.0 for stretch in stretches):  # or no number
        return Score(math.nan, math.nan, math.nan, first.height + second.height)
    scale = stretches[1] / stretches[0]
    ends = (counts[0] / total, *proportion_interval(counts[0], total))
    value, low, high = (math.inf if end == 1.0 else scale * end / (1.0 - end) for end in ends)
    return Score(value, low, high, total)


def scores(rows: pl.DataFrame, env: str) -> dict[str, Score]:
    """Return every measure that an env declares, and the return, of one behaviour's episodes."""
    values = {measure: mean(rows, column) for measure, column in ENVS[env].measures.items()}
    values |= {measure: OF_COLLISIONS[measure](rows) for measure in ENVS[env].collisions}
    values[RETURN] = mean(rows, "reward")
    return {name: value for name, value in values.items() if value is not None}


def summary(trials: pl.DataFrame, env: str, reference: str) -> pl.DataFrame:
    """Return a run's summary: a row per behaviour and measure.

    Where collisions count, two measures are added: the share of episodes without one, and how many times more often a
    metre a behaviour collides than the ``reference``.
    """
    played = {model: rows for (model,), rows in trials.group_by("model", maintain_order=True)}
    table = []
    for name, rows in played.items():
        measured = scores(rows, env)
        if ENVS[env].collisions:
            measured["without collision"] = survival(rows)
            if reference in played and name != reference:
                measured[f"collisions/m, times {reference}"] = rate_ratio(rows, played[reference])
        table += [
            {"env": env, "behaviour": name, "measure": measure, "episodes": rows.height, "value": finite(score.value),
             "ci_low": finite(score.low), "ci_high": finite(score.high)}
            for measure, score in measured.items()
        ]  # fmt: skip
    return pl.DataFrame(table, SUMMARY)


# --- claims -----------------------------------------------------------------------------------------------------------


def verdicts(claims: Iterable[Claim], env: str, behaviours: Collection[str], trials: pl.DataFrame) -> list[Verdict]:
    """Judge those of the ``claims`` whose behaviours were played in an env. All episodes together are one replicate."""
    judged = []
    for claim in claims:
        if env in claim.conditions["env"] and claim.models <= set(behaviours):
            missing = claim.models - set(trials["model"])
            outcome = Outcome.unjudged(f"needs episodes of {' and '.join(sorted(claim.models))}")
            outcome = outcome if missing else claim.evaluate(trials)
            judged.append(verdict_of(claim, [outcome], experiment=env))
    return judged


def held(measured: str, asked: Sequence[tuple[Score, Check]], sides: Mapping[str, pl.DataFrame]) -> Outcome:
    """Judge scores by a check of each, where every behaviour has enough seeds and every score is a number."""
    n = sum(rows.height for rows in sides.values())
    seeds = {name: rows["seed"].n_unique() for name, rows in sides.items()}
    if min(seeds.values()) < LEAST_SEEDS:
        has = ", ".join(f"{count} of {name}" for name, count in seeds.items())
        why = f"needs episodes at {LEAST_SEEDS} seeds or more of each behaviour (has {has})"
        return Outcome.unjudged(f"{why}; measured: {measured}", n=n)
    if any(math.isnan(score.value) or math.isnan(score.low) for score, _ in asked):
        why = "the measure is no number: no episode collided, or one has none"
        return Outcome.unjudged(f"{why}; measured: {measured}", n=n)
    return Outcome.of([check for _, check in asked], measured, n=n)
