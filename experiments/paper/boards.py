"""The leaderboard of 0.4, until 0.6: models ranked on the robot trials and clips of ``leaderboard.json``.

There are two boards. *Direction* ranks the models that respond by HS or VS, *looming* those with a looming potential.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from experiments.base.console import count, out_console, show_files
from experiments.base.files import Files
from experiments.draw import scoreboard
from experiments.judge.judge import SIGNED
from experiments.judge.roc import alarm_rate, area, share
from experiments.judge.tests import Score
from experiments.kinds.result import Kind, Run
from experiments.paper.benchmark.entry import numbers
from experiments.paper.benchmark.rows import ROWS, rows_in
from experiments.paper.benchmark.tasks import FILE, tasks_of
from experiments.settings.models import COMPARED, ConfiguredModel, shown_models
from experiments.settings.settings import watchers
from experiments.store.asked import Asked
from experiments.store.folder import begin_whole
from experiments.store.plan import Plan, filled
from experiments.store.workers import Workers

Models = Sequence[ConfiguredModel]
ROBOT, DIRECTION, LOOMING = "robot", "direction", "looming"
FILES = {DIRECTION: "leaderboard", LOOMING: "looming"}
"""Board -> name of its table, without its ending."""
RANKED_BY = {DIRECTION: ("direction_", "auc_"), LOOMING: ("auc_", "answered")}
"""Board -> beginnings of measures: ranked by the mean of the first, equal models by that of the second."""
NOTE = "Next to a score: its 95 % interval, with the repeats of a condition as one cluster."
TRANSLATION, DEPTH = tuple(SIGNED), ("looming", "receding")


def plan(asked: Asked) -> Plan[Any]:
    """Plan the robot's trials of all models, and the clips of each board that has models.

    A model stands on every board that it has a channel for, and on that of direction if it has none.

    Parameters
    ----------
    asked
        What was asked for: models, and repeats of all that is random.

    Raises
    ------
    UsageError
        Something cannot be run.
    """
    models = shown_models(COMPARED, asked.models, asked.only)
    channels = {text: {*watchers((text,))[0].channels} for text in models}
    boards = {
        ROBOT: models,
        DIRECTION: [text for text, has in channels.items() if {"hs", "vs"} & has or "looming" not in has],
        LOOMING: [text for text, has in channels.items() if "looming" in has],
    }
    parts = {}
    for name, task in tasks_of(FILE.with_name("leaderboard.json")).items():
        if names := boards[name.partition("-")[0]]:
            parts[name] = task.plan(names, asked.seed, asked.repeats if task.declared.repeats > 1 else None)
    return Plan(asked, "leaderboard", parts=parts)


def contact(table: pl.DataFrame, shade: str) -> Score | None:
    """Return the time to contact at the first spike, s: median over l/v, smallest and largest.

    Only approaches straight ahead on an even ground count, and of these only those with a spike; ``None`` without one.
    """
    approaches = rf"^{LOOMING}-even {shade} looming [\d.]+ s$"
    times = table.filter(pl.col("condition").str.contains(approaches))["contact_s"].drop_nulls().to_list()
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


def rank(models: Mapping[str, Models], responses: Mapping[str, pl.DataFrame]) -> dict[str, pl.DataFrame]:
    """Score the models of each board, and rank them.

    Parameters
    ----------
    models, responses
        Board, or ``robot`` -> the models shown there, and their responses.

    Returns
    -------
    dict
        Board -> its table as `scoreboard.tabulate` has it, the best model on top.
    """
    boards = {}
    for board, scores in {DIRECTION: direction_scores, LOOMING: looming_scores}.items():
        found = {}
        for model in models.get(board, ()):
            # A model that only reports where motion is has no potential to score.
            label = model.label if model.counted else None
            own = (responses[part].filter(pl.col("model") == label) for part in (ROBOT, board))
            found[model.label] = {name: numbers(score) for name, score in scores(*own).items()}
        if found:
            table = scoreboard.tabulate(found)
            order = [pl.mean_horizontal(name for name in measures(table) if name.startswith(start))
                     for start in RANKED_BY[board]]  # fmt: skip
            boards[board] = table.sort(*order, "model", descending=[True, True, False], nulls_last=True)
    return boards


def measures(table: pl.DataFrame) -> list[str]:
    """Return the measures of a board by its table: the columns that have an interval."""
    return [name for name in table.columns if f"{name}_low" in table.columns]


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Run what a folder lacks, and write a table of each board.

    Raises
    ------
    UsageError
        The folder holds other trials.
    """
    begin_whole(out, plan.document())
    rows: dict[str, list[dict[str, Any]]] = {}
    with pool.running():
        for name, part in plan.parts.items():
            with filled(part, out / name, pool) as folder:
                rows.setdefault(name.partition("-")[0], []).extend(rows_in(name, part, folder))
    responses = {name: pl.DataFrame(of, {"model": pl.String, **ROWS}) for name, of in rows.items()}
    models = {name.partition("-")[0]: part.models for name, part in plan.parts.items()}
    for board, table in rank(models, responses).items():
        Files(out).write_rows(f"{FILES[board]}.csv", table.to_dicts())


# Reading it.


def tables(run: Run) -> dict[str, pl.DataFrame]:
    """Return board -> its table, of the boards that a run has."""
    there = {board: run.folder / f"{file}.csv" for board, file in FILES.items()}
    return {board: pl.read_csv(path) for board, path in there.items() if path.is_file()}


def show(run: Run) -> None:
    """Print the boards of a run, and where everything is."""
    boards = tables(run)
    for name, table in boards.items():
        scoreboard.show(table, measures(table), f"Ranked by {name}")
        out_console.print(f"{NOTE} Empty: does not apply, or no response.")
    show_files(run.folder, count(len({name for table in boards.values() for name in table["model"]}), "model"))


KIND = Kind(plan, work, "colias benchmark has a figure", show, renders=None, summary="leaderboard.csv", whole=True)
