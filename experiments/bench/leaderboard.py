"""The leaderboard: every model on the same robot trials and the clips of its board, scored and ranked.

There are two boards. *Direction* ranks the models that respond by HS or VS, *looming* those with a looming potential.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from dsnn.stimuli.looming import Looming
from experiments.bench import offline, trials
from experiments.bench.report.terminal import error_console
from experiments.bench.run.description import begin_whole
from experiments.bench.run.files import Files
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import ModelRunner, one_thread
from experiments.bench.run.runs import Batch
from experiments.bench.run.settings import watchers
from experiments.bench.run.workers import Workers
from experiments.bench.sources.clips import Clip, OfflineExperiment
from experiments.bench.sources.experiment import Angular, Design, Experiment, Listed, Translation
from experiments.bench.sources.judge import SIGNED
from experiments.bench.stats.tests import (
    Score,
    first_alarm_s,
    poisson_interval,
    proportion_interval,
)
from experiments.claims.clips import answer
from experiments.clips import EXTREMES, LONG_EDGE_AHEAD, SHADES

DIRECTION, LOOMING = "direction", "looming"
FILES = {DIRECTION: "leaderboard", LOOMING: "looming"}
"""Board -> name of its table and its figure, without their endings."""
ROBOT_SHAPE = (72, 99)
APART_S = 0.5
"""Silence that ends an alarm, s: a detector spikes several times in a row, and an animal begins one escape. A reflex of
this bench turns away for 0.4 s.
"""
TIMES = {"us_99x72": ROBOT_SHAPE, "us_320x180": (180, 320)}
"""Measure of time -> the shape of the frames, (R, C)."""
LABELS = {
    "direction_robot": "direction accuracy, robot", "direction_clips": "direction accuracy, clips",
    "auc_robot": "AUC, translation against depth, robot", "auc_clips": "AUC, translation against depth, clips",
    "false_alarms": "share of background clips with spikes",
    "auc_translation_robot": "AUC, looming against translation, robot",
    "auc_recession_robot": "AUC, looming against recession, robot",
    "auc_translation": "AUC, looming against translation, clips",
    "auc_recession": "AUC, looming against recession, clips",
    "auc_background": "AUC, looming against background, clips",
    "answered": "share of looming clips with spikes",
    "contact_dark_s": "time to contact, dark (s)",
    "contact_light_s": "time to contact, light (s)",
    "alarms_translation": "false alarms, translation (1/min)", "alarms_gratings": "false alarms, gratings (1/min)",
    "alarms_background": "false alarms, background (1/min)",
    "us_99x72": "time per frame of 99x72 (µs)", "us_320x180": "time per frame of 320x180 (µs)",
}  # fmt: skip
"""Measure -> its words in a figure."""
CHANCE = {"direction_": 0.25, "auc_": 0.5}
"""Beginning of a measure -> what guessing gets."""
RANKED_BY = {DIRECTION: ("direction_", "auc_"), LOOMING: ("auc_", "answered")}
"""Board -> beginnings of measures: ranked by the mean of the first, equal models by that of the second."""
NOTE = (
    "Next to a score: its 95 % interval, with the repeats of a condition as one cluster; of a time to contact,"
    " the median over l/v, the smallest and the largest."
)

REPEATS = 5
ROUNDS, BLOCK = 40, 4
"""Times that each model is timed, and frames in each time."""
TRANSLATION, DEPTH = tuple(SIGNED), ("looming", "receding")
SPEEDS_CM_S, DISTANCES_CM = (4.0, 6.0, 10.0), (6.0, 10.0)
L_OVER_V_S = (0.04, 0.08, 0.16, 0.32)
FRAME = {"rows": 72, "columns": 99}
SQUARE = {"width": 25.0, "height": 25.0}
PHOTOGRAPH = {"background": "photograph", "background_speed": -8.0}
"""Windows of one photograph, in all repeats, shifting left within the paper's -2 .. -10 px/s."""
BEHIND = {
    "grey": 40.0, "background_grey": 127.5, "background": "grating", "contrast": 0.4, "temporal_hz": 2.0,
}  # fmt: skip
JITTER_PX = 0.3
GREYS = {shade: {"grey": grey, "background_grey": ground} for shade, (grey, ground) in SHADES.items()}

