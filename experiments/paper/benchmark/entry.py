"""An entry of the benchmark: making it, its place among others, and whether it is what its author says."""

from __future__ import annotations

import contextlib
import json
import math
import re
import shutil
import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np
import polars as pl

from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from experiments.base import console
from experiments.base.console import error_console, out_console, show_files
from experiments.base.errors import UsageError
from experiments.base.files import Files, read_json, read_parquet
from experiments.base.streams import stream
from experiments.base.user_code import digests, is_own, sha256
from experiments.judge.roc import median_interval
from experiments.judge.tests import Score
from experiments.kinds.result import Kind, Run, load
from experiments.paper.benchmark.rows import GAINS, MARGINS, MEASURES, ROWS, Sides, difference, rows_in, summed
from experiments.paper.benchmark.tasks import NAME, TASKS, digest_of, document, plans
from experiments.settings.models import CONTROLS, ConfiguredModel, parse_model
from experiments.settings.settings import watchers
from experiments.show.play import ModelRunner, one_thread
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import CPUS, RENDERERS, begin_whole, read_description
from experiments.store.plan import Plan, filled
from experiments.store.tables import cpu_features, table
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENTRY, TRIALS, MODEL = "entry.json", "trials.parquet", "model"
GAP = "public less round"
"""Scores by the paired difference of both: what a model that was tuned on the public seeds loses."""
KEY = ("seeds", "task", "trial", "control")
WORDS, FLIPPED = ("right", "spiked"), 0.05
"""Columns of words, and the share of them that may differ there."""
SHIPPED = Path(__file__).parent / "entries"
ROUNDS, BLOCK = 40, 4
"""Times that each model is timed, and frames in each time."""
BESIDE = "dsnn"
"""The model that others are timed beside."""
COST, SHAPE = "µs per frame of 99x72 px", (72, 99)
VARIANTS = ("dim", "pale", "noise", "15-fps", "60-fps")
"""Tasks that the figure of a run leaves to its table."""
CHANCE = {"direction": 0.25, "AUC": 0.5, "gain": 0.0}
NOTE = "Bars: 95 % intervals, trials clustered by scene or condition."


@cache
def digest(channels: tuple[str, ...]) -> str:
    """Return the digest of the tasks for a model with some channels: what is shown, scenes, measures, margins."""
    own = {name: measure for name, measure in MEASURES.items() if {*measure.channels} & {*channels}}
    return digest_of(document(channels), own, GAINS, MARGINS, FLIPPED)


# To make one.


def plan(asked: Asked) -> Plan[Any]:
    """Return the plan of all tasks for the model that was asked for; the option ``round`` is the round's number."""
    beacon = asked.option("round", "")
    if len(asked.models) != 1:
        raise UsageError("colias benchmark: name a model, or a .py file")
    if not re.fullmatch("[0-9A-Fa-f]*", beacon):
        raise UsageError(f"--round must be a hexadecimal number, got {beacon}")
    return Plan(asked, "benchmark", parts=plans(asked.models[0], beacon))


def played(parts: Mapping[str, Plan[Any]], out: Path, pool: Workers) -> tuple[pl.DataFrame, dict[str, list[str]]]:
    """Do what a folder lacks of the tasks, and tell the time that the others take, by their prices.

    Returns
    -------
    polars.DataFrame, dict
        The rows, of `ROWS`; the renderers and the CPUs that computed them.

    Raises
    ------
    UsageError
        The folder holds other trials, or the model failed in a trial: an entry has all.
    """
    rows, machines = [], []
    prices = [TASKS[name.split("/")[1]].seconds for name in parts]
    with pool.running():
        for number, (name, part) in enumerate(parts.items(), 1):
            with filled(part, out / name, pool) as done:
                if failed := done.failures():
                    raise UsageError(f"{done.folder}: {len(failed)} trials failed, and an entry has all")
                rows += rows_in(name, part, done)
            machines.append(read_description(out / name))
            if not pool.quiet:
                left = (time.monotonic() - console.BEGAN) * sum(prices[number:]) / sum(prices[:number]) / 60.0
                error_console.print(f"benchmark: {number} of {len(parts)} tasks, about {left:.1f} min left")
    known = {key: sorted({name for one in machines for name in one.get(key, ())}) for key in (RENDERERS, CPUS)}
    return table(rows, pl.Schema([("model", pl.String), *ROWS.items()])).select(ROWS.names()), known


