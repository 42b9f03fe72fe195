"""Copies of the user's own files in a run's folder, such as its model and what that imports: they repeat it.

They lie in the folder ``files`` as the originals do to one another, so that what imports its neighbour does so there
too. Nothing is executed on copying, and a copy is a plain file, whatever the original was.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from experiments.bench.engine.errors import UsageError, short
from experiments.bench.engine.user_code import sha256
from experiments.bench.engine.user_modules import is_users
from experiments.bench.store.places import inside, regular, replacing

FOLDER = "files"
MOST_BYTES = 64 * 2**20
"""What a run's copies may have together. A trained policy has some MB."""
COPIED, IMPORT_FROM, LEFT_OUT = "copied", "import_from", "left_out"
"""Entries of the note: original -> place in `FOLDER`; places that modules were imported from; original -> why not."""


def plan(files: Mapping[str, str]) -> dict[str, Any]:
    """Say where the copies of files are to lie.

    Parameters
    ----------
    files
        SHA-256 by absolute path, as in ``experiment.json``.

    Returns
    -------
    dict
        The note ``copies``. What is too large, or has changed since it was loaded, is in ``left_out``; the smallest
        are taken first.
    """
    left_out: dict[str, str] = {}
    sizes: dict[str, int] = {}
    for path, expected in files.items():
        try:
            size = regular(Path(path)).stat().st_size
            if size > MOST_BYTES:
                left_out[path] = _too_large(size)
            elif sha256(Path(path)) != expected:
                left_out[path] = "it was edited after the run had loaded it"
            else:
                sizes[path] = size
        except OSError as error:
            left_out[path] = f"it cannot be read ({error.strerror})"
    total = 0
    for path in sorted(sizes, key=lambda path: (sizes[path], path)):
        total += sizes[path]
        if total > MOST_BYTES:
            left_out[path] = _too_large(sizes[path])
    copied = [path for path in files if path not in left_out]
    roots = {root for entry in sys.path if (root := _root(entry, copied))}
    above = os.path.commonpath([*(str(Path(path).parent) for path in copied), *roots]) if copied else ""
    return {
        COPIED: {path: Path(path).relative_to(above).as_posix() for path in copied},
        IMPORT_FROM: sorted(Path(root).relative_to(above).as_posix() for root in roots),
        **({LEFT_OUT: left_out} if left_out else {}),
    }


def _too_large(size: int) -> str:
    return f"it has {size / 2**20:,.1f} MB, and the copies of a run have {MOST_BYTES / 2**20:.0f} MB at most"


def _root(entry: str, copied: list[str]) -> str:
    """Return the folder of an entry of ``sys.path``, where files to be copied are in it; empty otherwise."""
    try:
        root = Path(entry).resolve()
    except (OSError, ValueError):
        return ""
    return str(root) if root != root.parent and any(Path(path).is_relative_to(root) for path in copied) else ""


def digests(folder: Path, files: object) -> dict[str, str]:
    """Return the entry ``files`` of a run's description, checked; none where it is left out.

    Raises
    ------
    UsageError
        It is no object of texts.
    """
    if files is None:
        return {}
    if not isinstance(files, dict) or not all(isinstance(digest, str) for digest in files.values()):
        raise UsageError(f"{folder}: experiment.json cannot be read (files should be an object of texts)")
    return files


def write(folder: Path, files: Mapping[str, str], note: Mapping[str, Any]) -> None:
    """Write the copies that a run's folder lacks, of originals that are as they were.

    Parameters
    ----------
    folder
        The run's folder.
    files
        SHA-256 by absolute path.
    note
        From `plan`.

    Raises
    ------
    OSError
        A copy cannot be written.
    UsageError
        A folder on the way to a copy is a link, or the note is no note of copies.
    """
    for path, place in places(folder, note).items():
        if path not in files or (place.is_file() and not place.is_symlink()):
            continue
        try:
            data = regular(Path(path)).read_bytes()
        except OSError:
            continue
        if hashlib.sha256(data).hexdigest() == files[path]:
            place.parent.mkdir(parents=True, exist_ok=True)
            with replacing(place) as partial:
                partial.write_bytes(data)