DESIGNS: tuple[Design, ...] = (
    Translation(SPEEDS_CM_S, DISTANCES_CM, "both"),
    *(Angular("approach", (0.0,), speed_cm_s=speed) for speed in SPEEDS_CM_S),
    *(Angular("recession", (0.0,), speed_cm_s=speed) for speed in SPEEDS_CM_S),
)
"""Twelve crossings, three straight approaches and recessions at the same speeds."""
ROBOT = Experiment(
    name="robot",
    summary="crossings at 4, 6, 10 cm/s, at 6 and 10 cm; straight approach and recession at the same speeds",
    design=Listed(tuple(condition for design in DESIGNS for condition in design.conditions())),
    varies="speed_cm_s",
    repeats=REPEATS,
)


def clip_experiments(board: str, models: Sequence[str]) -> tuple[OfflineExperiment, OfflineExperiment]:
    """Return the clips of a board: on an even ground, where nothing is random, and before what moves.

    Parameters
    ----------
    board
        `DIRECTION` has clips of 320x180 px, `LOOMING` of 99x72 px through the robot's lens.
    models
        Names, or paths of files.
    """
    even, moving = {DIRECTION: (_direction_even, _direction_moving), LOOMING: (_looming_even, _looming_moving)}[board]
    return (
        OfflineExperiment(f"{board}-even", f"{board}, on an even ground", tuple(even()), tuple(models)),
        OfflineExperiment(
            f"{board}-moving", f"{board}, before what moves", tuple(moving()), tuple(models), (), REPEATS
        ),
    )


def _clip(name: str, stimulus: str, *changes: Mapping[str, Any], jitter_px: float = 0.0, **more: Any) -> Clip:
    merged = {key: value for part in (*changes, more) for key, value in part.items()}
    return Clip(name, stimulus, tuple(merged.items()), jitter_px)


def _rectangle(name: str, stimulus: str, motion: str, **changes: Any) -> Clip:
    """Return a clip of a rectangle as long across its way in every direction of motion."""
    width, height = LONG_EDGE_AHEAD.get(motion, (50.0, 90.0))
    return _clip(name, stimulus, changes, motion=motion, width=width, height=height)


def _direction_even() -> Iterator[Clip]:
    """Yield 24 clips: dark and light, four directions at two speeds, looming and receding in two times."""
    for (shade, greys), motion, speed in product(GREYS.items(), TRANSLATION, (120.0, 240.0)):
        yield _rectangle(f"{shade} {motion} {speed:g} px/s", "plain", motion, speed=speed, **greys)
    for (shade, greys), motion, long_s in product(GREYS.items(), DEPTH, (1.0, 2.0)):
        yield _rectangle(f"{shade} {motion} in {long_s:g} s", "plain", motion, duration_s=long_s, **greys)


def _direction_moving() -> Iterator[Clip]:
    """Yield 12 clips of rectangles before a shifting photograph, and 4 of backgrounds alone."""
    for (shade, grey), motion in product(EXTREMES.items(), (*TRANSLATION, *DEPTH)):
        yield _rectangle(f"{shade} {motion}", "cluttered", motion, grey=grey, columns=320, **PHOTOGRAPH)
    yield from _backgrounds({"columns": 320, "object": "absent"}, {})


def _looming_even() -> Iterator[Clip]:
    """Yield 48 clips: dark and light squares, looming and receding ahead and off the axis, crossing at three speeds."""
    for shade, greys in GREYS.items():
        for motion, ratio in product(DEPTH, L_OVER_V_S):
            yield _clip(f"{shade} {motion} {ratio:g} s", "looming", greys, motion=motion, l_over_v_s=ratio)
        for motion, angle in product(DEPTH, (-20.0, 20.0)):
            aside = {"motion": motion, "l_over_v_s": 0.16, "azimuth_deg": angle}
            yield _clip(f"{shade} {motion} {angle:+g} deg", "looming", greys, aside)
        for way, speed in product(TRANSLATION, (30.0, 60.0, 120.0)):
            yield _clip(f"{shade} {way} {speed:g} px/s", "plain", FRAME, SQUARE, greys, motion=way, speed=speed)