def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
    """Do what a folder lacks, and write the entry: its rows, the model's files, scores, a figure and a page."""
    from experiments.draw import style  # not before: workers do without matplotlib

    begin_whole(out, plan.document())
    rows, machines = played(plan.parts, out, pool)
    (model,) = watchers(plan.asked.models)
    files, text = {}, model.text or model.source
    if is_own(model.source):
        source = Path(model.source).resolve()
        beside = [path for path in source.parent.glob(f"{source.stem}.*") if path.is_file()]  # weights among them
        for path, sha in {**{str(path): sha256(path) for path in beside}, **digests(source)}.items():
            if Path(path).is_relative_to(source.parent):
                copy = f"{MODEL}/{Path(path).relative_to(source.parent)}"
                (out / copy).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, out / copy)
                files[copy] = sha
        text = f"{MODEL}/{source.name}{text.removeprefix(parse_model(text)[0])}"
    Files(out).write_table(out / TRIALS, rows)
    entry = {
        "benchmark": NAME, "digest": digest(model.channels), "model": model.label, "text": text,
        "channels": model.channels, "files": files, "rows": sha256(out / TRIALS),
        "trials": rows.filter(control="").height, "beacon": plan.asked.option("round", ""), **machines,
        "versions": provenance.versions(), "source": provenance.source(), "cost": cost(model),
        **derived(rows, model.channels),
    }  # fmt: skip
    Files(out).write_json(ENTRY, entry)
    entry = read(out)
    style.save(draw(load(out)), out / "figure")
    lines, state = lines_of(entry), entry["cost"]["state_bytes"]
    Files(out).write_rows("scores.csv", lines)
    heads = dict(zip(lines[0], lines[0], strict=True)), dict.fromkeys(lines[0], "---")
    page = (
        f"# {entry['model']} in {NAME}", "![Scores beside those of the models that ship](figure.png)",
        "\n".join(f"| {' | '.join(row.values())} |" for row in (*heads, *lines)),
        f"A frame takes {text_of(entry['cost']['beside'])} times as long as the DSNN's."
        f" {'' if state is None else f'Its state has {state:,} bytes.'}",
        "`colias benchmark --verify FOLDER` checks it, and runs this model's code with your rights.\n",
    )  # fmt: skip
    Files(out).write_text("README.md", "\n\n".join(page))


def derived(rows: pl.DataFrame, channels: Sequence[str]) -> dict[str, Any]:
    """Return what of an entry follows from its rows: scores and marks by seeds, and public less round scores."""
    scores: dict[str, dict[str, Any]] = {}
    marks: dict[str, dict[str, Sides]] = {}
    for (seeds,), part in rows.partition_by("seeds", as_dict=True, maintain_order=True).items():
        found, marks[seeds] = summed(part, channels)
        scores[seeds] = {name: numbers(score) for name, score in found.items()}
    if len(marks) > 1:
        gaps = {name: difference(sides, marks["round"][name]) for name, sides in marks["public"].items() if sides}
        scores[GAP] = {name: numbers(gap) for name, gap in gaps.items()}
    return {"scores": scores, "marks": marks}


def numbers(score: Score | None) -> list[float | None] | None:
    """Return value, ends of the interval and n as JSON has them; ``None`` where there was no response."""
    if score is None or math.isnan(score.value):
        return None
    ends = (score.value, score.low, score.high)
    return [*(round(value, 6) if math.isfinite(value) else None for value in ends), score.n]


