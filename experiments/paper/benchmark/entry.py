"""An entry of the benchmark: its files, where it stands among others, and whether it is what its author says."""

from __future__ import annotations

import json
import math
import shutil
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import polars as pl

from experiments.base.console import progress
from experiments.base.errors import UsageError
from experiments.base.files import Files, read_parquet
from experiments.base.streams import stream
from experiments.base.user_code import digests, is_own, sha256
from experiments.declare.outcome import MARGIN
from experiments.judge.tests import Score
from experiments.paper.benchmark.rows import MEASURES, ROWS, Sides, difference, row_of, summed
from experiments.paper.benchmark.tasks import NAME, digest_of, document, plans
from experiments.settings.models import CONTROLS, ConfiguredModel, parse_model
from experiments.store.plan import Plan
from experiments.store.tables import TrialRecord, cpu_features, table
from experiments.store.workers import Workers, finished

ENTRY, TRIALS, MODEL = "entry.json", "trials.parquet", "model"
GAP = "public less round"
"""Scores by the paired difference of both: what a model that was tuned on the public seeds loses."""
KEY = ("seeds", "task", "trial", "control")
MARGINS = {
    "strength": MARGIN["potential"], "looming": MARGIN["potential"], "alarms": 1.0, "contact_s": 0.1, "flow_r": 0.02,
    "on_target": 0.05,
}  # fmt: skip
"""Column -> difference that another renderer or CPU explains; shares of its value as large are explained too."""
FLIPPED = 0.05
"""Share of words, such as whether the direction was right, that may differ there."""
SHIPPED = Path(__file__).parent / "entries"


@cache
def digest(channels: tuple[str, ...]) -> str:
    """Return the digest of the tasks for a model with some channels: what is shown, in which scenes, and margins."""
    return digest_of(document(channels), MARGINS, FLIPPED)


def numbers(score: Score | None) -> list[float | None] | None:
    """Return value, ends of the interval and n as JSON has them; ``None`` where there was no response."""
    if score is None or math.isnan(score.value):
        return None
    return [round(value, 6) if math.isfinite(value) else None for value in (score.value, score.low, score.high)] + [
        score.n]  # fmt: skip


def derived(rows: pl.DataFrame, channels: Sequence[str]) -> dict[str, Any]:
    """Return what of an entry follows from its rows: scores and marks by seeds, and public less round scores."""
    scores: dict[str, dict[str, Any]] = {}
    marks: dict[str, dict[str, Sides]] = {}
    for (seeds,), part in rows.partition_by("seeds", as_dict=True, maintain_order=True).items():
        found, marks[seeds] = summed(part, channels)
        scores[seeds] = {name: numbers(score) for name, score in found.items()}
    if len(marks) > 1:
        scores[GAP] = {name: numbers(difference(sides, marks["round"][name]))
                       for name, sides in marks["public"].items() if sides}  # fmt: skip
    return {"scores": scores, "marks": marks}


def write(out: Path, model: ConfiguredModel, rows: pl.DataFrame, about: Mapping[str, Any]) -> dict[str, Any]:
    """Write the files of an entry, but for its figure and its page.

    Parameters
    ----------
    out
        Its folder.
    model
        The model.
    rows
        Of `ROWS`, of this model and its controls.
    about
        What else ``entry.json`` has: the round, what it costs, what computed it.
    """
    files, text = {}, model.text or model.source
    if is_own(model.source):
        source = Path(model.source)
        for path, sha in digests(source).items():
            if Path(path).is_relative_to(source.parent):
                place = f"{MODEL}/{Path(path).relative_to(source.parent)}"
                (out / place).parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(path, out / place)
                files[place] = sha
        text = f"{MODEL}/{source.name}{text.removeprefix(parse_model(text)[0])}"
    Files(out).write_table(out / TRIALS, rows.select(ROWS.names()))
    entry = {
        "benchmark": NAME, "digest": digest(model.channels), "model": model.label, "text": text,
        "channels": model.channels, "files": files, "rows": sha256(out / TRIALS),
        "trials": rows.filter(control="").height, **about, **derived(rows, model.channels),
    }  # fmt: skip
    Files(out).write_json(ENTRY, entry)
    return read(out)


def read(folder: Path) -> dict[str, Any]:
    """Return the entry in a folder; `UsageError` where there is none."""
    path = folder / ENTRY
    if not path.is_file():
        raise UsageError(f"{folder}: no {ENTRY} there: colias benchmark MODEL --out {folder} makes one")
    entry: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return entry


def shipped() -> list[dict[str, Any]]:
    """Return the entries that ship."""
    return [json.loads(path.read_text(encoding="utf-8")) for path in sorted(SHIPPED.glob("*.json"))]


