"""A run of the benchmark: all tasks for some models, and an entry of each."""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from experiments.base import console
from experiments.base.console import error_console, out_console, show_files
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.judge.roc import median_interval
from experiments.judge.tests import Score
from experiments.kinds.kind import Kind
from experiments.kinds.result import Run
from experiments.paper.benchmark.entry import ENTRY, numbers, place, read, shipped, write
from experiments.paper.benchmark.rows import MEASURES, ROWS, row_of
from experiments.paper.benchmark.tasks import NAME, TASKS, plans
from experiments.settings.models import ConfiguredModel, parse_label
from experiments.settings.settings import watchers
from experiments.show.timing import time_models
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.description import CPUS, RENDERERS, begin_whole, read_description
from experiments.store.plan import Plan, filled
from experiments.store.tables import table
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BESIDE = "dsnn"
"""The model that others are timed beside."""
COST, COSTS = "us_99x72", {"us_99x72": (72, 99), "us_320x180": (180, 320)}
WORDS = {
    **{name: measure.words for name, measure in MEASURES.items()},
    "gain direction": "gain of direction over the best control", "gain looming": "gain of AUC over the best control",
    COST: "µs per frame of 99x72 (logarithmic)",
}  # fmt: skip
"""Measure -> its words in tables and figures."""
HEADLINES = (
    "direction robot", "direction gamma", "direction turns", "direction clutter", "break point", "flow",
    "gain direction", "looming robot", "looming translation", "looming recession", "looming moving background",
    "contact", "false alarms", "gain looming", COST,
)  # fmt: skip
"""What the figure of a run shows."""
CHANCE = {"direction ": 0.25, "looming ": 0.5}
NOTE = "Bars: 95 % intervals, trials clustered by scene or condition."


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of all tasks. What was asked has models, and the option ``round``: the round's number."""
    if not asked.models:
        raise UsageError("colias benchmark: name a model, or a .py file")
    return Plan(asked, "benchmark", parts=plans(asked.models, asked.option("round", "")))


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Do what a folder lacks, and write the entry of each model: of one into the folder, else into one each.

    Raises
    ------
    UsageError
        The folder holds other trials, or a model failed in a trial: an entry has all.
    """
    begin_whole(out, plan.document())
    rows, machines = [], []
    with pool.running():
        for name, part in plan.parts.items():
            rows += _rows(name, part, out / name, pool)
            machines.append(read_description(out / name))
            _tell_time(plan, name, pool)
    whole = table(rows, pl.Schema({"model": pl.String, **ROWS}))
    chosen = watchers(plan.asked.models)
    costs = _costs(chosen, pool)
    about = {
        "beacon": plan.asked.option("round", ""),
        "renderers": sorted({name for one in machines for name in one.get(RENDERERS, {})}),
        "cpus": sorted({name for one in machines for name in one.get(CPUS, ())}), **provenance.of(),
    }  # fmt: skip
    about.pop("files")
    for model in chosen:
        own = whole.filter(pl.col("model").map_elements(lambda label: parse_label(label).model, str) == model.label)
        folder = out if len(chosen) == 1 else out / model.label
        folder.mkdir(exist_ok=True)
        entry = write(folder, model, own, {**about, "cost": costs[model.label]})
        _write_page(folder, entry)


def _rows(name: str, part: Plan[Any], folder: Path, pool: Workers) -> list[dict[str, Any]]:
    """Do the trials of a task, and return their rows."""
    seeds, task = name.split("/")
    with filled(part, folder, pool) as done:
        if failed := done.failures():
            raise UsageError(
                f"{folder}: {failed[0]['model'] or 'a trial'} failed in {len(failed)} trials; see failures.json"
            )
        kept = done.table("frames") if part.asked.option("frames") else pl.DataFrame({"trial": [], "model": []})
        frames = kept.partition_by("trial", "model", as_dict=True)
        return [{"model": row["model"], **row_of(seeds, task, row, part.trials[row["trial"]],
                                                 frames.get((row["trial"], row["model"])))}
                for row in done.table("trials").iter_rows(named=True)]  # fmt: skip


def _tell_time(plan: Plan[Any], name: str, pool: Workers) -> None:
    """Say how long the other tasks take, by the time so far and their prices."""
    prices = [TASKS[part.split("/")[1]].seconds for part in plan.parts]
    done = [*plan.parts].index(name) + 1
    left = (time.monotonic() - console.BEGAN) * sum(prices[done:]) / sum(prices[:done]) / 60.0
    if not pool.quiet:
        error_console.print(f"benchmark: {done} of {len(prices)} tasks, about {left:.1f} min left")


def _costs(chosen: Sequence[ConfiguredModel], pool: Workers) -> dict[str, dict[str, Any]]:
    """Return what models cost: microseconds a frame, how many times those of `BESIDE`, and bytes of state."""
    if not pool.quiet:
        error_console.print(f"timing: {', '.join(COSTS)}, beside {BESIDE}, in turns, one thread")
    others = {model.label: model for model in (*watchers((BESIDE,)), *chosen)}
    found: dict[str, dict[str, Any]] = {model.label: {"state_bytes": _state_bytes(model)} for model in chosen}
    for name, shape in COSTS.items():
        taken = time_models([*others.values()], shape)
        for label, cost in found.items():
            for more, values in ((name, taken[label]), (f"{name}_beside", np.divide(taken[label], taken[BESIDE]))):
                cost[more] = numbers(Score(float(np.median(values)), *median_interval(values), len(values)))
    return found


def _state_bytes(model: ConfiguredModel) -> int | None:
    """Return the size of a model's state after two frames; ``None`` where it has no ``get_state``."""
    built = model.build(COSTS[COST])
    for grey in (0, 255):
        built.step(np.full(COSTS[COST], grey, np.uint8))
    try:
        return len(built.get_state())
    except (AttributeError, ValueError):  # of an attribute that cannot be saved
        return None


