"""A folder of a user's own pictures: a film, or replicate r has picture r, behind objects and on the arena's wall."""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from itertools import accumulate, pairwise
from pathlib import Path
from statistics import median_low

from experiments.base.console import error_console
from experiments.base.errors import UsageError, as_usage_error
from experiments.base.user_code import sha256

NUMBER = re.compile(r"((?:(?<![^\W_])[-+])?[0-9]+)")
"""A number in a name. A sign is one of its own: the hyphen of ``frame-1`` follows a letter, and joins."""
OTHERS = "{n} entries of the folder are no pictures and are left out, the first is {first}"

Pictures = tuple[str, ...]
"""Absolute paths of pictures, in the order of their names, numbers by their value."""


def digests(pictures: Pictures) -> list[str]:
    """Return what ``run.json`` has of pictures: each name with its SHA-256. Where one has changed, no run resumes."""
    return [f"{Path(path).name} {sha256(Path(path))}" for path in pictures]


def folder_pictures(folder: str | os.PathLike[str]) -> Pictures:
    """Find and decode the pictures of a folder; other files and folders in it are left out, with a note.

    Raises `UsageError`, in one line, for no folder, one without pictures, and a picture that cannot be read.
    """
    from dsnn.pictures import read_picture  # not before: OpenCV takes its time to load

    option = f"--pictures {folder}"
    try:
        paths, others = entries(Path(folder).resolve())
    except OSError as error:
        raise UsageError(f"{option}: {error.strerror}") from None
    if not paths:
        raise UsageError(f"{option}: must hold one picture or more (PNG, JPEG, TIFF or BMP)")
    if others:
        error_console.print(f"note: {option}: {OTHERS.format(n=len(others), first=others[0])}")
    with as_usage_error(f"{option}: "):
        for path in paths:
            read_picture(path)
    return tuple(map(str, paths))


def entries(folder: Path) -> tuple[list[Path], list[str]]:
    """Return the pictures of a folder in the order of their numbers, and the names of what else it has.

    Names that begin with a dot are left out. A picture is a file that begins as those do that OpenCV reads.
    """
    import cv2

    paths = sorted((path for path in folder.iterdir() if not path.name.startswith(".")), key=by_number)
    pictures = {path: None for path in paths if path.is_file() and cv2.haveImageReader(str(path))}
    return list(pictures), [path.name for path in paths if path not in pictures]


def by_number(path: Path) -> tuple[list[str | int], str]:
    """Return what a file is sorted by: its name, with numbers by their value and sign."""
    return [int(part) if i % 2 else part for i, part in enumerate(NUMBER.split(path.stem))], path.name


def frame_numbers(paths: Sequence[Path]) -> list[int]:
    """Return the frame that each picture is, from 0, by the last number in its name, where only that differs.

    The numbers' step is the smallest if all others are multiples of it, as of a counter, and otherwise the median, as
    of times.
    """
    names = [by_number(path)[0] for path in paths]
    alike = [len(a) > 1 and [*a[:-2], a[-1]] == [*b[:-2], b[-1]] for a, b in pairwise(names)]
    steps = [int(b[-2]) - int(a[-2]) if same else 0 for same, (a, b) in zip(alike, pairwise(names), strict=True)]
    counted = [step for step in steps if step] or [1]
    step = min(counted) if not any(one % min(counted) for one in counted) else median_low(counted)
    return list(accumulate((max(round(one / step), 1) for one in steps), initial=0))
