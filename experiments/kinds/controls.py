"""What a run with controls comes to: their table and figure."""

from collections.abc import Callable, Mapping
from typing import Any

from experiments.judge.controls import COLUMNS, measured, word_of
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan


def conclude_controls(plan: Plan[Any], folder: RunFolder, ways: Callable[[], Mapping[int, str]]) -> None:
    """Judge the controls of a run that has some, and write their table and figure.

    Parameters
    ----------
    plan, folder
        The run, with all its trials.
    ways
        Returns the true motion of each trial: of clips it takes time, and is asked for where there are controls.
    """
    if not plan.asked.option("controls"):
        return
    from experiments.draw import controls as report, style  # not before: workers do without matplotlib

    found = measured(folder.table("frames"), ways(), plan.models)
    words = [word_of(values, kind, random=plan.random) for (_, kind), values in found.items()]
    rows = ({"model": model, "response": kind, **word} for (model, kind), word in zip(found, words, strict=True))
    folder.write_rows("controls.csv", [{name: row[name] for name in COLUMNS} for row in rows])
    if drawn := {key: values for key, values in found.items() if len(values)}:
        known = [word["word"] for word in words if word["n"]]
        style.save(report.draw(drawn, known), folder.folder / "controls")
