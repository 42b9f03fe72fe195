"""The page of the benchmark: a table and a figure for each task, of the entries that ship."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from experiments.draw import scoreboard
from experiments.paper.benchmark.entry import place, shipped
from experiments.paper.benchmark.rows import GAINS, MEASURES
from experiments.paper.benchmark.run import CHANCE, COST, NOTE, board, score_of, text_of
from experiments.paper.benchmark.tasks import NAME, TASKS
from tools.pages import markdown


def write(folder: Path) -> None:
    """Write the page and its figures into ``folder``."""
    entries, parts = sorted(shipped(), key=title_of), []
    tasks = {name: task.declared.summary for name, task in TASKS.items()} | {"cost": "time a frame, on one machine"}
    for task, summary in tasks.items():
        names = [name for name, measure in MEASURES.items() if measure.task == task]
        names += [gain for gain, name in GAINS.items() if name in names] + [COST] * (task == "cost")
        shown = [entry for entry in entries if any(score_of(entry, name) for name in names)]
        if shown:
            figure = scoreboard.draw(board(shown, names), {name: name for name in names}, CHANCE, summary, NOTE)
            figure.savefig(folder / f"{task}.png", dpi=markdown.DPI)
            rows = [_row(entry, entries, names) for entry in shown]
            text = f"Scores of each model in the task {task}"
            parts += [
                f"## {task}\n\n{markdown.sentence(summary)}\n",
                markdown.table(("model and command", *names), rows),
                markdown.picture(f"{task}.png", text, "The scores of the table."),
            ]
    markdown.write(
        folder / "index.md",
        f"# Scores in {NAME}\n",
        "Each cell has a score, its 95 % interval and the places that the model may have. Models stand in the order of"
        " their names: an order of two is stated only where their paired interval says so.\n"
        "[Enter your model](../../how-to/benchmark.md) says what the measures are, what is not measured, and how to"
        " send an entry. A dash: no response. Empty: does not apply. The tuned model takes no place from others.\n",
        *parts,
    )


def title_of(entry: Mapping[str, Any]) -> str:
    """Return the name of an entry on the page."""
    return str(entry.get("title", entry["model"]))


def _row(entry: Mapping[str, Any], entries: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[str]:
    """Return the row of a model in the table of a task."""
    cells = []
    for name in names:
        applies = name in entry["scores"]["public"] or name == COST
        stands = place(entry, entries, name)
        new = f"; in a round {text_of(score_of(entry, name, 'round'))}" if "round" in entry["scores"] else ""
        cells.append(f"{text_of(score_of(entry, name))}{stands and f'; {stands}'}{new}" if applies else "")
    return [f"{title_of(entry)}<br>`colias benchmark {entry['text']}`", *cells]
