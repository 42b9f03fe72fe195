"""Ctrl-C at any moment of a command's first three seconds, and what has to be true afterwards."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import pyarrow.csv
import pyarrow.parquet as pq

from tests.attack.commands import CLIPS, EXPERIMENT, film
from tests.attack.judging import strict_json
from tests.attack.processes import ROOT, Ended, Interrupt, colias
from tests.attack.scale import FULL

LAST_S = 3.0
MOMENTS = 30
"""Over all commands; in the full attack for each, where COLIAS_ATTACK_MOMENTS=N gives each command N."""

OPENING = ("/__init__.py", "/__main__.py", "/entry.py", "/interrupts.py")
"""The modules of ours that are imported before Ctrl-C is taken over."""

SHARED = ("tiny.py", "clips.py", "film.avi", "kept.rrd", "__pycache__")


@dataclass(frozen=True, slots=True)
class Job:
    """A command to interrupt. ``again`` is what goes on with it, if that does not take long."""

    name: str
    words: tuple[str, ...]
    makes: tuple[str, ...] = ()
    """What is there when it has ended with 0."""
    again: tuple[str, ...] = ()
    folder: bool = True
    """Whether what it makes is a run's folder, in which parts of files may be left."""

    def count(self) -> int:
        """At how many moments to interrupt it."""
        return len(range(*self._numbers()))

    def moments(self) -> list[Interrupt]:
        """When to interrupt it: the process alone and its group in turns."""
        begin, count, step = self._numbers()
        first = start_s()
        return [
            Interrupt(first + (LAST_S - first) * i / max(count - 1, 1), group=bool((i + i // 2) % 2))
            for i in range(begin, count, step)
        ]

    def _numbers(self) -> tuple[int, int, int]:
        """Its share of the moments' numbers, as of a range."""
        count = int(os.environ.get("COLIAS_ATTACK_MOMENTS", 0))
        if count or FULL:
            return 0, count or MOMENTS, 1
        return [job.name for job in JOBS].index(self.name), MOMENTS, len(JOBS)


_RUN = ("run", "tiny.py", "--repeats", "15", "--workers", "2")
_CLIPS = ("run", "clips.py", "--repeats", "10", "--workers", "2")
_MAP = ("map", "tiny.py", "--measure", "spikes", "--over", "dsnn.n_con=4,6,8", "--repeats", "3", "--workers", "2",
        "--out", "out")  # fmt: skip
_TUNE = ("tune", "--model", "dsnn", "--curve", "size", "--workers", "2", "--out", "out")
_BEHAVE = (
    "behave",
    "still",
    "--env",
    "Avoidance",
    "--no-baselines",
    "--episodes",
    "2",
    "--workers",
    "2",
    "--out",
    "out",
)
_BIG = ("cluttered", "--set", "cluttered.speed=20")

JOBS = (
    Job("run", (*_RUN, "--out", "out"), ("out/trials.parquet", "out/figure.svg"), (*_RUN, "--out", "out")),
    Job("run-clips", (*_CLIPS, "--out", "out"), ("out/trials.parquet", "out/figure.svg"), (*_CLIPS, "--out", "out")),
    Job("map", _MAP, ("out/counts.csv",), _MAP),
    Job("tune", _TUNE, ("out/tuning.csv",), _TUNE),
    Job("leaderboard", ("leaderboard", "--repeats", "1", "--workers", "2", "--out", "out"), ("out/leaderboard.csv",)),
    Job("behave", _BEHAVE, ("out/scores.csv",), _BEHAVE),
    Job("reproduce", ("reproduce", "--quick", "--workers", "2", "--out", "out"), ("out/report.html",)),
    Job(
        "watch", ("watch", "film.avi", "--no-view", "--table", "out.parquet", "--record", "out.rrd"),
        ("out.parquet", "out.rrd"), folder=False,
    ),
    Job("play", ("play", *_BIG, "--no-view", "--record", "out.rrd"), ("out.rrd",), folder=False),
    Job("stimulus", ("stimulus", *_BIG, "--out", "out.avi"), ("out.avi", "out.csv"), folder=False),
    Job("list", ("list",), folder=False),
    Job("parameters", ("parameters",), folder=False),
    Job("view", ("view", "kept.rrd", "--web"), folder=False),
)  # fmt: skip


def furnish(folder: Path) -> None:
    """What the commands need."""
    (folder / "tiny.py").write_text(EXPERIMENT.format(repeats=1, speeds="(20, 25)"))
    (folder / "clips.py").write_text(CLIPS)


def share(folder: Path) -> None:
    """The same, and what takes time to make: a long film, a recording."""
    furnish(folder)
    film(folder / "film.avi", 6000)
    ended = colias(folder, ["play", "plain", "--no-view", "--record", "kept.rrd"])
    assert ended.status == 0, ended


@cache
def start_s() -> float:
    """How long Python itself takes to start here and now: until then an interrupt is its own affair."""

    def once() -> float:
        began = time.perf_counter()
        subprocess.run([sys.executable, "-c", "pass"], check=True)
        return time.perf_counter() - began

    return max(once() for _ in range(5))


def problems(job: Job, when: Interrupt, folder: Path) -> list[str]:
    """Interrupt the command there and then; everything that is not as promised."""
    ended = colias(folder, job.words, interrupt=when, timeout_s=60.0)
    if _before_the_entry(ended, when):
        return []
    faults = [f"says {word!r}: {_where(ended, word)}" for word in ended.crashes()]
    faults += [f"left a process: {left}" for left in ended.left]
    if ended.status is None:
        faults.append("does not end")
    elif ended.status not in (0, 130):
        faults.append(f"exit status {ended.status}: {' | '.join(ended.err.strip().splitlines()[-2:])[-300:]}")
    elif ended.status == 0:
        faults += [f"status 0 without {name}" for name in job.makes if not (folder / name).exists()]
    faults += list(unreadable(folder))
    if not job.folder:
        known = {*SHARED, *job.makes}
        faults += [f"left {path.name}" for path in folder.iterdir() if path.name not in known]
    kind = "group" if when.group else "process"
    return [f"{job.name}, {kind} at {when.after_s:.2f} s: {fault}" for fault in faults]


def _before_the_entry(ended: Ended, when: Interrupt) -> bool:
    """Whether Python answered before the first line of ours that takes Ctrl-C over: nothing was there to guard yet.

    Until then Python runs its own start, ``site`` with what hangs on it, and the modules that lead to that line.
    """
    early = when.after_s < max(4 * start_s(), 0.25)
    places = [line.strip() for line in ended.err.splitlines() if line.strip().startswith("File ")]
    our_places = [line for line in places if str(ROOT) in line]
    opening = all(line.endswith("in <module>") and line.split('"')[1].endswith(OPENING) for line in our_places)
    library = any("site-packages" in line and "_distutils_hack" not in line for line in places)
    return early and ended.status in (-2, 1, 130) and opening and not library


def _where(ended: Ended, word: str) -> str:
    """The last place of ours in a traceback, and what it ends with."""
    lines = [line.strip() for line in ended.err.splitlines() if line.strip()]
    places = [line for line in lines if line.startswith("File ")]
    our_places = [line.replace(str(ROOT) + "/", "") for line in places if str(ROOT) in line] or places[-1:]
    return f"{our_places[-1][:120] if our_places else ''} ... {lines[-1][:150] if lines else ended.out[-150:]}"


def unreadable(folder: Path) -> Iterator[str]:
    """Files that have their final name and are not whole."""
    for path in folder.rglob("*"):
        if path.is_symlink() or not path.is_file():
            continue
        try:
            if path.suffix == ".parquet":
                pq.read_table(path)
            elif path.suffix == ".csv":
                pyarrow.csv.read_csv(path)
            elif path.suffix == ".json":
                strict_json(path)
            elif path.suffix in (".rrd", ".png", ".svg", ".avi", ".html") and not path.stat().st_size:
                yield f"{path.name} is empty"
        except Exception as error:  # whatever reading raises is the finding
            yield f"{path.name} cannot be read: {type(error).__name__}: {str(error)[:100]}"


def go_on(job: Job, folder: Path) -> list[str]:
    """Go on with what was interrupted."""
    words = job.again
    if job.name.startswith("run") and not (folder / "out" / "experiment.json").exists():
        words = job.words
    ended = colias(folder, words)
    faults = [f"says {word!r}: {_where(ended, word)}" for word in ended.crashes()]
    if ended.status != 0:
        faults.append(f"exit status {ended.status}: {' | '.join(ended.err.strip().splitlines()[-2:])[-300:]}")
    return [f"{job.name}, gone on with: {fault}" for fault in (*faults, *unreadable(folder))]
