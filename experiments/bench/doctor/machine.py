"""Checks of the machine: cores, memory, the folder that runs are written into."""

from __future__ import annotations

import contextlib
import os
import shutil
import time
from pathlib import Path

from filelock import FileLock

from experiments.bench.doctor.finding import Finding
from experiments.bench.doctor.memory import LEAST_MB, limit_mb

TEST_BYTES = 4 * 2**20
LEAST_FREE_MB = 500
"""A run of the paper's speed tests with its recordings takes some 60 MB; a whole reproduction some hundreds."""


def cores() -> Finding:
    """Say how many cores this process may use."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return Finding("cores", "ok", f"{usable} usable of {os.cpu_count()}: so many workers by default")


def memory() -> Finding:
    """Compare the memory that is free, and the limit of this process, with what a worker needs."""
    free = _available_mb()
    limit = limit_mb()
    amounts = ", ".join(
        text
        for text in (
            f"{free:,.0f} MB free" if free is not None else "",
            f"limited to {limit:,.0f} MB for each process (ulimit -v)" if limit is not None else "",
        )
        if text
    )
    if limit is not None and limit < LEAST_MB:
        return Finding("memory", "fails", amounts, f"raise the limit: a process needs {LEAST_MB:,} MB of address space")
    if free is not None and free < LEAST_MB:
        return Finding("memory", "notice", amounts, "use fewer workers: --workers 1")
    return Finding("memory", "ok", amounts or "not known on this system")


def _available_mb() -> float | None:
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
            if line.startswith("MemAvailable:"):
                return int(line.split()[1]) / 1024
    return None


def run_folder(folder: Path) -> Finding:
    """Write, lock, read and remove a file where runs go.

    Parameters
    ----------
    folder
        The folder, or one to be made; what is made is removed again.
    """
    name = f"run folder {folder}"
    remedy = "choose another by --out, or make this one writable"
    above = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    is_new = not folder.exists()
    trial = folder / f".colias-doctor-{os.getpid()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        begun = time.perf_counter()
        with trial.open("wb") as file:
            file.write(os.urandom(TEST_BYTES))
            file.flush()
            os.fsync(file.fileno())
        spent = time.perf_counter() - begun
        whole = trial.stat().st_size == TEST_BYTES
        text = _locks(trial.with_suffix(".lock"))
        free = shutil.disk_usage(above).free / 2**20
    except OSError as error:
        return Finding(name, "fails", f"cannot be written: {error.strerror or error}", remedy)
    finally:
        for path in (trial, trial.with_suffix(".lock")):
            with contextlib.suppress(OSError):
                path.unlink(missing_ok=True)
        if is_new:
            with contextlib.suppress(OSError):
                folder.rmdir()
    if not whole:
        return Finding(name, "fails", "a file written there is not whole", remedy)
    text = f"writable, {TEST_BYTES / 2**20 / spent:,.0f} MB/s to the disk, {free:,.0f} MB free{text}"
    if free < LEAST_FREE_MB:
        return Finding(name, "notice", text, "free some space: recordings take some MB for each trial")
    return Finding(name, "ok", text)


def _locks(path: Path) -> str:
    """Return what is to be said of the file system's locks; empty where they work."""
    try:
        with FileLock(path, timeout=1):
            return ""
    except (OSError, NotImplementedError):
        return "; it has no locks, so do not start two runs into one folder"