def cost(model: ConfiguredModel) -> dict[str, Any]:
    """Return what a model costs: microseconds a frame, how many times those of `BESIDE`, and bytes of state."""
    others = {one.label: one for one in (*watchers((BESIDE,)), model)}
    taken = time_models([*others.values()], SHAPE)
    times = {COST: taken[model.label], "beside": np.divide(taken[model.label], taken[BESIDE])}
    found: dict[str, Any] = {name: numbers(Score(float(np.median(us)), *median_interval([*us]), len(us)))
                             for name, us in times.items()}  # fmt: skip
    found["state_bytes"] = None
    with contextlib.suppress(AttributeError, ValueError):  # a model without get_state, or with what is not saved
        built: Any = model.build(SHAPE)
        found["state_bytes"] = len(built.get_state())
    return found


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


# To read one.


def read(folder: Path) -> dict[str, Any]:
    """Return the entry in a folder; `UsageError` where there is none."""
    if not (folder / ENTRY).is_file():
        raise UsageError(f"{folder}: no {ENTRY} there: colias benchmark MODEL --out {folder} makes one")
    entry: dict[str, Any] = read_json(folder / ENTRY)
    return entry


def shipped() -> list[dict[str, Any]]:
    """Return the entries that ship."""
    return [read_json(path) for path in sorted(SHIPPED.glob("*.json"))]


def place(entry: Mapping[str, Any], others: Iterable[Mapping[str, Any]], name: str, *, names: bool = False) -> str:
    """Return the places that a model may have by a measure, such as ``2 to 4 of 9``.

    It is a dash where a measure has no order, or nobody else has it.

    A model is above another only where the interval of their paired marks excludes 0. Entries of one round are compared
    on its seeds, others on the public ones. One whose title says that it is tuned takes no place from others. With
    ``names`` those that are better or worse for sure are named.
    """
    leads: dict[str, list[float]] = {}
    for other in others if name in MEASURES and MEASURES[name].better else ():
        seeds = "round" if entry["beacon"] and entry["beacon"] == other["beacon"] else "public"
        mine, theirs = (one["marks"][seeds].get(name) for one in (entry, other))
        if mine and theirs and other["model"] != entry["model"] and "(tuned)" not in title_of(other):
            apart = difference(mine, theirs)
            leads[title_of(other)] = sorted(MEASURES[name].better * end for end in (apart.low, apart.high))
    ahead = [model for model, (_, high) in leads.items() if high < 0]
    behind = [model for model, (low, _) in leads.items() if low > 0]
    best, worst = 1 + len(ahead), 1 + len(leads) - len(behind)
    stands = f"{best}" if best == worst else f"{best} to {worst}"
    who = [f"{word} {', '.join(models)}" for word, models in (("below", ahead), ("above", behind)) if models and names]
    return "; ".join((f"{stands} of {len(leads) + 1}", *who)) if leads else "-"


def title_of(entry: Mapping[str, Any]) -> str:
    """Return the name of an entry on pages and figures."""
    return str(entry.get("title", entry["model"]))


def score_of(entry: Mapping[str, Any], name: str, seeds: str = "public") -> list[float | None] | None:
    """Return value, interval and n of a measure or of a cost; ``None`` where it does not apply, or had no response."""
    found: list[float | None] | None = ({COST: entry["cost"][COST]} | entry["scores"][seeds]).get(name)
    return found


def text_of(values: Sequence[float | None] | None) -> str:
    """Return a score and its interval for people; a dash where there was no response."""
    value, low, high = (math.nan if number is None else number for number in (values or [None] * 3)[:3])
    return str(Score(value, low, high, 0)) if values else "-"


def lines_of(entry: Mapping[str, Any]) -> list[dict[str, str]]:
    """Return the table of an entry: each measure that applies with its score, its place, and what a round gave."""
    others, rows = shipped(), []
    for name in (*entry["scores"]["public"], COST):
        row = {
            "measure": name,
            "score": text_of(score_of(entry, name)),
            "place": place(entry, others, name, names=True),
        }
        rounds = {seeds: score_of(entry, name, seeds) for seeds in entry["scores"] if seeds != "public"}
        rows.append({**row, **{seeds: text_of(score) if name != COST else "" for seeds, score in rounds.items()}})
    return rows


