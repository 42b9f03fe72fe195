"""A folder of a user's own pictures: replicate r has picture r, behind the objects of clips and on the arena's wall."""

from __future__ import annotations

import hashlib
import os
import re
from dataclasses import dataclass
from pathlib import Path

from experiments.bench.run.errors import UsageError

DIGITS = 20
"""Numbers in names are compared as if they had as many digits: 2 before 10."""


@dataclass(frozen=True, slots=True)
class Pictures:
    """Pictures in the order of their names, numbers by their value.

    Parameters
    ----------
    files
        Their absolute paths.
    digests
        SHA-256 of each: a run is not gone on with where a picture has changed.
    """

    files: tuple[str, ...]
    digests: tuple[str, ...]

    def of(self, replicate: int) -> str:
        """Return the path of a replicate's picture. After the last one the first comes again."""
        return self.files[replicate % len(self.files)]

    def described(self) -> list[str]:
        """Return what ``run.json`` has of them: each name with its digest."""
        return [f"{Path(path).name} {digest}" for path, digest in zip(self.files, self.digests, strict=True)]


def folder_pictures(folder: str | os.PathLike[str]) -> Pictures:
    """Find and decode the pictures of a folder; files whose names begin with a dot are left out.

    Raises `UsageError`, in one line, for no folder, an empty one, and a file that is no picture.
    """
    from dsnn.pictures import read_picture  # not before: OpenCV takes its time to load

    place = Path(folder)
    option = f"--pictures {folder}"
    if not place.is_dir():
        raise UsageError(f"{option}: {'not a folder' if place.exists() else 'there is no such folder'}")
    try:
        paths = [path.resolve() for path in place.iterdir() if not path.name.startswith(".")]
    except OSError as error:
        raise UsageError(f"{option}: cannot be read ({error.strerror})") from None
    paths.sort(key=by_number)
    if not paths:
        raise UsageError(f"{option}: must hold one picture or more (PNG, JPEG, TIFF or BMP)")
    try:
        for path in paths:
            read_picture(path)
    except ValueError as error:
        raise UsageError(f"{option}: {error}") from None
    digests = tuple(hashlib.sha256(path.read_bytes()).hexdigest() for path in paths)
    return Pictures(tuple(map(str, paths)), digests)


def by_number(path: Path) -> str:
    """Return what a file is sorted by: its name, with numbers by their value."""
    return re.sub("[0-9]+", lambda number: number[0].zfill(DIGITS), path.name)
