"""Scores of each looming model from the rows of trials and clips. Pure functions; nothing is run or drawn here."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.bench.engine.alarms import poisson_interval
from experiments.bench.leaderboard.scores import area, condition, frame_time, share
from experiments.bench.stats.clips import SIGNED
from experiments.bench.stats.scores import Score, Standing
from experiments.bench.stats.tests import effective_number

Row = Mapping[str, Any]
LOOMING, RECEDING, TRANSLATION = "looming", "receding", "translation"
GRATING, BACKGROUND = "grating", "background"
"""Kinds of what a row was shown."""

MEASURES = {
    "auc_translation_robot": "AUC, translation, robot",
    "auc_recession_robot": "AUC, recession, robot",
    "auc_translation": "AUC, translation, clips",
    "auc_recession": "AUC, recession, clips",
    "auc_background": "AUC, background, clips",
    "answered": "looming, answered",
    "contact_dark_s": "contact, dark, s",
    "contact_light_s": "contact, light, s",
    "alarms_translation": "alarms/min, translation",
    "alarms_gratings": "alarms/min, gratings",
    "alarms_background": "alarms/min, background",
    "us_99x72": "us, 99x72",
    "us_320x180": "us, 320x180",
}
"""Every measure, with a heading for people: the columns of ``looming.csv``, in their order."""
SORTED_BY = "the mean of the AUCs, then by the share of looming that is answered"


@dataclass(frozen=True, slots=True)
class ShownClip:
    """One clip as one looming model answered it.

    Attributes
    ----------
    row
        Its row in ``trials.parquet``.
    seconds
        How long it lasts.
    alarms
        The number of alarms in it (`experiments.bench.engine.alarms.alarm_count`).
    contact_s
        Time to contact at the first spike of an approach, s; ``None`` without one.
    shade
        ``dark`` or ``light`` of an approach on an even ground along the camera's axis; otherwise empty.
    """

    row: Row
    seconds: float
    alarms: int
    contact_s: float | None = None
    shade: str = ""


def shown(row: Row) -> str:
    """Return what was shown, of a robot's trial or of a clip."""
    if "direction" in row:  # a robot's trial
        return {"approach": LOOMING, "recession": RECEDING}.get(row["motion"], TRANSLATION)
    if row["stimulus"] == "grating":
        return GRATING
    if row["object"] == "absent" or row["motion"] is None:
        return BACKGROUND
    return TRANSLATION if row["motion"] in SIGNED else str(row["motion"])


def separation(rows: Iterable[Row], *others: str) -> Score | None:
    """Area under the ROC curve for looming against the ``others`` by the largest potential; 0.5 is guessing."""
    known = [(shown(row), row) for row in rows]
    looming = [row for what, row in known if what == LOOMING]
    rest = [row for what, row in known if what in others]
    return area(looming, rest, lambda row: float(row["peak_looming"]))


def answered(clips: Iterable[ShownClip]) -> Score | None:
    """Return the share of looming clips with a spike."""
    looming = [clip for clip in clips if shown(clip.row) == LOOMING]
    return share([clip.alarms > 0 for clip in looming], [clip.row for clip in looming])


def time_to_contact(clips: Iterable[ShownClip], shade: str) -> Score | None:
    """Return the time to contact at the first spike, s: median over l/v, and the spread from the least to the largest.

    Approaches without a spike are left out; ``n`` says how many had one. ``None`` where none had.
    """
    times = [clip.contact_s for clip in clips if clip.shade == shade and clip.contact_s is not None]
    return Score(float(np.median(times)), min(times), max(times), len(times)) if times else None


def alarm_rate(clips: Iterable[ShownClip], what: str) -> Score | None:
    """Alarms a minute in the clips that show ``what``, with the exact interval of a Poisson rate.

    The clips of a condition are a cluster: alarms and minutes are scaled to the clips' effective number.
    """
    matching = [clip for clip in clips if shown(clip.row) == what]
    minutes, count = sum(clip.seconds for clip in matching) / 60.0, sum(clip.alarms for clip in matching)
    if not minutes > 0.0:
        return None
    rates, clusters = [clip.alarms / clip.seconds for clip in matching], [condition(clip.row) for clip in matching]
    scale = effective_number(rates, clusters) / len(matching)
    low, high = (end / (minutes * scale) for end in poisson_interval(count * scale))
    return Score(count / minutes, low, high, len(matching))


def scores(
    robot: Sequence[Row], clips: Sequence[ShownClip], us: Mapping[str, Sequence[float]], spikes: bool
) -> dict[str, Score | None]:
    """Return every measure of one looming model, of whose ``robot`` trials and ``clips`` these are all.

    ``us`` has its times by the measure's name, ``spikes`` is true of a model with a threshold on its potential.
    """
    rows = [clip.row for clip in clips]
    fired = clips if spikes else ()
    return {
        "auc_translation_robot": separation(robot, TRANSLATION),
        "auc_recession_robot": separation(robot, RECEDING),
        "auc_translation": separation(rows, TRANSLATION),
        "auc_recession": separation(rows, RECEDING),
        "auc_background": separation(rows, BACKGROUND, GRATING),
        "answered": answered(fired),
        "contact_dark_s": time_to_contact(fired, "dark"),
        "contact_light_s": time_to_contact(fired, "light"),
        "alarms_translation": alarm_rate(fired, TRANSLATION),
        "alarms_gratings": alarm_rate(fired, GRATING),
        "alarms_background": alarm_rate(fired, BACKGROUND),
        **{name: frame_time(us.get(name)) for name in MEASURES if name.startswith("us_")},
    }


def ranked(standings: Iterable[Standing]) -> list[Standing]:
    """Return the scores in the order that `SORTED_BY` tells; equals by name."""

    def place(standing: Standing) -> tuple[float, float, str]:
        areas = [score.value for name, score in standing.scores.items() if name.startswith("auc_") and score]
        hits = standing.scores["answered"]
        return (
            -sum(areas) / len(areas) if areas else math.inf,
            -hits.value if hits is not None else math.inf,
            standing.name,
        )

    return sorted(standings, key=place)