def _looming_moving() -> Iterator[Clip]:
    """Yield 32 clips: squares before a grating and before a photograph, gratings alone, backgrounds alone for 5 s."""
    for motion, ratio in product(DEPTH, L_OVER_V_S):
        yield _clip(f"{motion} {ratio:g} s before a grating", "looming", BEHIND, motion=motion, l_over_v_s=ratio)
    for (shade, grey), motion in product(EXTREMES.items(), (*DEPTH, *TRANSLATION)):
        square = {**FRAME, **SQUARE, "motion": motion, "speed": 60.0, "grey": grey}
        yield _clip(f"{shade} {motion} before clutter", "cluttered", PHOTOGRAPH, square)
    for rate, angle in product((2.0, 4.0), (0.0, 90.0, 180.0, 270.0)):
        grating = {**FRAME, "period_px": 16.0, "temporal_hz": rate, "direction_deg": angle}
        yield _clip(f"grating {rate:g} Hz {angle:g} deg", "grating", grating)
    long = {**FRAME, "duration_s": 5.0, "rest_s": 0.0}
    yield from _backgrounds({**long, "object": "absent", "motion": "looming"}, long)


def _backgrounds(photograph: Mapping[str, Any], foliage: Mapping[str, Any]) -> Iterator[Clip]:
    """Yield a panning camera, a trembling one, and leaves in the wind: every spike is a false alarm."""
    yield _clip("shift left", "cluttered", photograph, PHOTOGRAPH)
    yield _clip("shift right", "cluttered", photograph, PHOTOGRAPH, background_speed=8.0)
    yield _clip("jitter", "cluttered", photograph, PHOTOGRAPH, background_speed=0.0, jitter_px=JITTER_PX)
    yield _clip("foliage", "foliage", foliage)


Boards = Mapping[str, Sequence[Batch[Any]]]
"""What is to be run: ``robot``, the trials of all models, and of each board that has models the clips."""


def plan(models: Sequence[str], repeats: int | None, seed: int) -> Boards:
    """Plan the robot's trials of all models, and the clips of each board that has models.

    A model stands on every board that it has a channel for, and on that of direction if it has none.

    Parameters
    ----------
    models
        Names, or paths of files.
    repeats
        Repeats of all that is random; ``None``: `REPEATS`.
    seed
        Seed of the whole run.

    Raises
    ------
    UsageError
        Something cannot be run.
    """
    robot = trials.plan(ROBOT, models, (), REPEATS if repeats is None else repeats, seed)
    channels = {text: {*watchers((text,), ())[0][0].channels} for text in models}
    boards = {
        DIRECTION: [text for text, has in channels.items() if {"hs", "vs"} & has or "looming" not in has],
        LOOMING: [text for text, has in channels.items() if "looming" in has],
    }
    planned: dict[str, list[Batch[Any]]] = {ROBOT.name: [robot]}
    for board, names in boards.items():
        for experiment in clip_experiments(board, names) if names else ():
            clips = offline.plan(experiment, experiment.models, (), repeats if experiment.repeats > 1 else None, seed)
            planned.setdefault(board, []).append(clips)
    return planned


RESPONSES = pl.Schema({
    "model": pl.String, "condition": pl.String, "shown": pl.String, "right": pl.Boolean, "strength": pl.Float64,
    "looming": pl.Float64, "spiked": pl.Boolean, "seconds": pl.Float64, "alarms": pl.Int64, "contact_s": pl.Float64,
})  # fmt: skip
"""Columns of what `response` returns."""


