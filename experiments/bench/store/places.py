"""Files that are whole at every moment: each is written beside its place, as NAME.part, then renamed into it."""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import Iterator
from pathlib import Path


def part(place: Path, ending: str = "") -> Path:
    """Return where a file or a folder is written until it is whole: NAME.part beside it, and an ``ending``."""
    return place.with_name(f"{place.name}.part{ending}")


@contextlib.contextmanager
def replacing(path: Path, ending: str = "") -> Iterator[Path]:
    """Write a file so that it has its name when it is whole, or not at all.

    Parameters
    ----------
    path
        The file.
    ending
        How the name of the part has to end, where a library chooses the format by that.

    Yields
    ------
    Path
        The part, NAME.part beside the file. The caller writes it; after an error it is removed.
    """
    partial = part(path, ending)
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextlib.contextmanager
def replacing_folder(folder: Path) -> Iterator[Path]:
    """Yield a folder beside ``folder``, which it replaces when the block is done; when that fails it is removed."""
    partial = part(folder)
    shutil.rmtree(partial, ignore_errors=True)
    partial.mkdir(parents=True)
    try:
        yield partial
        shutil.rmtree(folder, ignore_errors=True)
        partial.rename(folder)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
