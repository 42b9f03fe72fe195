"""What runs with controls come to: their table, their figure, and what is printed of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from experiments.base import console
from experiments.judge.controls import COLUMNS, MEANS, measured, word_of
from experiments.kinds.result import Run
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan


def conclude_controls(plan: Plan[Any], folder: RunFolder, ways: Mapping[int, str]) -> None:
    """Judge the controls of a run that has some, and write their table and figure.

    Parameters
    ----------
    plan, folder
        The run, with all its trials.
    ways
        The true motion of each trial.
    """
    if not plan.asked.option("controls"):
        return
    from experiments.draw import controls, style  # not before: workers do without matplotlib

    found = measured(folder.table("frames"), ways, plan.models)
    words = [word_of(values, kind, random=plan.random) for (_, kind), values in found.items()]
    rows = ({"model": model, "response": kind, **word} for (model, kind), word in zip(found, words, strict=True))
    folder.write_rows("controls.csv", [{name: row[name] for name in COLUMNS} for row in rows])
    if drawn := {key: values for key, values in found.items() if len(values)}:
        known = [word["word"] for word in words if word["n"]]
        style.save(controls.draw(drawn, known), folder.folder / "controls")


def show_controls(run: Run) -> None:
    """Print the table of a run's controls, if it has one."""
    table = run.controls
    if table.height:
        columns = ("model", "response", "word", "n", *MEANS, "p")
        known = [name for name in columns if table[name].null_count() < table.height]
        console.show(table.select(known), "\nis it vision? trials and their controls")
        for row in table.drop_nulls("says").iter_rows(named=True):
            console.out_console.print(f"{row['model']}, {row['response']}: {row['word']} ({row['says']})")
