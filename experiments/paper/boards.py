"""The leaderboard of 0.4, until 0.6: models ranked on the robot trials and clips of ``leaderboard.json``.

There are two boards. *Direction* ranks the models that respond by HS or VS, *looming* those with a looming potential.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import polars as pl

from experiments.base.console import show_files
from experiments.base.files import Files, read_json
from experiments.draw import scoreboard
from experiments.judge.roc import alarm_rate
from experiments.judge.tests import Score
from experiments.kinds.result import Kind, Run
from experiments.paper.benchmark.entry import numbers
from experiments.paper.benchmark.rows import ROWS, Measure, rows_in, showing
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
SCORES = {board: {kept.pop("name"): Measure(**kept, channels=()) for kept in declared}
          for board, declared in read_json(FILE.with_name("boards.json")).items()}  # fmt: skip
"""Board -> its measures, by name, of the robot's trials or of clips."""


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


def score(measure: Measure, rows: pl.DataFrame) -> Score | None:
    """Return a model's score by a measure of a board; ``None`` where it does not apply."""
    rows = rows.with_columns(cluster="condition", answered=pl.col("alarms") > 0)
    if measure.column == "contact_s":
        return contact(rows, *measure.shown)
    return alarm_rate(showing(rows, measure.shown)) if measure.column == "alarms" else measure.score(rows)


def contact(table: pl.DataFrame, shade: str) -> Score | None:
    """Return the time to contact at the first spike, s: median over l/v, smallest and largest.

    Only approaches straight ahead on an even ground count, and of these only those with a spike; ``None`` without one.
    """
    approaches = rf"^{LOOMING}-even {shade} looming [\d.]+ s$"
    times = table.filter(pl.col("condition").str.contains(approaches))["contact_s"].drop_nulls().to_list()
    return Score(float(np.median(times)), min(times), max(times), len(times)) if times else None


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
    for board, declared in SCORES.items():
        found = {}
        for model in models.get(board, ()):
            # A model that only reports where motion is has no potential to score.
            label = model.label if model.counted else None
            own = {part: rows.filter(pl.col("model") == label) for part, rows in responses.items()}
            found[model.label] = {name: numbers(score(measure, own[ROBOT if measure.task == ROBOT else board]))
                                  for name, measure in declared.items()}  # fmt: skip
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


def show(run: Run) -> None:
    """Print the boards of a run, and where everything is."""
    for path in sorted(run.folder.glob("*.csv")):
        table = pl.read_csv(path)
        scoreboard.show(table, measures(table), f"Ranked by {path.stem}, with 95 % intervals")
    show_files(run.folder, "leaderboard")


KIND = Kind(plan, work, "colias benchmark has a figure", show, renders=None, summary="leaderboard.csv", whole=True)
