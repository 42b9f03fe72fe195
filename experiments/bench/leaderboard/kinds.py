"""The two kinds of models that are ranked apart: what each is scored by, how that is told, drawn and written."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from experiments.bench.figures.plotting import Panel
from experiments.bench.leaderboard import looming_scores, scores
from experiments.bench.stats.scores import Standing

_SHOWN = ("robot", "clips")
_TIMES = Panel("time\n(µs per frame)", ("us_99x72", "us_320x180"), ("99x72 px", "320x180 px"), log=True)


@dataclass(frozen=True, slots=True)
class Kind:
    """A part of the leaderboard.

    Attributes
    ----------
    name
        ``direction`` or ``looming``.
    measures
        Measure -> its heading, in the order of the columns of the table.
    ranked
        Sorts standings, the best first.
    panels
        Of the figure.
    tables
        The measures of each table on the terminal; together all of them.
    notes
        What the numbers mean.
    drawn
        What the lines of the figure are.
    table, figure
        Names of the files, the figure's without its ending.
    """

    name: str
    measures: Mapping[str, str]
    ranked: Callable[[Iterable[Standing]], list[Standing]]
    panels: tuple[Panel, ...]
    tables: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...]
    drawn: str
    table: str
    figure: str


@dataclass(frozen=True, slots=True)
class Ranking:
    """The standings of one kind, best first."""

    kind: Kind
    standings: list[Standing]

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of its table: value, ``_low``, ``_high``, ``_n`` of each measure, null for a dash."""
        rows = []
        for standing in self.standings:
            row: dict[str, Any] = {"model": standing.name}
            for name in self.kind.measures:
                score = standing.scores[name]
                values = (None, None, None) if score is None else (score.value, score.low, score.high)
                for end, value in zip(("", "_low", "_high"), values, strict=True):
                    row[f"{name}{end}"] = None if value is None or not math.isfinite(value) else round(value, 6)
                row[f"{name}_n"] = None if score is None else score.n
            rows.append(row)
        return rows


_INTERVALS = (
    "Below each value its 95 % interval: of shares the exact one (Clopper and Pearson), of AUCs Newcombe's, both with "
    "the repeats of a condition as one cluster; of times (medians of rounds) by order statistics."
)

DIRECTION = Kind(
    "direction",
    scores.MEASURES,
    scores.ranked,
    (
        Panel(
            "direction accuracy\n(share of motions)", ("direction_robot", "direction_clips"), _SHOWN, 0.25, share=True
        ),
        Panel("AUC, translation\nagainst depth", ("auc_robot", "auc_clips"), _SHOWN, 0.5, share=True),
        Panel("false alarms (share of\nbackground clips)", ("false_alarms",), _SHOWN[1:], share=True, filled=False),
        _TIMES,
    ),
    (tuple(scores.MEASURES),),
    (
        f"Sorted by {scores.SORTED_BY}.",
        _INTERVALS,
        "Direction: the strongest potential of either system has the right system and sign; two alike are no answer, "
        "so a model that saturates in both gets none right. Guessing gets 0.25.",
        "AUC: translation against motion in depth, by the largest |HS| or |VS|: under 0.5 it prefers depth.",
        "False alarms: clips of background alone that made the model spike. A dash: does not apply, or no answer.",
    ),
    "lines: 95 % intervals",
    "leaderboard.csv",
    "figure",
)

_OF_LOOMING = tuple(looming_scores.MEASURES)
LOOMING = Kind(
    "looming",
    looming_scores.MEASURES,
    looming_scores.ranked,
    (
        Panel("AUC, looming\nagainst translation", ("auc_translation_robot", "auc_translation"), _SHOWN, 0.5,
              share=True),
        Panel("AUC, looming\nagainst recession", ("auc_recession_robot", "auc_recession"), _SHOWN, 0.5, share=True),
        Panel("AUC, looming\nagainst background", ("auc_background",), _SHOWN[1:], 0.5, share=True, filled=False),
        Panel("looming answered\n(share of clips)", ("answered",), _SHOWN[1:], share=True, filled=False),
        Panel("time to contact at\nthe first spike (s)", ("contact_dark_s", "contact_light_s"),
              ("dark", "light; none: no spike")),
        Panel("false alarms\na minute", ("alarms_translation", "alarms_gratings"), ("translation", "gratings")),
        Panel("false alarms a\nminute, background", ("alarms_background",), _SHOWN[1:], filled=False),
        _TIMES,
    ),
    (_OF_LOOMING[:6], _OF_LOOMING[6:]),
    (
        f"Sorted by {looming_scores.SORTED_BY}.",
        f"{_INTERVALS} Of alarms it is that of a Poisson rate.",
        "AUC: looming against translation, recession, and gratings and backgrounds alone, by the largest potential. "
        "Answered: looming clips with a spike.",
        "Contact: time to contact at the first spike, dark and light: median over l/v from 0.04 to 0.32 s, below it "
        "the least and the largest, which is a spread and no interval.",
        "Alarms: spikes after half a second without one, where nothing looms. A dash: does not apply, or no answer.",
    ),
    "lines: 95 % intervals, and times to contact from smallest to largest",
    "looming.csv",
    "looming",
)  # fmt: skip