def response(row: Mapping[str, Any], trial: Any, frames: pl.DataFrame | None) -> dict[str, Any]:
    """Return what a model responded to a trial or clip: what scores are computed from.

    Parameters
    ----------
    row
        Of ``trials.parquet``.
    trial
        The job that the row is of.
    frames
        The model's rows of ``frames.parquet``; ``None`` where they were not kept, as of the robot's trials.

    Returns
    -------
    dict
        ``condition``, which is the same in all repeats; what was ``shown``: a direction, ``looming``, ``receding``,
        ``grating`` or ``background``; whether the direction is ``right``; the largest |HS| or |VS| as ``strength`` and
        the largest potential of ``looming``; whether any channel ``spiked``, ``None`` of a model without thresholds.
        Of clips the number of looming ``alarms`` in their ``seconds``, and the time to contact at the first, where one
        is approached.
    """
    if "direction" in row:  # a robot's trial
        shown = {"approach": "looming", "recession": "receding"}.get(row["motion"], str(row["direction"]))
    elif row["stimulus"] == "grating":
        shown = "grating"
    else:
        shown = "background" if row["object"] == "absent" or row["motion"] is None else str(row["motion"])
    counts = [row[name] for name in ("hs_spikes", "vs_spikes", "looming_spikes") if row[name] is not None]
    found = {
        "model": row["model"], "condition": f"{row['experiment']} {trial.label()}", "shown": shown,
        "right": answer(row) == shown, "strength": max(sign * row[column] for column, sign in SIGNED.values()),
        "looming": row["peak_looming"], "spiked": any(counts) if counts else None,
    }  # fmt: skip
    if frames is None or row["looming_spikes"] is None:
        return found | dict.fromkeys(("seconds", "alarms", "contact_s"))
    spikes, clip = frames["looming_spikes"].to_numpy(), trial.condition.build(trial.seed)
    contact_s = first_alarm_s(spikes, clip.contact_s()) if isinstance(clip, Looming) else None
    alarms = alarm_count(spikes, row["fps"])
    return found | {"seconds": row["frames"] / row["fps"], "alarms": alarms, "contact_s": contact_s}


def effective_number(values: Sequence[float], clusters: Sequence[object]) -> float:
    """Return how many independent values tell as much of a mean as these do, which come in clusters.

    It is the number of values over the design effect, the variance of the mean by clusters over that of independent
    values, and brought to the clusters' degrees of freedom. Where all values are equal nothing tells how alike those
    of a cluster are: then each cluster counts as one.

    Parameters
    ----------
    values
        One or more numbers.
    clusters
        The cluster that each is of: repeats of one condition are one cluster.

    Returns
    -------
    float
        From above 0 to the number of values; of values that are each a cluster of their own it is their number.

    References
    ----------
    Korn and Graubard 1998, Confidence intervals for proportions with small expected number of positive counts
    estimated from survey data, Survey Methodology 24.
    """
    sample, n = np.asarray(values, float), len(values)
    names = {cluster: place for place, cluster in enumerate(dict.fromkeys(clusters))}
    count = len(names)
    if count in (1, n):
        return float(count)
    away = sample - sample.mean()
    independent = float((away**2).sum()) * n / (n - 1)
    if independent <= 0.0:
        return float(count)
    sums = np.bincount([names[cluster] for cluster in clusters], weights=away, minlength=count)
    clustered = float((sums**2).sum()) * count / (count - 1)
    if clustered <= 0.0:
        return float(n)
    from scipy import special

    freedom = (special.stdtrit(n - 1, 0.975) / special.stdtrit(count - 1, 0.975)) ** 2
    return float(min(n * independent / clustered * freedom, n))


def median_interval(values: Sequence[float]) -> tuple[float, float]:
    """The 95 % interval of a median by order statistics, which assumes no shape; NaN where the values are too few."""
    from scipy import stats

    interval = stats.quantile_test(np.asarray(values, float), q=0, p=0.5).confidence_interval(0.95)
    return float(interval.low), float(interval.high)


