"""A folder of a user's own pictures: replicate r has picture r, behind the objects of clips and on the arena's wall."""

from __future__ import annotations

import os
import re
from pathlib import Path

from experiments.base.errors import UsageError, as_usage_error
from experiments.base.user_code import sha256

DIGITS = 20
"""Numbers in names are compared as if they had as many digits: 2 before 10."""


Pictures = tuple[str, ...]
"""Absolute paths of pictures, in the order of their names, numbers by their value."""


def digests(pictures: Pictures) -> list[str]:
    """Return what ``run.json`` has of pictures: each name with its SHA-256. Where one has changed, no run resumes."""
    return [f"{Path(path).name} {sha256(Path(path))}" for path in pictures]


def folder_pictures(folder: str | os.PathLike[str]) -> Pictures:
    """Find and decode the pictures of a folder; files whose names begin with a dot are left out.

    Raises `UsageError`, in one line, for no folder, an empty one, and a file that is no picture.
    """
    from dsnn.pictures import read_picture  # not before: OpenCV takes its time to load

    option = f"--pictures {folder}"
    try:
        paths = [path.resolve() for path in Path(folder).iterdir() if not path.name.startswith(".")]
    except OSError as error:
        raise UsageError(f"{option}: {error.strerror}") from None
    paths.sort(key=by_number)
    if not paths:
        raise UsageError(f"{option}: must hold one picture or more (PNG, JPEG, TIFF or BMP)")
    with as_usage_error(f"{option}: "):
        for path in paths:
            read_picture(path)
    return tuple(map(str, paths))


def by_number(path: Path) -> str:
    """Return what a file is sorted by: its name, with numbers by their value."""
    return re.sub("[0-9]+", lambda number: number[0].zfill(DIGITS), path.name)
