"""Ask Optuna for settings, batch by batch, and tell it their values.

The sampler is made anew for each batch, seeded by the seed of the fit and the batch's number, and batches are asked
and told in their order. So equal seeds give equal settings, whatever plays them; and a fit that was cut short asks
again for what it had, and finds it played.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import optuna

from experiments.bench.studies.fitting.box import Box, Range
from experiments.bench.studies.fitting.fit import Goal, Sampler
from experiments.bench.studies.fitting.scores import Reading, Score


class Search:
    """Settings of a box, chosen by a sampler in batches.

    Parameters
    ----------
    box
        Where to search.
    seed
        Of the fit.
    renderings, share
        Settings of the renderings in a batch, and settings of the network that share each.
    sampler
        ``tpe``: the tree-structured Parzen estimator; ``random``: every value alike.
    goals
        The goals, made large or small.
    """

    def __init__(
        self, box: Box, seed: int, renderings: int, share: int, sampler: Sampler, goals: Sequence[Goal]
    ) -> None:
        optuna.logging.set_verbosity(optuna.logging.WARNING)
        self._box, self._seed, self._renderings, self._share = box, seed, renderings, share
        self._sampler, self._goals = sampler, goals
        self.study = optuna.create_study(directions=["maximize"] * len(goals))
        self._free = {part.key: _distribution(part) for part in box.ranges}
        self._asked: list[Any] = []
        self._batch = 0

    def ask(self) -> list[dict[str, str]]:
        """Return the settings of the next batch.

        Returns
        -------
        list of dict
            Key -> value; those that share a rendering one after another.
        """
        state = np.random.SeedSequence(self._seed, spawn_key=(self._batch,)).generate_state(1)
        self.study.sampler = _SAMPLERS[self._sampler](int(state[0]))
        self._asked = []
        for _ in range(self._renderings):
            first = self.study.ask(self._free)
            self._asked.append(first)
            outside = {part.key: first.params[part.key] for part in self._box.outside}
            for _ in range(self._share - 1):
                if outside:
                    self.study.enqueue_trial(outside)
                self._asked.append(self.study.ask(self._free))
        self._batch += 1
        return [{part.key: part.text(trial.params[part.key]) for part in self._box.ranges} for trial in self._asked]

    def tell(self, scores: Sequence[Score | Reading]) -> None:
        """Tell the values of the last batch's settings, in their order; a setting without a value counts as failed."""
        for trial, score in zip(self._asked, scores, strict=True):
            for name, number in score.numbers.items():
                trial.set_user_attr(name, number)
            values = score.searched(self._goals)
            failed = any(map(np.isnan, values))
            self.study.tell(trial, None if failed else values, state=_FAILED if failed else None)

    def importance(self, name: str = "") -> Mapping[str, float]:
        """Return the share of each parameter in whether the first goal, a claim or a measure is among the best tenth.

        Parameters
        ----------
        name
            Id of a claim, or a measure; empty: the first goal.

        Returns
        -------
        mapping of str to float
            Key -> share; all 0 where every setting came to the same. By PED-ANOVA (Watanabe, Bansal and Hutter 2023).
        """
        sign = -1.0 if any(goal.name == name and goal.least for goal in self._goals) else 1.0

        def number(trial: Any) -> float:
            return sign * float(trial.user_attrs[name] if name else trial.values[0])

        if len({number(trial) for trial in self.study.get_trials(deepcopy=False) if trial.state != _FAILED}) < 2:
            return dict.fromkeys(self._free, 0.0)
        with warnings.catch_warnings():
            warnings.filterwarnings("ignore", "PedAnova.*low `target`", UserWarning)  # it is given the slack below 0
            shares = optuna.importance.get_param_importances(
                self.study, evaluator=optuna.importance.PedAnovaImportanceEvaluator(),
                target=lambda trial: -number(trial),
            )  # fmt: skip
        return {key: float(shares.get(key, 0.0)) for key in self._free}


def version() -> str:
    """Return Optuna's version, which settings depend on."""
    return str(optuna.__version__)


_FAILED = optuna.trial.TrialState.FAIL
_SAMPLERS: Mapping[str, Any] = {
    "tpe": lambda seed: optuna.samplers.TPESampler(seed=seed, constant_liar=True),
    "random": lambda seed: optuna.samplers.RandomSampler(seed=seed),
}


def _distribution(part: Range) -> Any:
    if part.choices:
        return optuna.distributions.CategoricalDistribution(part.choices)
    if part.whole:
        return optuna.distributions.IntDistribution(int(part.low), int(part.high), log=part.log)
    return optuna.distributions.FloatDistribution(part.low, part.high, log=part.log)
