"""The leaderboard: every model on the same robot trials and the clips of its board, scored and ranked.

There are two boards. *Direction* ranks the models that respond by HS or VS, *looming* those with a looming potential.
Models are timed side by side, in one process.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from dsnn.stimuli.looming import Looming
from experiments.base.console import count, error_console, out_console, show_files
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.declare.experiment import Angular, Design, Experiment, Listed, Translation
from experiments.draw import scoreboard, style
from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_count, alarm_rate, area, median_interval, share
from experiments.judge.tests import Score, first_alarm_s
from experiments.kinds import clips as offline, trials
from experiments.kinds.result import Kind, Run
from experiments.paper.claims.clips import answer
from experiments.paper.clips import EXTREMES, LONG_EDGE_AHEAD, SHADES
from experiments.settings.models import COMPARED, ConfiguredModel, parse_label, shown_models
from experiments.settings.settings import watchers
from experiments.show.play import ModelRunner, one_thread
from experiments.store.asked import Asked
from experiments.store.folder import begin_whole
from experiments.store.plan import Plan, filled
from experiments.store.tables import without_controls
from experiments.store.workers import Workers

ROUNDS, BLOCK = 40, 4
"""Times that each model is timed, and frames in each time."""


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


DIRECTION, LOOMING = "direction", "looming"
FILES = {DIRECTION: "leaderboard", LOOMING: "looming"}
"""Board -> name of its table and its figure, without their endings."""
ROBOT_SHAPE = (72, 99)
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
    "contact_dark_s": "time to contact, dark (s), median and range over l/v",
    "contact_light_s": "time to contact, light (s), median and range over l/v",
    "alarms_translation": "false alarms, translation (1/min)", "alarms_gratings": "false alarms, gratings (1/min)",
    "alarms_background": "false alarms, background (1/min)",
    "gain": "gain over the best control (score)",
    "us_99x72": "µs per frame of 99x72 (logarithmic)", "us_320x180": "µs per frame of 320x180 (logarithmic)",
}  # fmt: skip
"""Measure -> its words in a figure."""
CHANCE = {"direction_": 0.25, "auc_": 0.5}
"""Beginning of a measure -> what guessing gets."""
RANKED_BY = {DIRECTION: ("direction_", "auc_"), LOOMING: ("auc_", "answered")}
"""Board -> beginnings of measures: ranked by the mean of the first, equal models by that of the second."""
RIVALS = ("frozen", "absent", "reversed")
"""The controls that a model's score is held against: a looming potential has no sign that a mirror turns."""
NOTE = "Next to a score: its 95 % interval, with the repeats of a condition as one cluster."

REPEATS = 5
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


def plan(asked: Asked) -> Plan[Any]:
    """Plan the robot's trials of all models, and the clips of each board that has models.

    A model stands on every board that it has a channel for, and on that of direction if it has none.

    Parameters
    ----------
    asked
        What was asked for: models, and repeats of all that is random, otherwise `REPEATS`. Its option ``controls`` is
        whether models see everything again as controls.

    Raises
    ------
    UsageError
        Something cannot be run.
    """
    models = shown_models(COMPARED, asked.models, asked.only)
    kept = {"recordings": False, **asked.options}
    shown: dict[str, Any] = {"only": True, "seed": asked.seed, "options": kept}
    repeats = REPEATS if asked.repeats is None else asked.repeats
    bare = {**shown, "options": {**kept, "frames": False}}
    robot = Asked(kind="trials", declared=ROBOT, models=tuple(models), repeats=repeats, **bare)
    channels = {text: {*watchers((text,))[0].channels} for text in models}
    boards = {
        DIRECTION: [text for text, has in channels.items() if {"hs", "vs"} & has or "looming" not in has],
        LOOMING: [text for text, has in channels.items() if "looming" in has],
    }
    parts: dict[str, Plan[Any]] = {ROBOT.name: trials.plan(robot)}
    for board, names in boards.items():
        for experiment in clip_experiments(board, names) if names else ():
            clips = Asked(kind="clips", declared=experiment, models=tuple(names), **shown)
            clips = replace(clips, repeats=asked.repeats if experiment.repeats > 1 else None)
            parts[experiment.name] = offline.plan(clips)
    return Plan(asked, "leaderboard", parts=parts)


def parts_of(plan: Plan[Any]) -> dict[str, list[Plan[Any]]]:
    """Return the parts by what their responses count for: the robot, and each board that has models."""
    found = {name: [part for folder, part in plan.parts.items() if folder.startswith(name)]
             for name in (ROBOT.name, *FILES)}  # fmt: skip
    return {name: parts for name, parts in found.items() if parts}


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


