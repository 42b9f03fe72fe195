"""A run of the benchmark: all tasks for some models, and an entry of each."""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from experiments.base import console
from experiments.base.console import error_console, out_console, show_files
from experiments.base.errors import UsageError
from experiments.base.files import Files
from experiments.judge.roc import median_interval
from experiments.judge.tests import Score
from experiments.kinds.result import Kind, Run
from experiments.paper.benchmark.entry import ENTRY, numbers, place, read, shipped, write
from experiments.paper.benchmark.rows import MEASURES, ROWS, row_of, shown_in
from experiments.paper.benchmark.tasks import NAME, TASKS, plans
from experiments.settings.models import ConfiguredModel
from experiments.settings.settings import watchers
from experiments.show.play import ModelRunner, one_thread
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import CPUS, RENDERERS, begin_whole, read_description
from experiments.store.plan import Plan, filled
from experiments.store.tables import table
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ROUNDS, BLOCK = 40, 4
"""Times that each model is timed, and frames in each time."""
BESIDE = "dsnn"
"""The model that others are timed beside."""
COST, SHAPE = "µs per frame of 99x72 (logarithmic)", (72, 99)
VARIANTS = ("dim", "pale", "noise", "15-fps", "60-fps")
"""Tasks that the figure of a run leaves to its table."""
CHANCE = {"direction": 0.25, "AUC": 0.5}
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
    whole = table(rows, pl.Schema([("model", pl.String), *ROWS.items()]))
    chosen = watchers(plan.asked.models)
    costs = _costs(chosen)
    drawn, cpus = ({name for one in machines for name in one.get(key, ())} for key in (RENDERERS, CPUS))
    about = {"beacon": plan.asked.option("round", ""), "renderers": sorted(drawn), "cpus": sorted(cpus),
             "versions": provenance.versions(), "source": provenance.source()}  # fmt: skip
    for model in chosen:
        own = whole.filter(model=model.label)
        folder = out if len(chosen) == 1 else out / model.label
        folder.mkdir(exist_ok=True)
        entry = write(folder, model, own, {**about, "cost": costs[model.label]})
        _write_page(folder, entry)


def _rows(name: str, part: Plan[Any], folder: Path, pool: Workers) -> list[dict[str, Any]]:
    """Do the trials of a task, and return their rows."""
    seeds, task = name.split("/")
    with filled(part, folder, pool) as done:
        if failed := done.failures():
            which = failed[0]["model"] or "a trial"
            raise UsageError(f"{folder}: {which} failed in {len(failed)} trials, an entry has all: see failures.json")
        return [row_of(seeds, task, *one) for one in shown_in(part, done)]


def _tell_time(plan: Plan[Any], name: str, pool: Workers) -> None:
    """Say how long the other tasks take, by the time so far and their prices."""
    prices = [TASKS[part.split("/")[1]].seconds for part in plan.parts]
    done = [*plan.parts].index(name) + 1
    left = (time.monotonic() - console.BEGAN) * sum(prices[done:]) / sum(prices[:done]) / 60.0
    if not pool.quiet:
        error_console.print(f"benchmark: {done} of {len(prices)} tasks, about {left:.1f} min left")


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


def _costs(chosen: Sequence[ConfiguredModel]) -> dict[str, dict[str, Any]]:
    """Return what models cost: microseconds a frame, how many times those of `BESIDE`, and bytes of state."""
    others = {model.label: model for model in (*watchers((BESIDE,)), *chosen)}
    taken, found = time_models([*others.values()], SHAPE), {}
    for model in chosen:
        state = None
        with contextlib.suppress(AttributeError, ValueError):  # a model without get_state, or with what is not saved
            built: Any = model.build(SHAPE)
            state = len(built.get_state())
        times = {COST: taken[model.label], "beside": np.divide(taken[model.label], taken[BESIDE])}
        costs = {name: numbers(Score(float(np.median(us)), *median_interval([*us]), len(us)))
                 for name, us in times.items()}  # fmt: skip
        found[model.label] = {**costs, "state_bytes": state}
    return found


# Reading it.


def score_of(entry: Mapping[str, Any], name: str, seeds: str = "public") -> list[float | None] | None:
    """Return value, interval and n of a measure or of a cost; ``None`` where it does not apply, or had no response."""
    found: list[float | None] | None = ({COST: entry["cost"][COST]} | entry["scores"][seeds]).get(name)
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
    """Return the table of an entry: each measure that applies with its score, its place, and what a round gave."""
    others, rows, rounds = shipped(), [], [seeds for seeds in entry["scores"] if seeds != "public"]
    for name in (*entry["scores"]["public"], COST):
        more = {seeds: text_of(score_of(entry, name, seeds)) if name != COST else "" for seeds in rounds}
        rows.append(
            {"measure": name, "score": text_of(score_of(entry, name)), "place": place(entry, others, name), **more}
        )
    return rows


def text_of(values: Sequence[float | None] | None) -> str:
    """Return a score and its interval for people; a dash where there was no response."""
    value, low, high = (math.nan if number is None else number for number in (values or [None] * 3)[:3])
    return str(Score(value, low, high, 0)) if values else "-"


def _write_page(folder: Path, entry: Mapping[str, Any]) -> None:
    """Write the page of an entry, and its figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    style.save(_figure(entry), folder / "figure")
    rows, state = lines_of(entry), entry["cost"]["state_bytes"]
    lines = [f"| {' | '.join(row.values())} |" for row in ({name: name for name in rows[0]}, *rows)]
    lines.insert(1, "|---" * len(rows[0]) + "|")
    kept = "" if state is None else f" Its state has {state:,} bytes."
    text = (
        f"# {entry['model']} in {NAME}", "![Scores beside those of the models that ship](figure.png)", "\n".join(lines),
        f"A frame takes {text_of(entry['cost']['beside'])} times as long as the DSNN's.{kept}",
        "`colias benchmark --verify FOLDER` checks it, and runs this model's code with your rights.",
    )  # fmt: skip
    Files(folder).write_rows("scores.csv", rows)
    Files(folder).write_text("README.md", "\n\n".join(text) + "\n")


def _figure(entry: Mapping[str, Any]) -> Figure:
    from experiments.draw import scoreboard  # not before: matplotlib takes its time to load

    others = [other for other in shipped() if other["model"] != entry["model"]]
    names = [name for name in (*entry["scores"]["public"], COST) if score_of(entry, name)
             and (name not in MEASURES or MEASURES[name].task not in VARIANTS)]  # fmt: skip
    title = f"{entry['model']} and the models that ship"
    return scoreboard.draw(board((entry, *others), names), {name: name for name in names}, CHANCE, title, NOTE)


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
        others = [name for name in MEASURES if name not in entry["scores"]["public"]]
        console.show(pl.DataFrame(lines_of(entry)), f"{entry['model']} in {NAME}")
        out_console.print("Place: among the models that ship, as far as paired 95 % intervals tell them apart.")
        if others:
            out_console.print(f"Does not apply: {'; '.join(others)}.")
        show_files(folder, f"{entry['trials']} trials")


KIND = Kind(plan, work, draw, show, renders=None, summary="scores.csv", whole=True)
