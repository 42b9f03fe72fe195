"""Whether results can be written where a person wants them, tried before anything is computed, and only there.

A folder that was handed over may hold links. Nothing is written through them to a place outside of it.
"""

from __future__ import annotations

import contextlib
import os
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
    """Try whether files can be written into a folder, which is made for that if need be.

    Nothing of the trial is left: neither its file nor the folders that were made for it.

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
    made: list[Path] = []
    try:
        for each in (*reversed(folder.parents), folder):
            if not each.is_dir():
                each.mkdir()
                made.append(each)
        fresh(folder / name).touch(exist_ok=False)
        (folder / name).unlink()
    except OSError as error:
        raise UsageError(f"{asked}: {_why(error)}") from None
    finally:
        for each in reversed(made):
            with contextlib.suppress(OSError):  # another process may use it already
                each.rmdir()


def _why(error: OSError) -> str:
    place = error.filename
    if isinstance(error, FileExistsError | NotADirectoryError):
        return f"{place} is a file, not a folder"
    return f"{place} cannot be made ({error.strerror})"
