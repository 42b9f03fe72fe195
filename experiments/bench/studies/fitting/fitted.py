"""The result of a fit to claims, in numbers, tables and sentences."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.bench.stats.count import LEAST_JUDGED, Count
from experiments.bench.studies.fitting.result import FitResult, lost, setting_words
from experiments.bench.studies.fitting.scores import Score, word
from experiments.bench.sweep import TOGETHER


@dataclass(frozen=True)
class Fitted(FitResult[Score]):
    """The result of a fit to claims."""

    @property
    def claims(self) -> tuple[str, ...]:
        """Ids of the claims."""
        return tuple(self.searched[0].outcomes)

    @property
    def share(self) -> Count:
        """The count of the sample's settings in which every claim is kept: the share of the box, with its interval."""
        kept = sum(score.holds for score in self.sample)
        return Count(kept, len(self.sample) - kept)

    @property
    def word(self) -> str:
        """The verdict on the winner: ``fitted``; ``not fitted``; or ``no word``, of too few replicates judged anew."""
        counted = self.anew[0].count()
        if self.winner.holds and counted.word == "holds":
            return "fitted"
        few = counted.kind == "counted" and not counted.fails
        return "no word" if self.winner.holds and few else "not fitted"

    @property
    def luck(self) -> float:
        """The part of the winner's least slack, in the mean of replicates, that is lost at seeds never searched."""
        return lost(float(np.mean(self.winner.least)), float(np.mean(self.anew[0].least)))

    def pairs(self) -> list[dict[str, Any]]:
        """Return of each pair of claims in how many settings each is kept, and both: of search and sample together.

        Returns
        -------
        list of dict
            ``claim``, ``other``, ``kept``, ``other kept``, ``both``, ``settings``.
        """
        every = (*self.searched, *self.sample)
        kept = {claim: {n for n, score in enumerate(every) if score.holds_claim(claim)} for claim in self.claims}
        return [
            {"claim": one, "other": other, "kept": len(kept[one]), "other kept": len(kept[other]),
             "both": len(kept[one] & kept[other]), "settings": len(every)}
            for one, other in itertools.combinations(self.claims, 2)
        ]  # fmt: skip

    def exclusions(self) -> list[dict[str, Any]]:
        """Return those `pairs` of which each is kept in some setting, and both in none.

        Returns
        -------
        list of dict
            As of `pairs`.
        """
        return [pair for pair in self.pairs() if pair["kept"] and pair["other kept"] and not pair["both"]]

    def sentences(self) -> list[str]:
        """Return the answer in sentences, and beside it what was searched and how often.

        Returns
        -------
        list of str
            The share of the box; the winner judged anew, and how much of it was luck; claims that exclude each other;
            what was searched.
        """
        share, (low, high) = self.share, self.share.interval or (0.0, 1.0)
        number, of = len(self.searched), len(self.sample)
        all_kept = f"all {len(self.claims)} claims are kept" if len(self.claims) > 1 else f"{self.claims[0]} is kept"
        lines = [
            f"in {share.holds} of {of} settings that fill the box evenly {all_kept}: {_percent(share.holds / of)} of"
            f" the box, 95 % interval {_percent(low)} to {_percent(high)}"
        ]
        anew, setting = self.anew[0], setting_words(self.winner.setting)
        if not self.winner.holds:
            broken = ", ".join(claim for claim in self.claims if not self.winner.holds_claim(claim))
            lines.append(f"not fitted: none of the {number} settings searched keeps all; the best, {setting}, breaks"
                         f" {broken} in the search")  # fmt: skip
        elif self.word == "fitted":
            lines.append(f"fitted: {setting}; all is kept in {anew.count()} replicates that the search never saw")
        elif self.word == "no word":
            lines.append(f"no word: {setting} keeps all in the search, and in {anew.count()} replicates that it never"
                         f" saw; a word needs {LEAST_JUDGED}")  # fmt: skip
        else:
            few = {claim: anew.count(claim) for claim in self.claims if word(anew.count(claim)) != "fitted"}
            parts = "; ".join(f"{claim} {counted}" for claim, counted in few.items())
            lines.append(f"not fitted: {setting} keeps all in the search, but in {anew.count()} replicates that it"
                         f" never saw{f' ({parts})' if len(self.claims) > 1 else ''}")  # fmt: skip
        before, after = np.mean(self.winner.least), np.mean(anew.least)
        lines.append(
            f"the least slack of that setting is {before:+.3g} smallest differences in the search and {after:+.3g} in"
            f" the mean of {len(anew.least)} replicates anew: {max(self.luck, 0.0):.3g} of it was luck"
        )
        for pair in self.exclusions():
            lines.append(f"{pair['claim']} and {pair['other']} exclude each other: kept in {pair['kept']} and in"
                         f" {pair['other kept']} of {pair['settings']} settings, both in none")  # fmt: skip
        lines.append(self.searched_words())
        return lines

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for every setting of search and sample.

        Returns
        -------
        list of dict
            The values of the setting, how many claims it keeps, and the slacks.
        """
        return [
            {
                "of": name, "number": number, **score.setting, "kept": sum(map(score.holds_claim, self.claims)),
                "claims": len(self.claims), "least slack": score.value,
                **{f"slack {claim}": min(slacks) for claim, slacks in score.slacks.items()},
            }
            for name, scores in (("search", self.searched), ("sample", self.sample))
            for number, score in enumerate(scores)
        ]  # fmt: skip

    def anew_rows(self) -> list[dict[str, Any]]:
        """Return a row for each setting that was judged anew and each claim, and all claims together.

        Returns
        -------
        list of dict
            The values of the setting, the count with its interval and word, and the slacks in the search and anew.
        """
        rows = []
        for number, score in zip(self.best, self.anew, strict=True):
            for claim in ("", *self.claims) if len(self.claims) > 1 else self.claims:
                counted = score.count(claim)
                low, high = counted.interval or (None, None)
                before = self.searched[number]
                rows.append({
                    "number": number, **score.setting, "claim": claim or TOGETHER, "kept": counted.holds,
                    "replicates": counted.replicates, "low": low, "high": high, "word": word(counted),
                    "slack in the search": float(np.mean(before.slacks[claim] if claim else before.least)),
                    "slack anew": float(np.mean(score.slacks[claim] if claim else score.least)),
                })  # fmt: skip
        return rows

    def described(self) -> dict[str, Any]:
        """Return what ``fit.json`` holds.

        Returns
        -------
        dict
            The word, the sentences, the share of the box, the winner, pairs of claims and importances.
        """
        low, high = self.share.interval or (None, None)
        return {
            "fit": self.fit.study.name, "summary": self.fit.study.summary, "word": self.word,
            "sentences": self.sentences(), "claims": list(self.claims), "seed": self.seed,
            "share": {"kept": self.share.holds, "of": len(self.sample), "low": low, "high": high},
            "winner": dict(self.winner.setting), "luck": self.luck, "looks": self.looks,
            "importance": {claim or TOGETHER: shares for claim, shares in self.importance.items()},
            "pairs": self.pairs(), "failures": self.failures,
        }  # fmt: skip


def _percent(share: float) -> str:
    return f"{share:.1%}".replace(".0%", "%").replace("%", " %")