def places(folder: Path, note: Any) -> dict[str, Path]:
    """Return where the copies are, by their originals' paths, each checked to lie in the run's folder without links.

    Raises
    ------
    UsageError
        One does not, or the note is none.
    """
    copied = note.get(COPIED) if isinstance(note, Mapping) else None
    if not isinstance(copied, Mapping):
        raise UsageError(f"{folder}: experiment.json cannot be read (copies should have an object called {COPIED})")
    return {path: _place(folder, name) for path, name in copied.items()}


def import_folders(folder: Path, note: Mapping[str, Any]) -> list[Path]:
    """Return the folders of copies that modules are imported from by their names, as from ``sys.path``."""
    listed = note.get(IMPORT_FROM, [])
    if not isinstance(listed, list):
        raise UsageError(f"{folder}: experiment.json cannot be read ({IMPORT_FROM} should be a list)")
    return [_place(folder, name) for name in listed]


def _place(folder: Path, name: Any) -> Path:
    parts = PurePosixPath(name).parts if isinstance(name, str) else ()
    if not isinstance(name, str) or name.startswith("/") or ".." in parts or "\0" in name:
        raise UsageError(f"{folder}: experiment.json: a copy at {short(name)}: legal is a path in {FOLDER}")
    place = inside(folder, FOLDER)
    for part in parts:
        place = inside(place, part)
    return place


def check(folder: Path, files: Mapping[str, str], note: Any) -> dict[str, Path]:
    """Hold the copies against their digests, and the folder of them against what it should hold.

    Parameters
    ----------
    folder
        The run's folder.
    files
        SHA-256 by absolute path.
    note
        The run's note of copies.

    Returns
    -------
    dict of str to Path
        Where each copy is, by its original's path.

    Raises
    ------
    UsageError
        A file has no copy, a copy has changed, or there is a file that the run did not put there: an import could find
        it. In one line that names the file.
    """
    copies = places(folder, note)
    left_out = note.get(LEFT_OUT, {})
    for path, expected in files.items():
        if path not in copies:
            why = left_out.get(path) if isinstance(left_out, Mapping) else None
            raise UsageError(f"{folder}: has no copy of {path}{f': {why}' if why else ''}")
        try:
            digest = sha256(regular(copies[path]))
        except OSError as error:
            raise UsageError(f"{copies[path]}: cannot be read ({error.strerror})") from None
        if digest != expected:
            differ = f"SHA-256 {digest[:12]}, and {str(expected)[:12]} is noted"
            raise UsageError(f"{copies[path]}: has changed since the run was made ({differ})")
    known = {copies[path] for path in files}
    there = sorted((folder / FOLDER).rglob("*")) if files else []
    for place in there:
        if place.is_symlink() or (place not in known and not place.is_dir()):
            raise UsageError(f"{place}: the run did not put this there, and an import could find it: remove it")
    return {path: copies[path] for path in files}


def made_here(files: Mapping[str, str]) -> bool:
    """Say whether all the originals are here, are this user's own, and are as the run had them.

    Then to execute their copies is to execute what this user has already executed. On Windows nobody knows, as files
    have no owner that `os` tells.
    """
    if not hasattr(os, "getuid"):
        return False
    try:
        return all(
            is_users(Path(path)) and Path(path).stat().st_uid == os.getuid() and sha256(Path(path)) == digest
            for path, digest in files.items()
        )
    except OSError:
        return False


def left_out_notes(note: Any) -> list[str]:
    """Return a line for each file of a run that it has no copy of."""
    left_out = note.get(LEFT_OUT, {}) if isinstance(note, Mapping) else {}
    return [f"{path} was not copied: {why}; colias rerun will refuse" for path, why in left_out.items()]