# Where it stands.


def place(entry: Mapping[str, Any], others: Iterable[Mapping[str, Any]], name: str) -> str:
    """Return the places that a model may have by a measure, such as ``2 to 4 of 9``; empty where none is told.

    A model is above another only where the interval of their paired marks excludes 0. Entries of one round are compared
    on its seeds, others on the public ones. One whose title says that it is tuned takes no place from others.
    """
    above = below = count = 0
    for other in others:
        seeds = "round" if entry["beacon"] and entry["beacon"] == other["beacon"] else "public"
        mine, theirs = (one["marks"][seeds].get(name) for one in (entry, other))
        if (
            other["model"] == entry["model"]
            or "(tuned)" in other.get("title", "")
            or not mine
            or not theirs
            or name not in MEASURES
        ):
            continue
        apart = difference(mine, theirs)
        low, high = sorted(MEASURES[name].better * end for end in (apart.low, apart.high))
        count, above, below = count + 1, above + (high < 0), below + (low > 0)
    best, worst = above + 1, count + 1 - below
    return "" if not count else f"{best} of {count + 1}" if best == worst else f"{best} to {worst} of {count + 1}"


# Whether it is what it says.


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


def drawn(parts: Mapping[str, Plan[Any]], sample: float, seed: int) -> dict[str, list[Any]]:
    """Return the trials that a verifier does again, by part: a share of all, as its seed draws them."""
    jobs = [(name, trial) for name, plan in parts.items() for trial in plan.trials]
    chosen = stream("benchmark.sample", seed).choice(len(jobs), math.ceil(sample * len(jobs)), replace=False)
    return {name: [jobs[i][1] for i in sorted(chosen) if jobs[i][0] == name] for name in parts}


def chance_of_a_miss(of: int, sampled: int, share: float) -> float:
    """Return the chance that ``sampled`` of so many trials have none of a forged share of them."""
    false = math.ceil(share * of)
    return math.comb(of - false, sampled) / math.comb(of, sampled)


def rows_of(name: str, trial: Any, record: TrialRecord) -> list[dict[str, Any]]:
    """Return the rows of a trial that was done again, as an entry has them."""
    seeds, task = name.split("/")
    frames = record.frames.partition_by("model", as_dict=True) if record.frames.height else {}
    return [row_of(seeds, task, row, trial, frames.get((row["model"],))) for row in record.rows]


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
            margin = MARGINS.get(name, 0.0)
            near = a is not None and b is not None and abs(a - b) <= max(margin, margin * abs(b)) if margin else False
            flips += not exact and name in ("right", "spiked") and a != b
            if a != b and (exact or not (near or name in ("right", "spiked"))):
                found.append(f"{key.strip()}: {name} is {a}, and came out as {b}")
    if flips > FLIPPED * 2 * max(here.height, 1):
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
    """
    if not 0 <= sample <= 1:
        raise UsageError(f"--sample must be between 0 and 1, got {sample:g}")
    entry, rows = read(folder), read_parquet(folder / TRIALS)
    if found := forged(folder):
        return found, "No trial was done again."
    parts = plans((str(folder / entry["text"]) if entry["files"] else entry["text"],), entry["beacon"])
    again = drawn(parts, sample, seed)
    made, machines, trouble = [], set(), missing(rows, parts)
    with pool.running(), progress("verify", sum(map(len, again.values())), pool.quiet) as advance:
        for name, trials in again.items():
            work = parts[name].work
            assert work is not None, "a task has trials"
            for trial, record, failure in finished(trials, work, pool):
                wrong = [failure] if record is None else record.troubles.values()
                trouble += [f"{name} {trial.index} failed: {text}" for text in wrong]
                if record is not None:
                    made += rows_of(name, trial, record)
                    machines.add((record.renderer, record.cpu))
                advance()
    drawers = {renderer for renderer, _ in machines} - {""}
    exact = drawers <= {*entry["renderers"]} and [cpu_features()] == entry["cpus"] and len(entry["renderers"]) < 2
    trouble += compared(rows, table(made, ROWS), exact=exact)
    of, done = sum(len(plan.trials) for plan in parts.values()), sum(map(len, again.values()))
    misses = [f"{chance_of_a_miss(of, done, share):.2g} if {share:.0%} are forged" for share in (0.3, 0.1, 0.01)]
    how = "to the bit" if exact else f"within margins, as the renderer or the CPU is another ({MARGINS})"
    return trouble, (f"{done} of {of} trials, drawn by seed {seed}, were done again and compared {how}."
                     f" The chance that they miss all forged trials is {', '.join(misses)}.")  # fmt: skip
