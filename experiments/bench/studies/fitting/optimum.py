"""The result of a fit to measures: the winner or the front, judged anew, and how much of the gain was luck."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.bench.stats.tests import Summary, summarise
from experiments.bench.store.rows import known
from experiments.bench.studies.fitting.fit import Goal
from experiments.bench.studies.fitting.result import FitResult, lost, setting_words
from experiments.bench.studies.fitting.scores import Reading

AS_IS = "as it is"
"""Name of the model without a setting."""


def front(searched: Sequence[Reading], goals: Sequence[Goal]) -> list[int]:
    """Return the places of the settings that none betters: in no goal worse, and in one better.

    Parameters
    ----------
    searched
        The settings.
    goals
        The goals, made large or small.

    Returns
    -------
    list of int
        Those with a value in every goal, the best in the first goal first; of equal ones the first.
    """
    values = [reading.searched(goals) for reading in searched]
    whole = [place for place, row in enumerate(values) if not np.isnan(row).any()]
    order = sorted(whole, key=lambda place: (*(-value for value in values[place]), place))
    chosen: list[int] = []
    for place in order:
        above = (np.asarray(values[other]) >= values[place] for other in chosen)
        if not any(better.all() for better in above):
            chosen.append(place)
    return chosen


@dataclass(frozen=True)
class Optimum(FitResult[Reading]):
    """The result of a fit to measures."""

    @property
    def goals(self) -> tuple[Goal, ...]:
        """The goals of the fit, made large or small."""
        return self.fit.goals

    def luck(self, goal: Goal) -> float | None:
        """Return how much of the winner's value in the search is not there at seeds never searched.

        Parameters
        ----------
        goal
            One of `goals`.

        Returns
        -------
        float or None
            In the goal's unit; above 0 where the search promised too much; ``None`` where a value is not known.
        """
        before, after = self.winner.numbers[goal.name], _mean(self.anew[0], goal)
        return None if after is None or np.isnan(before) else lost(goal.signed(before), goal.signed(after))

    def gain(self, goal: Goal) -> float | None:
        """Return how much better the winner is than the model as it is, both at seeds never searched.

        Parameters
        ----------
        goal
            One of `goals`.

        Returns
        -------
        float or None
            In the goal's unit; above 0 where the winner is better; ``None`` where a value is not known.
        """
        after, start = _mean(self.anew[0], goal), _mean(self.anew[-1], goal)
        return None if after is None or start is None else goal.signed(after - start)

    def sentences(self) -> list[str]:
        """Return the answer in sentences, and beside it what was searched and how often.

        Returns
        -------
        list of str
            Of each goal the winner judged anew beside the model as it is, and how much of the gain was luck; the even
            sample; of several goals the front; what was searched.
        """
        lines = []
        if len(self.goals) > 1:
            names = ", ".join(goal.name for goal in self.goals)
            whole = len(front(self.searched, self.goals))
            lines.append(f"{whole} of {len(self.searched)} settings are the front of {names}: none betters them in"
                         f" all; {len(self.best)} of these are judged anew, and the winner is the best of them in"
                         f" {self.goals[0].name}")  # fmt: skip
        for goal in self.goals:
            lines.append(self._sentence(goal))
        even = "; ".join(self._even(goal) for goal in self.goals)
        lines.append(f"of {len(self.sample)} settings that fill the box evenly: {even}")
        lines.append(self.searched_words())
        return lines

    def _sentence(self, goal: Goal) -> str:
        anew, start = _summary(self.anew[0], goal), _summary(self.anew[-1], goal)
        setting = setting_words(self.winner.setting)
        if anew is None:
            return f"{goal.name}: the winner, {setting}, has no value in {self.fit.held_out} replicates anew"
        words = f"{goal.name}: {setting} has {_text(anew)} in the mean of {anew.n} replicates that it never saw"
        gain, luck = self.gain(goal), self.luck(goal)
        if start is None or gain is None or luck is None:
            return f"{words}; the model {AS_IS} has no value there"
        searched = self.winner.numbers[goal.name]
        parts = f"{searched:.4g} in the search, so {luck:+.3g} of that was luck" if luck > 0 else "as in the search"
        told = anew.ci_low > start.ci_high or anew.ci_high < start.ci_low
        apart = "" if told else ", which these replicates do not tell apart"
        return f"{words} ({parts}); the model {AS_IS} has {_text(start)}: better by {gain:+.3g}{apart}"

    def _even(self, goal: Goal) -> str:
        values = [reading.numbers[goal.name] for reading in self.sample if reading.known(goal.name)]
        values = [value for value in values if np.isfinite(value)]
        if not values:
            return f"{goal.name} has no value"
        best = (min if goal.least else max)(values)
        return f"{goal.name} {best:.4g} at best, {float(np.median(values)):.4g} in the median"

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for every setting of search and sample.

        Returns
        -------
        list of dict
            The values of the setting, and the mean of each measure.
        """
        return [
            {
                "of": name, "number": number, **reading.setting,
                **{measure: known(value) for measure, value in reading.numbers.items()},
            }
            for name, readings in (("search", self.searched), ("sample", self.sample))
            for number, reading in enumerate(readings)
        ]  # fmt: skip

    def anew_rows(self) -> list[dict[str, Any]]:
        """Return a row for each setting that was judged anew and each goal.

        Returns
        -------
        list of dict
            The values of the setting, its number in the search (none of the model as it is), the mean in the search and
            anew, the latter's 95 % interval, and the replicates with a value.
        """
        rows = []
        for number, reading in zip((*self.best, None), self.anew, strict=True):
            for goal in self.goals:
                summary = _summary(reading, goal)
                before = None if number is None else known(self.searched[number].numbers[goal.name])
                setting = {part.key: reading.setting.get(part.key, AS_IS) for part in self.box.ranges}
                rows.append({
                    "number": number, **setting, "goal": goal.name, "in the search": before,
                    "anew": None if summary is None else summary.mean,
                    "low": None if summary is None else known(summary.ci_low),
                    "high": None if summary is None else known(summary.ci_high),
                    "replicates": 0 if summary is None else summary.n,
                })  # fmt: skip
        return rows

    def described(self) -> dict[str, Any]:
        """Return what ``fit.json`` holds.

        Returns
        -------
        dict
            The sentences, the winner, its gain and luck in each goal, the front and importances.
        """
        return {
            "fit": self.fit.study.name, "summary": self.fit.study.summary, "sentences": self.sentences(),
            "seed": self.seed, "goals": {goal.name: "minimise" if goal.least else "maximise" for goal in self.goals},
            "winner": dict(self.winner.setting), "gain": {goal.name: self.gain(goal) for goal in self.goals},
            "luck": {goal.name: self.luck(goal) for goal in self.goals}, "looks": self.looks,
            "front": front(self.searched, self.goals) if len(self.goals) > 1 else [],
            "importance": {name or self.goals[0].name: shares for name, shares in self.importance.items()},
            "failures": self.failures,
        }  # fmt: skip


def _summary(reading: Reading, goal: Goal) -> Summary | None:
    values = reading.known(goal.name)
    return summarise(values) if values else None


def _mean(reading: Reading, goal: Goal) -> float | None:
    summary = _summary(reading, goal)
    return None if summary is None else summary.mean


def _text(summary: Summary) -> str:
    if np.isnan(summary.ci_low) or summary.ci_low == summary.ci_high:
        return f"{summary.mean:.4g}"
    return f"{summary.mean:.4g} [{summary.ci_low:.4g}, {summary.ci_high:.4g}]"
