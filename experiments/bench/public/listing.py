"""The runs in a folder: what each is, and how far it got."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import polars as pl

from experiments.bench.public.result import load
from experiments.bench.run.errors import UsageError
from experiments.bench.store.description import begun
from experiments.bench.store.record import Record, part_folders
from experiments.bench.store.rows import table

SCHEMA = pl.Schema(
    {
        "run": pl.String(),
        "when": pl.Datetime("us", "UTC"),
        "experiment": pl.String(),
        "seed": pl.Int64(),
        "models": pl.String(),
        "changed": pl.String(),
        "done": pl.Int64(),
        "planned": pl.Int64(),
        "failures": pl.Int64(),
        "verdicts": pl.String(),
        "provenance": pl.String(),
        "commit": pl.String(),
        "trouble": pl.String(),
    }
)


def runs(folder: str | os.PathLike[str] = "runs") -> pl.DataFrame:
    """List the runs in a folder, oldest first.

    Parameters
    ----------
    folder
        Where runs are, or one run. Folders in it are looked through, down to the parts of sweeps and reproductions.

    Returns
    -------
    polars.DataFrame
        ``run``: its folder. ``when``: when it was begun; null where another version made it. ``experiment``,
        ``seed``, ``models``: what ran. ``changed``: the parameters that are not at their defaults. ``done`` of
        ``planned`` trials are finished, ``failures`` are listed. ``verdicts``: what claims came
        to, ``holds: C1, C2; held in 4 of 5: C5``. ``provenance``:
        ``simulated``, or of an imported log ``measured``, say. ``commit``: what it was begun with, null outside a git
        checkout. ``trouble``: what is wrong with a
        folder that cannot be read, in one line; otherwise null.

    Raises
    ------
    UsageError
        There is no such folder.

    Examples
    --------
    >>> import experiments
    >>> experiments.runs("runs").select("run", "changed", "verdicts")
    """
    path = Path(folder)
    if not path.is_dir():
        raise UsageError(f"{path}: no such folder")
    return table([_row(place) for place in _found(path)], SCHEMA).sort("when", "run")


def _found(folder: Path) -> Iterator[Path]:
    """Yield the folders that are runs, or look as if they had been: those of a whole after it."""
    if begun(folder):
        yield folder
        if not _is_whole(folder):
            return
    for path in part_folders(folder):
        yield from _found(path)


def _is_whole(folder: Path) -> bool:
    try:
        return Record.read(folder).kind.parts
    except UsageError:
        return False


def _row(folder: Path) -> dict[str, Any]:
    row: dict[str, Any] = {"run": str(folder)}
    try:
        run = load(folder)
        return {
            **row, "when": run.begun, "experiment": run.name, "seed": run.seed, "models": ", ".join(run.models),
            "changed": run.changed, "planned": run.planned, "done": run.done, "failures": run.failures.height,
            "verdicts": run.verdicts, "provenance": run.provenance, "commit": run.commit,
        }  # fmt: skip
    except UsageError as error:
        return {**row, "trouble": str(error)}