def rank(
    models: Mapping[str, Sequence[ConfiguredModel]], responses: Mapping[str, pl.DataFrame], times: Mapping[str, Any]
) -> dict[str, pl.DataFrame]:
    """Score the models of each board, and rank them.

    Parameters
    ----------
    models, responses
        Board, or ``robot`` -> the models shown there, and their responses.
    times
        Measure of `TIMES` -> model -> microseconds per frame of every round.

    Returns
    -------
    dict
        Board -> its table, the best model on top. Each measure has the columns ``NAME``, ``NAME_low``, ``NAME_high``
        (the ends of its 95 % interval) and ``NAME_n``; null where it does not apply. Where there are controls,
        ``gain`` is the score by which models are ranked, less the best of `RIVALS`; it has no interval.
    """
    boards = {}
    controlled = any(without_controls(table).height < table.height for table in responses.values())
    for board, scores in {DIRECTION: direction_scores, LOOMING: looming_scores}.items():
        rows = []
        for model in models.get(board, ()):
            # A model that only reports where motion is has no potential to score.
            labels = [parse_label(model.label).controlled(name) for name in RIVALS]
            found, *rivals = (
                scores(*(responses[part].filter(pl.col("model") == label) for part in (ROBOT.name, board)))
                for label in ((model.label, *labels) if model.counted else (None,))
            )
            rounds = {name: us for name in TIMES if (us := times.get(name, {}).get(model.label))}
            timed = {name: Score(float(np.median(us)), *median_interval(us), len(us)) for name, us in rounds.items()}
            gain = {"gain": _gain(found, rivals, board)} if controlled else {}
            rows.append({"model": model.label, **_columns({**found, **gain, **dict.fromkeys(TIMES), **timed})})
        if rows:
            types = {name: pl.Int64 if name.endswith("_n") else pl.Float64 for name in rows[0] if name != "model"}
            table = pl.DataFrame(rows, {"model": pl.String, **types})
            order = [_mean(table, start) for start in RANKED_BY[board]]
            boards[board] = table.sort(*order, "model", descending=[True, True, False], nulls_last=True)
    return boards


def _gain(own: Mapping[str, Score | None], rivals: Sequence[Mapping[str, Score | None]], board: str) -> Score | None:
    """Return how far the mean score of a model is above that of its best control; ``None`` where one has none."""
    known = [[score.value for name, score in one.items() if name.startswith(RANKED_BY[board][0]) and score]
             for one in (own, *rivals)]  # fmt: skip
    if len(known) < 2 or not all(known):
        return None
    mean, *others = (float(np.mean(values)) for values in known)
    return Score(mean - max(others), math.nan, math.nan, len(known[0]))


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
    rank = f"ranks first of {len(scores)} models:" if len(scores) > 1 else "has a"
    return f"{table['model'][0]} {rank} {score} {scores[0]:.2f}"


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


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Run what a folder lacks, time the models, and write a table and a figure of each board.

    Raises
    ------
    UsageError
        The folder holds other trials.
    """
    begin_whole(out, plan.document())
    parts = parts_of(plan)
    with pool.running():
        responses = {name: _responses(of, out, pool) for name, of in parts.items()}
    if not pool.quiet:
        error_console.print("timing: 99x72 and 320x180, in turns, one thread")
    # After the workers have gone: nothing of this run's own competes for the processor.
    models = {name: of[0].models for name, of in parts.items()}
    shown = {model.label: model for board in FILES for model in models.get(board, ())}
    times = {name: time_models(models[ROBOT.name] if shape == ROBOT_SHAPE else [*shown.values()], shape)
             for name, shape in TIMES.items()}  # fmt: skip
    for board, table in rank(models, responses, times).items():
        Files(out).write_rows(f"{FILES[board]}.csv", table.to_dicts())
        style.save(scoreboard.draw(table, LABELS, CHANCE, finding(board, table), NOTE), out / FILES[board])


def _responses(parts: Sequence[Plan[Any]], out: Path, pool: Workers) -> pl.DataFrame:
    """Run parts, and return the responses of all models in them."""
    rows: list[dict[str, Any]] = []
    for part in parts:
        with filled(part, out / part.name, pool) as folder:
            frames = folder.table("frames").partition_by("trial", "model", as_dict=True)
            for row in folder.table("trials").iter_rows(named=True):
                rows.append(response(row, part.trials[row["trial"]], frames.get((row["trial"], row["model"]))))
    return pl.DataFrame(rows, RESPONSES)


# Reading it.


def tables(run: Run) -> dict[str, pl.DataFrame]:
    """Return board -> its table, of the boards that a run has."""
    there = {board: run.folder / f"{file}.csv" for board, file in FILES.items()}
    return {board: _table(path) for board, path in there.items() if path.is_file()}


def _table(path: Path) -> pl.DataFrame:
    """Read a board, with a column that is empty for every model as numbers too."""
    names = pl.read_csv(path, n_rows=0).columns
    types = {name: pl.Int64 if name.endswith("_n") else pl.Float64 for name in names}
    return pl.read_csv(path, schema_overrides={**types, "model": pl.String})


def draw(run: Run) -> Figure:
    """Draw the first board of a run, from its folder alone; `UsageError` without one."""
    for board, table in tables(run).items():
        return scoreboard.draw(table, LABELS, CHANCE, finding(board, table), NOTE)
    raise UsageError(f"{run.folder}: no {FILES[DIRECTION]}.csv there: the run is not finished")


def show(run: Run) -> None:
    """Print the boards of a run, and where everything is."""
    boards = tables(run)
    for name, table in boards.items():
        scoreboard.show(table, measures(table), f"Ranked by {name}")
        out_console.print(f"{NOTE} Empty: does not apply, or no response.")
    show_files(run.folder, count(len({name for table in boards.values() for name in table["model"]}), "model"))


KIND = Kind(plan, work, draw, show, renders=None, summary="leaderboard.csv", whole=True)