def board(entries: Iterable[Mapping[str, Any]], names: Sequence[str], title: str) -> Figure:
    """Draw scores of entries, a panel for each measure."""
    from experiments.draw import scoreboard  # not before: matplotlib takes its time to load

    scores = {title_of(entry): {name: score_of(entry, name) for name in names} for entry in entries}
    words = {name: name if name != COST else f"{name} (logarithmic)" for name in names}
    return scoreboard.draw(scoreboard.tabulate(scores), words, CHANCE, title, NOTE)


def draw(run: Run) -> Figure:
    """Draw the scores of a run beside those of the models that ship."""
    entry = read(run.folder)
    others = [other for other in shipped() if other["model"] != entry["model"] and "(tuned)" not in title_of(other)]
    names = [name for name in (*entry["scores"]["public"], COST) if score_of(entry, name)
             and (name not in MEASURES or MEASURES[name].task not in VARIANTS)]  # fmt: skip
    return board((entry, *others), names, f"{entry['model']} and the models that ship")


def show(run: Run) -> None:
    """Print the table of a run's entry, and where everything is."""
    entry = read(run.folder)
    console.show(pl.DataFrame(lines_of(entry)), f"{entry['model']} in {NAME}")
    out_console.print("Place: among the models that ship, as far as paired 95 % intervals tell them apart.")
    if others := [name for name in MEASURES if name not in entry["scores"]["public"]]:
        out_console.print(f"Does not apply: {'; '.join(others)}.")
    show_files(run.folder, f"{entry['trials']} trials")


KIND = Kind(plan, work, draw, show, renders=None, summary="scores.csv", whole=True)


# To check one.


def forged(folder: Path) -> list[str]:
    """Return what in an entry does not follow from its own rows and files. No code of the entry is run."""
    entry, rows = read(folder), read_parquet(folder / TRIALS)
    if (entry["benchmark"], entry["digest"]) != (NAME, here := digest((*entry["channels"],))):
        raise UsageError(f"{folder}: is of {entry['benchmark']} {entry['digest'][:12]}; here is {NAME} {here[:12]}")
    if rows.schema != ROWS:
        return [f"{TRIALS} has other columns than {NAME}"]
    files = {TRIALS: entry["rows"], **entry["files"]}
    found = [f"{name} is not the file that was entered" for name, sha in files.items()
             if not (folder / name).is_file() or sha256(folder / name) != sha]  # fmt: skip
    inside = [path.relative_to(folder).as_posix() for path in (folder / MODEL).rglob("*") if path.is_file()]
    found += [f"{name} was not entered" for name in inside if name not in files and not name.endswith(".pyc")]
    follows = json.loads(json.dumps(derived(rows, entry["channels"])))
    for kind, seeds in product(("scores", "marks"), ("public", "round", GAP)):
        there, here = (one[kind].get(seeds, {}) for one in (entry, follows))
        found += [f"{kind} {seeds} {name}: {there.get(name)}, its rows give {here.get(name)}"
                  for name in dict.fromkeys((*here, *there)) if there.get(name, "") != here.get(name, "")]  # fmt: skip
    return found


def missing(rows: pl.DataFrame, parts: Mapping[str, Plan[Any]]) -> list[str]:
    """Return which trials of the tasks an entry has no row of, or more rows than there are."""
    expected = {
        (*name.split("/"), trial.index, control)
        for name, plan in parts.items() for trial in plan.trials
        for control in ("", *(CONTROLS if plan.asked.option("controls") else ()))
    }  # fmt: skip
    there = rows.select(KEY).rows()
    lacking, more = len(expected - {*there}), len(there) - len(expected & {*there})
    return [f"{lacking} rows of trials are missing, {more} are of no trial or twice"] if lacking or more else []


