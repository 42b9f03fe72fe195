"""Files at their places: whether a place can be written is tried first, and what stands there is whole."""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from experiments.bench.core.errors import UsageError, explained

FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""What a system says where there is no room for a file: on the disk, in a quota, in the limit of a file's size."""


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


def part(place: Path, ending: str = "") -> Path:
    """Return where a file or a folder is written until it is whole: NAME.part beside it, and an ``ending``."""
    return place.with_name(f"{place.name}.part{ending}")


@contextlib.contextmanager
def replacing(path: Path, ending: str = "") -> Iterator[Path]:
    """Write a file so that it has its name when it is whole and on the disk, or not at all.

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

    Raises
    ------
    OSError
        It cannot be written: as `naming` says it.
    """
    partial = part(path, ending)
    with naming(path):
        try:
            yield partial
            with partial.open("rb") as file:
                os.fsync(file.fileno())
            partial.replace(path)
        except BaseException:
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
            raise


@contextlib.contextmanager
def replacing_folder(folder: Path) -> Iterator[Path]:
    """Yield a folder beside ``folder``, which it replaces when the block is done; when that fails it is removed.

    Raises ``OSError`` as `naming` says it.
    """
    partial = part(folder)
    with naming(folder):
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        try:
            yield partial
            if folder.is_dir() and not folder.is_symlink():
                shutil.rmtree(folder)
            else:
                folder.unlink(missing_ok=True)
            partial.rename(folder)
        finally:
            shutil.rmtree(partial, ignore_errors=True)


@contextlib.contextmanager
def naming(path: Path) -> Iterator[None]:
    """Let an ``OSError`` of the block name ``path``, and of a full disk the room that is left beside it.

    Libraries name the part that they were writing, or nothing. An error that names another file stays as it is.
    """
    try:
        yield
    except OSError as error:
        other = error.filename is not None and not str(error.filename).startswith(f"{path}.")
        if error.errno is None or other:
            raise
        raise OSError(error.errno, f"{os.strerror(error.errno)}{_room(error, path.parent)}", str(path)) from None


def told(error: BaseException) -> str:
    """An error in one line; of an ``OSError`` the file and the reason."""
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return explained(error)


def _room(error: OSError, folder: Path) -> str:
    """How much is free where a file found no room; empty of another error."""
    if error.errno not in FULL:
        return ""
    with contextlib.suppress(OSError):
        return f" ({shutil.disk_usage(folder).free / 2**20:,.1f} MB are free in {folder})"
    return ""


def _try(folder: Path, name: str, asked: str) -> None:
    made: list[Path] = []
    try:
        for each in (*reversed(folder.parents), folder):
            if not each.is_dir():
                each.mkdir()
                made.append(each)
        (folder / name).touch(exist_ok=True)
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
