"""Scores of several training seeds together: the interquartile mean, with a stratified-bootstrap interval. Pure.

A run is one training seed. Its score is one number: the mean of a measure over the episodes that judged the policy.
That is how Agarwal et al. have it, whose scores are a matrix of runs and tasks; a task here is an env. The strata of
the bootstrap are the tasks: runs are drawn anew, with replacement, within each of them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from experiments.bench.run.streams import stream
from experiments.bench.stats.scores import Score, Standing
from experiments.bench.store.rows import known

CUT = 0.25
"""The share of the scores that is left out at either end."""
RESAMPLES = 50_000
CONFIDENCE = 0.95

TRAINED = "PPO"
"""Name of all trained policies of a study together."""


def interquartile_mean(scores: npt.ArrayLike, seed: int) -> Score:
    """Return the mean of the middle half of all scores, with its 95 % interval over training seeds.

    Of N scores the int(N / 4) lowest and as many highest are left out: of five runs of one task, one each. The interval
    has the percentiles of resamples, in which runs are drawn with replacement within each task. It says how far the
    number may move when the same training begins with other seeds. It says nothing of other worlds: all runs are
    judged in the same ones. Of few runs it is too narrow, as no resample goes beyond the scores there are.

    Parameters
    ----------
    scores
        (runs, tasks), or (runs,) of one task: a score per training seed and task. Those of several tasks must be on
        one scale.
    seed
        Of the stream ``bootstrap.training``, 0 or more.

    Returns
    -------
    Score
        ``n`` is the number of runs. Of one run there is no interval: NaN.

    Raises
    ------
    ValueError
        There is no run, or a score is no number.

    References
    ----------
    Agarwal, Schwarzer, Castro, Courville and Bellemare 2021, Deep reinforcement learning at the edge of the statistical
    precipice, NeurIPS 34: interquartile mean, and percentile intervals by stratified bootstrap.
    """
    from scipy import stats

    runs = np.asarray(scores, float)
    if not runs.size or not np.isfinite(runs).all():
        raise ValueError(f"scores of shape {runs.shape}: legal are finite numbers of one run or more")
    tasks = runs.reshape(len(runs), -1).T

    def aggregate(*samples: npt.NDArray[np.float64], axis: int = -1) -> npt.NDArray[np.float64]:
        return np.asarray(stats.trim_mean(np.concatenate(samples, axis=axis), CUT, axis=axis))

    value = float(aggregate(*tasks))
    if tasks.shape[1] < 2:
        return Score(value, math.nan, math.nan, tasks.shape[1])
    interval = stats.bootstrap(
        tuple(tasks), aggregate, n_resamples=RESAMPLES, method="percentile", confidence_level=CONFIDENCE,
        vectorized=True, rng=stream("bootstrap.training", seed),
    ).confidence_interval  # fmt: skip
    return Score(value, float(interval.low), float(interval.high), tasks.shape[1])


def of_runs(runs: Sequence[Standing], measure: str) -> list[float]:
    """Return the score of each training seed by one of its env's measures: the mean over its episodes.

    Parameters
    ----------
    runs
        The policy of each training seed, as it was judged.
    measure
        The name of the measure.
    """
    scores = [run.scores.get(measure) for run in runs]
    return [score.value for score in scores if score is not None]


def together(runs: Sequence[Standing], seed: int) -> Standing:
    """Return all training seeds as one: the interquartile mean of each measure.

    Parameters
    ----------
    runs
        The policy of each training seed, as it was judged; one or more.
    seed
        Of the bootstrap, 0 or more.
    """
    scores_by_measure = {measure: of_runs(runs, measure) for measure in runs[0].scores}
    return Standing(
        TRAINED, {name: interquartile_mean(scores, seed) for name, scores in scores_by_measure.items() if scores}
    )


def rows(
    standings: Sequence[Standing], env: str, episodes: int, made_by: Mapping[str, object]
) -> list[dict[str, object]]:
    """Return the rows of ``policies.csv``: one per behaviour and measure.

    Parameters
    ----------
    standings
        The policies of all training seeds `together`, and their opponents.
    env, episodes
        Where each was judged, and in how many episodes.
    made_by
        Columns that say how the policies were trained.
    """
    return [
        {
            "env": env, "behaviour": standing.name, "measure": name,
            "statistic": "interquartile mean" if standing.name == TRAINED else "mean",
            "interval_over": "training seeds" if standing.name == TRAINED else "episodes",
            "value": score.value, "ci_low": known(score.low), "ci_high": known(score.high), "n": score.n,
            "episodes": episodes, **made_by,
        }
        for standing in standings
        for name, score in standing.scores.items()
        if score is not None
    ]  # fmt: skip