def drawn(parts: Mapping[str, Plan[Any]], sample: float, seed: int) -> dict[str, Plan[Any]]:
    """Return the plans of the trials that a verifier does again: a share of all, as its seed draws them."""
    jobs = [(name, trial) for name, plan in parts.items() for trial in plan.trials]
    chosen = stream("benchmark.sample", seed).choice(len(jobs), math.ceil(sample * len(jobs)), replace=False)
    found: dict[str, list[Any]] = {}
    for name, trial in (jobs[place] for place in sorted(chosen)):
        found.setdefault(name, []).append(trial)
    return {name: replace(parts[name], trials=trials) for name, trials in found.items()}


def chance_of_a_miss(of: int, sampled: int, share: float) -> float:
    """Return the chance that ``sampled`` of so many trials have none of a forged share of them."""
    return math.comb(of - math.ceil(share * of), sampled) / math.comb(of, sampled)


def compared(there: pl.DataFrame, here: pl.DataFrame, *, exact: bool) -> list[str]:
    """Return how rows that were made again differ from an entry's.

    Parameters
    ----------
    there, here
        The entry's rows, and those of some trials.
    exact
        Whether they have to be equal to the bit; otherwise `MARGINS` and `FLIPPED` hold.
    """
    both = here.join(there, on=KEY, how="left", suffix="_there", nulls_equal=True)
    found, flips = [], 0
    for name in (name for name in ROWS if name not in KEY):
        for key, a, b in both.select(pl.concat_str(KEY, separator=" "), f"{name}_there", name).iter_rows():
            far = exact or name not in MARGINS or None in (a, b)
            if a != b and not exact and name in WORDS:
                flips += 1
            elif a != b and (far or abs(a - b) > MARGINS[name] * max(1.0, abs(b))):
                found.append(f"{key.strip()}: {name} is {a}, and came out as {b}")
    if flips > FLIPPED * len(WORDS) * max(here.height, 1):
        found.append(f"{flips} of {here.height} rows have other words")
    return found


def verify(folder: Path, sample: float, seed: int, pool: Workers) -> tuple[list[str], str]:
    """Compute an entry's scores from its rows again, and do a share of its trials again.

    Parameters
    ----------
    folder
        The entry's.
    sample, seed
        The share, 0 to 1, and what draws it.
    pool
        Where the trials are done. They run the entry's code.

    Returns
    -------
    list of str, str
        What is not as it says, and how it was compared, in a sentence.

    Raises
    ------
    UsageError
        There is no entry, it is of other tasks, or its model fails in a trial.
    """
    if not 0 <= sample <= 1:
        raise UsageError(f"--sample must be between 0 and 1, got {sample:g}")
    entry, rows = read(folder), read_parquet(folder / TRIALS)
    if found := forged(folder):
        return found, "No trial was done again."
    parts = plans(str(folder / entry["text"]) if entry["files"] else entry["text"], entry["beacon"])
    again = drawn(parts, sample, seed)
    with TemporaryDirectory() as scratch:
        here, machines = played(again, Path(scratch), pool)
    alike = {*machines[RENDERERS]} <= {*entry[RENDERERS]} and len(entry[RENDERERS]) < 2
    exact = alike and [cpu_features()] == entry[CPUS]
    of, done = (sum(len(plan.trials) for plan in one.values()) for one in (parts, again))
    misses = [f"{chance_of_a_miss(of, done, share):.2g} if {share:.0%} are forged" for share in (0.3, 0.1, 0.01)]
    how = "to the bit" if exact else f"within margins, as the renderer or the CPU is another ({MARGINS})"
    return missing(rows, parts) + compared(rows, here, exact=exact), (
        f"{done} of {of} trials, drawn by seed {seed}, were done again and compared {how}."
        f" The chance that they miss all forged trials is {', '.join(misses)}.")  # fmt: skip