def area_under_roc(
    positives: Sequence[float],
    negatives: Sequence[float],
    clusters: tuple[Sequence[object], Sequence[object]] | None = None,
) -> tuple[float, float, float]:
    """Return the area under the ROC curve of a score for ``positives`` and ``negatives``, and its 95 % interval.

    The area is the chance that a positive scores above a negative, a tie counting half: 1 perfect, 0.5 none, 0
    reversed. The interval has the areas from which the one seen is no more than 1.96 of their own standard errors
    away. So complete separation leaves an interval too, the wider the fewer trials there are: from 0.50 up of 3 and 3.
    Of values in ``clusters``, a name for each positive and each negative, the interval is that of their
    `effective_number`, by the share of the other side that each of them is above or below.

    References
    ----------
    Obuchowski 1997, Nonparametric analysis of clustered ROC curve data, Biometrics 53.

    Newcombe 2006, Confidence intervals for an effect size measure based on the Mann-Whitney statistic, part 2,
    Statistics in Medicine 25: method 5.
    """
    from scipy import optimize, special

    m, n = float(len(positives)), float(len(negatives))
    above = np.sign(np.subtract.outer(np.asarray(positives, float), np.asarray(negatives, float))) / 2 + 0.5
    area, z = float(above.mean()), float(special.ndtri(0.975))
    if math.isnan(area):
        return area, area, area
    if clusters:
        m, n = effective_number(above.mean(axis=1), clusters[0]), effective_number(above.mean(axis=0), clusters[1])
    size = max((m + n) / 2 - 1, 0.0)

    def beyond(true: float) -> float:
        """Return the squared distance of the area seen from a ``true`` one, less the largest allowed."""
        variance = true * (1 - true) * (1 + size * ((1 - true) / (2 - true) + true / (1 + true))) / (m * n)
        return (area - true) ** 2 - z * z * variance

    # At 0 and 1 themselves nothing varies: the ends looked for lie inside.
    inside = min(max(area, 1e-12), 1 - 1e-12)
    low = 0.0 if area <= 0 else float(optimize.brentq(beyond, 0.0, inside))
    high = 1.0 if area >= 1 else float(optimize.brentq(beyond, inside, 1.0))
    return area, low, high


def alarm_count(spikes: npt.NDArray[np.integer], fps: float) -> int:
    """Return the number of alarms in a clip: spikes with none in the `APART_S` before them.

    Parameters
    ----------
    spikes
        A detector's spikes by frame, (T,).
    fps
        Frames per second.
    """
    fired = np.flatnonzero(spikes)
    return int(fired.size and 1 + (np.diff(fired) > APART_S * fps).sum())


def share(table: pl.DataFrame, column: str) -> Score | None:
    """Return the share of rows that are true in a column, with Clopper and Pearson's interval; ``None`` of no rows.

    The repeats of a condition are a cluster: the interval is that of their effective number.
    """
    table = table.drop_nulls(column)
    if table.is_empty():
        return None
    hits = table[column].to_list()
    number, value = effective_number(hits, table["condition"].to_list()), sum(hits) / len(hits)
    return Score(value, *proportion_interval(value * number, number), len(hits))


def area(table: pl.DataFrame, column: str, positives: Sequence[str], negatives: Sequence[str]) -> Score | None:
    """Return the area under the ROC curve, by a column, for what showed ``positives`` against ``negatives``.

    Its interval is Newcombe's, with the repeats of a condition as a cluster; ``None`` where either were not shown.
    """
    sides = [table.filter(pl.col("shown").is_in(kinds)) for kinds in (positives, negatives)]
    if any(side.is_empty() for side in sides):
        return None
    above, below = (side[column].to_list() for side in sides)
    clusters = (sides[0]["condition"].to_list(), sides[1]["condition"].to_list())
    return Score(*area_under_roc(above, below, clusters), len(above) + len(below))


def alarm_rate(table: pl.DataFrame) -> Score | None:
    """Return the alarms a minute of all rows, with the exact interval of a Poisson rate; ``None`` of no rows.

    The repeats of a condition are a cluster: alarms and minutes are scaled to their effective number.
    """
    table = table.drop_nulls("alarms")
    if table.is_empty():
        return None
    minutes, alarms = float(table["seconds"].sum()) / 60.0, int(table["alarms"].sum())
    rates = (table["alarms"] / table["seconds"]).to_list()
    scale = effective_number(rates, table["condition"].to_list()) / table.height
    low, high = (end / (minutes * scale) for end in poisson_interval(alarms * scale))
    return Score(alarms / minutes, low, high, table.height)


def contact(table: pl.DataFrame, shade: str) -> Score | None:
    """Return the time to contact at the first spike, s: median over l/v, smallest and largest.

    Only approaches straight ahead on an even ground count, and of these only those with a spike; ``None`` without one.
    """
    approaches = [f"{LOOMING}-even {shade} looming {ratio:g} s" for ratio in L_OVER_V_S]
    times = table.filter(pl.col("condition").is_in(approaches))["contact_s"].drop_nulls().to_list()
    return Score(float(np.median(times)), min(times), max(times), len(times)) if times else None


