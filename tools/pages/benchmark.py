"""The page of the benchmark: a table and a figure for each task, of the entries that ship."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.paper.benchmark.entry import COST, board, place, score_of, shipped, text_of, title_of
from experiments.paper.benchmark.rows import GAINS, MEASURES
from experiments.paper.benchmark.tasks import NAME, TASKS
from tools.pages import markdown


def write(folder: Path) -> None:
    """Write the page and its figures into ``folder``."""
    entries, parts = sorted(shipped(), key=title_of), []
    tasks = {name: task.declared.summary for name, task in TASKS.items()} | {"cost": "time a frame, on one machine"}
    for task, summary in tasks.items():
        names = [name for name, measure in MEASURES.items() if measure.task == task] or [COST]
        names += [gain for gain, name in GAINS.items() if name in names]
        if shown := [entry for entry in entries if any(score_of(entry, name) for name in names)]:
            drawn = [entry for entry in shown if "(tuned)" not in title_of(entry)]
            board(drawn, names, summary).savefig(folder / f"{task}.png", dpi=markdown.DPI)
            parts += [
                f"## {task}\n\n{markdown.sentence(summary)}\n",
                markdown.picture(f"{task}.png", f"Scores of each model in {task}", "Scores of the table below."),
                markdown.table(("model and command", *names), [_row(entry, entries, names) for entry in shown]),
            ]
    markdown.write(
        folder / "index.md",
        f"# Scores in {NAME}\n",
        "Each cell has a score, its 95 % interval and the places that the model may have. Models stand in the order of"
        " their names: an order of two is stated only where their paired interval says so.\n"
        "[Enter your model](../../how-to/benchmark.md) says what the measures are, what is not measured, and how to"
        " send an entry. A dash: no response. Empty: does not apply. The tuned model remembers the public clips; it"
        " takes no place from others, and is not in the figures.",
        *parts,
    )


def _row(entry: Mapping[str, Any], entries: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[str]:
    """Return the row of a model in the table of a task."""
    cells = [f"{title_of(entry)}<br>`colias benchmark {entry['text']}`"]
    for name in names:
        told = (text_of(score_of(entry, name)), place(entry, entries, name).removeprefix("-"))
        new = (f"in a round {text_of(score_of(entry, name, 'round'))}",) if "round" in entry["scores"] else ()
        applies = name in entry["scores"]["public"] or name == COST
        cells.append("<br>".join(filter(None, told + new)) if applies else "")
    return cells