# Reading it.


def score_of(entry: Mapping[str, Any], name: str, seeds: str = "public") -> list[float | None] | None:
    """Return value, interval and n of a measure or of a cost; ``None`` where it does not apply, or had no response."""
    found: list[float | None] | None = (entry["cost"] if name in COSTS else entry[seeds]["scores"]).get(name)
    return found


def board(entries: Iterable[Mapping[str, Any]], names: Iterable[str]) -> pl.DataFrame:
    """Return scores of entries as a figure takes them: a row for each, ``NAME``, ``_low``, ``_high`` and ``_n``."""
    ends = ("", "_low", "_high", "_n")
    rows = [{"model": entry.get("title", entry["model"]),
             **{f"{name}{end}": value for name in names
                for end, value in zip(ends, score_of(entry, name) or [None] * 4, strict=True)}}
            for entry in entries]  # fmt: skip
    kinds = {f"{name}{end}": pl.Int64 if end == "_n" else pl.Float64 for name in names for end in ends}
    return pl.DataFrame(rows, {"model": pl.String, **kinds})


def lines_of(entry: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return the table of an entry: each measure with its score, its place, and in a round that score and the gap."""
    others, rows = shipped(), []
    for name, words in WORDS.items():
        applies = name in entry["public"]["scores"] or name in COSTS
        row = {"measure": words, "score": _text(score_of(entry, name)) if applies else "does not apply",
               "place": place(entry, others, name) if applies else ""}  # fmt: skip
        if "round" in entry:
            row |= {"round": _text(score_of(entry, name, "round")) if applies and name not in COSTS else "",
                    "public less round": _text(entry["gap"].get(name)) if name in entry["gap"] else ""}  # fmt: skip
        rows.append(row)
    return rows


def _text(values: Sequence[float | None] | None) -> str:
    if values is None:
        return "no response"
    value, low, high = (float("nan") if number is None else number for number in values[:3])
    return str(Score(value, low, high, 0))


def _write_page(folder: Path, entry: Mapping[str, Any]) -> None:
    """Write the page of an entry, and its figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    style.save(_figure(entry), folder / "figure")
    rows = lines_of(entry)
    lines = [f"| {' | '.join(row.values())} |" for row in ({name: name for name in rows[0]}, *rows)]
    lines.insert(1, "|---" * len(rows[0]) + "|")
    cost = entry["cost"]
    state = "unknown" if cost["state_bytes"] is None else f"{cost['state_bytes']:,} bytes"
    text = (
        f"# {entry['model']} in {NAME}", "![Scores beside those of the models that ship](figure.png)", "\n".join(lines),
        f"A frame of 99x72 takes {_text(cost['us_99x72_beside'])} times as long as the DSNN's; its state has {state}.",
        "Check it with `colias benchmark --verify FOLDER`, which runs this model's code with your rights.",
    )  # fmt: skip
    Files(folder).write_text("README.md", "\n\n".join(text) + "\n")


def _figure(entry: Mapping[str, Any]) -> Figure:
    from experiments.draw import scoreboard  # not before: matplotlib takes its time to load

    others = [other for other in shipped() if other["model"] != entry["model"]]
    names = [name for name in HEADLINES if score_of(entry, name)]
    labels = {name: WORDS[name] for name in names}
    return scoreboard.draw(
        board((entry, *others), names), labels, CHANCE, f"{entry['model']} and the models that ship", NOTE
    )


def _entries(run: Run) -> list[Path]:
    """Return the folders of a run's entries."""
    return sorted(path.parent for path in (*run.folder.glob(ENTRY), *run.folder.glob(f"*/{ENTRY}")))


def draw(run: Run) -> Figure:
    """Draw the scores of a run's first entry beside those of the models that ship."""
    for folder in _entries(run):
        return _figure(read(folder))
    raise UsageError(f"{run.folder}: no {ENTRY} there: the run is not finished")


def show(run: Run) -> None:
    """Print the table of each entry, and where everything is."""
    for folder in _entries(run):
        entry = read(folder)
        console.show(pl.DataFrame(lines_of(entry)), f"{entry['model']} in {NAME}")
        out_console.print(
            "Place: among the models that ship; an order is stated where its paired 95 % interval says so."
        )
        show_files(folder, f"{sum(len(plan.trials) for plan in plans((entry['text'],)).values())} trials")


KIND = Kind(plan, work, draw, show, renders=None, summary=ENTRY, whole=True)