def direction_scores(robot: pl.DataFrame, clips: pl.DataFrame) -> dict[str, Score | None]:
    """Return the scores of one direction model from all its responses; ``None`` where one does not apply."""
    across = pl.col("shown").is_in(TRANSLATION)
    return {
        "direction_robot": share(robot.filter(across), "right"),
        "direction_clips": share(clips.filter(across), "right"),
        "auc_robot": area(robot, "strength", TRANSLATION, DEPTH),
        "auc_clips": area(clips, "strength", TRANSLATION, DEPTH),
        "false_alarms": share(clips.filter(shown="background"), "spiked"),
    }


def looming_scores(robot: pl.DataFrame, clips: pl.DataFrame) -> dict[str, Score | None]:
    """Return the scores of one looming model from all its responses; ``None`` where one does not apply."""
    looming, receding, others = ("looming",), ("receding",), ("grating", "background")
    return {
        "auc_translation_robot": area(robot, "looming", looming, TRANSLATION),
        "auc_recession_robot": area(robot, "looming", looming, receding),
        "auc_translation": area(clips, "looming", looming, TRANSLATION),
        "auc_recession": area(clips, "looming", looming, receding),
        "auc_background": area(clips, "looming", looming, others),
        "answered": share(clips.filter(shown="looming").with_columns(spiked=pl.col("alarms") > 0), "spiked"),
        "contact_dark_s": contact(clips, "dark"),
        "contact_light_s": contact(clips, "light"),
        "alarms_translation": alarm_rate(clips.filter(pl.col("shown").is_in(TRANSLATION))),
        "alarms_gratings": alarm_rate(clips.filter(shown="grating")),
        "alarms_background": alarm_rate(clips.filter(shown="background")),
    }


def rank(planned: Boards, responses: Mapping[str, pl.DataFrame], times: Mapping[str, Any]) -> dict[str, pl.DataFrame]:
    """Score the models of each board, and rank them.

    Parameters
    ----------
    planned, responses
        As of `play`.
    times
        Measure of `TIMES` -> model -> microseconds per frame of every round.

    Returns
    -------
    dict
        Board -> its table, the best model on top. Each measure has the columns ``NAME``, ``NAME_low``, ``NAME_high``
        (the ends of its 95 % interval) and ``NAME_n``; null where it does not apply.
    """
    boards = {}
    for board, scores in {DIRECTION: direction_scores, LOOMING: looming_scores}.items():
        rows = []
        for model in planned[board][0].specs[0].models if board in planned else ():
            # A model that only reports where motion is has no potential to score.
            label = model.label if model.counted else None
            own = (responses[part].filter(pl.col("model") == label) for part in (ROBOT.name, board))
            rounds = {name: us for name in TIMES if (us := times.get(name, {}).get(model.label))}
            timed = {name: Score(float(np.median(us)), *median_interval(us), len(us)) for name, us in rounds.items()}
            rows.append({"model": model.label, **_columns({**scores(*own), **dict.fromkeys(TIMES), **timed})})
        if rows:
            types = {name: pl.Int64 if name.endswith("_n") else pl.Float64 for name in rows[0] if name != "model"}
            table = pl.DataFrame(rows, {"model": pl.String, **types})
            order = [_mean(table, start) for start in RANKED_BY[board]]
            boards[board] = table.sort(*order, "model", descending=[True, True, False], nulls_last=True)
    return boards


def _mean(table: pl.DataFrame, start: str) -> pl.Expr:
    """Return the mean of the measures that begin so, as far as a model has them."""
    return pl.mean_horizontal(name for name in measures(table) if name.startswith(start))


def finding(board: str, table: pl.DataFrame) -> str:
    """Say which model leads a board, or how many share its best score."""
    scores = table.select(_mean(table, RANKED_BY[board][0]).alias("score"))["score"].to_list()
    if scores[0] is None:
        return f"no model has a score by {board}"
    score = f"mean {'AUC' if board == LOOMING else 'direction accuracy'}"
    if (first := scores.count(scores[0])) > 1:
        return f"{first} of {len(scores)} models share the best {score}, {scores[0]:.2f}"
    rank = f"ranks first of {len(scores)} models by {board}, with" if len(scores) > 1 else "has"
    return f"{table['model'][0]} {rank} a {score} of {scores[0]:.2f}"


