"""Whether results can be written where a person wants them, tried before anything is computed, and only there.

A folder that was handed over may hold links. Nothing is written through them to a place outside of it.
"""

from __future__ import annotations

import errno
import os
import shutil
import uuid
from pathlib import Path

from experiments.bench.core.errors import UsageError


def fresh(path: Path) -> Path:
    """Return a path at which nothing is any more: neither a file that was left there nor a link, to be written through.

    Raises ``OSError`` where what is there cannot be removed.
    """
    path.unlink(missing_ok=True)
    return path


def inside(folder: Path, name: str) -> Path:
    """Return the path of what is called ``name`` in a folder of results, and is no link to a place outside of it.

    Parameters
    ----------
    folder
        The folder. It may be a link itself, as a person named it.
    name
        Of a file or folder in it, which need not be there yet.

    Raises
    ------
    UsageError
        It is a link.
    """
    path = folder / name
    if path.is_symlink():
        raise UsageError(
            f"{path}: is a link to {path.readlink()}, outside of what is written here: legal is no link; put what it"
            " points to in its place, or remove it"
        )
    return path


def check_folder(folder: Path, asked: str) -> None:
    """Try whether files can be written into a folder, or into one that would be made there.

    Nothing of the trial is left, and no folder is made that another thread or process could be using.

    Parameters
    ----------
    folder
        The folder.
    asked
        The option and its value, as ``--out runs/mine``: the message begins with it.

    Raises
    ------
    UsageError
        Where that fails, in one line that says why.
    """
    _try(folder, f".colias-{os.getpid()}.part", asked)


def check_file(file: Path, asked: str) -> None:
    """Try whether a file can be written: as `check_folder`, for a file of its name."""
    _try(file.parent, f".{file.name}.{os.getpid()}.part", asked)


def _try(folder: Path, name: str, asked: str) -> None:
    # The folders that lack are tried under another name: another thread or process may be about to use these.
    there = next((each for each in (folder, *folder.parents) if os.path.lexists(each)), Path())
    lacking = folder.relative_to(there).parts
    trial = there / f".colias-{uuid.uuid4().hex}.part"
    try:
        if not there.is_dir():
            raise FileExistsError(errno.EEXIST, "", str(there))
        place = trial
        for part in ("", *lacking):
            place = place / part
            place.mkdir()
        (place / name).touch()
        if not lacking:  # as the file's own name, too
            fresh(there / name).touch(exist_ok=False)
            (there / name).unlink()
    except OSError as error:
        meant = Path(error.filename)
        if meant == trial:
            meant = there / (*lacking, name)[0]
        elif meant.is_relative_to(trial):
            meant = there / meant.relative_to(trial)
        raise UsageError(f"{asked}: {_why(error, meant)}") from None
    finally:
        shutil.rmtree(trial, ignore_errors=True)


def _why(error: OSError, place: Path) -> str:
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"{place} is a file, not a folder"
    return f"{place} cannot be made ({error.strerror})"