def measures(table: pl.DataFrame) -> list[str]:
    """Return the measures of a board by its table: the columns that have an interval."""
    return [name for name in table.columns if f"{name}_low" in table.columns]


def _columns(scores: Mapping[str, Score | None]) -> dict[str, float | None]:
    columns = {}
    for name, score in scores.items():
        for end, value in {"": "value", "_low": "low", "_high": "high", "_n": "n"}.items():
            number = getattr(score, value, None)
            columns[name + end] = round(number, 6) if number is not None and math.isfinite(number) else None
    return columns


def time_models(models: Sequence[ConfiguredModel], shape: tuple[int, int]) -> dict[str, list[float]]:
    """Time models side by side: in one process, on one thread, in turns, so that a slow moment hits all of a round.

    Parameters
    ----------
    models
        The models. One that raises is left out.
    shape
        Shape of the frames, (R, C).

    Returns
    -------
    dict
        Model -> microseconds per frame, a mean of `BLOCK` frames for each of `ROUNDS` rounds, after one to warm up.
    """
    rows, columns = shape
    clip = stimulus("cluttered", 0, rows=rows, columns=columns, width=columns / 6, height=rows / 2, speed=columns / 2)
    frames = [frozen(clip[index].luma) for index in range(min(len(clip), 60))]
    runners = [ModelRunner(model, shape, keep=False) for model in models]
    taken: dict[str, list[float]] = {runner.label: [] for runner in runners}
    with one_thread():
        for number in range(ROUNDS + 1):
            block = [frames[(number * BLOCK + i) % len(frames)] for i in range(BLOCK)]
            for runner in runners:
                before = runner.seconds
                for frame in block:
                    runner.see(frame)
                taken[runner.label].append((runner.seconds - before) / BLOCK * 1e6)
    return {runner.label: taken[runner.label][1:] for runner in runners if not runner.trouble}


def run(planned: Boards, folder: Path, pool: Workers) -> tuple[dict[str, pl.DataFrame], list[dict[str, Any]]]:
    """Run what ``folder`` lacks of a `plan`, time the models, and write a table and a figure of each board.

    Returns
    -------
    boards, failures
        As of `rank`, and what failed.

    Raises
    ------
    UsageError
        The folder holds other trials.
    """
    from experiments.bench.report import scoreboard, style  # not before: workers do without matplotlib

    begin_whole(folder, "leaderboard")
    responses: dict[str, pl.DataFrame] = {}
    failures: list[dict[str, Any]] = []
    with pool.running():
        for part, batches in planned.items():
            rows: list[dict[str, Any]] = []
            for batch in batches:
                with batch.run(folder / batch.name, pool) as run:
                    frames = run.table("frames").partition_by("trial", "model", as_dict=True)
                    for row in run.table("trials").iter_rows(named=True):
                        rows.append(response(row, batch.specs[row["trial"]], frames.get((row["trial"], row["model"]))))
                    failures += run.failures()
            responses[part] = pl.DataFrame(rows, RESPONSES)
    if not pool.quiet:
        error_console.print("timing: 99x72 and 320x180, in turns, one thread")
    # After the workers have gone: nothing of this run's own competes for the processor.
    shown = {model.label: model for board in FILES if board in planned for model in planned[board][0].specs[0].models}
    robot = planned[ROBOT.name][0].specs[0].models  # with their parameters for 99x72
    times = {name: time_models(robot if shape == ROBOT_SHAPE else [*shown.values()], shape)
             for name, shape in TIMES.items()}  # fmt: skip
    boards = rank(planned, responses, times)
    for board, table in boards.items():
        Files(folder).write_rows(f"{FILES[board]}.csv", table.to_dicts())
        style.save(scoreboard.draw(table, LABELS, CHANCE, finding(board, table), NOTE), folder / FILES[board])
    return boards, failures
