"""Files at their places: whether a place can be written is tried first, and what stands there is whole.

A folder that was handed over may hold links. Nothing is written through them to a place outside of it.
"""

from __future__ import annotations

import contextlib
import errno
import os
import shutil
import uuid
from collections.abc import Iterator
from pathlib import Path

from experiments.bench.engine.errors import UsageError, explained

FULL = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EFBIG})
"""What a system says where there is no room for a file: on the disk, in a quota, in the limit of a file's size."""


def fresh(path: Path) -> Path:
    """Return a path at which nothing is any more: neither a file that was left there nor a link, to be written through.

    Raises ``OSError`` where what is there cannot be removed.
    """
    path.unlink(missing_ok=True)
    return path


def regular(path: Path) -> Path:
    """Return the path of what a folder of results holds, which can be read to its end.

    Raises ``OSError`` for a pipe or a device, or a link to one: of ``/dev/zero`` nobody reads the end.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, "a pipe or a device, not a file", str(path))
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


def part(place: Path, ending: str = "") -> Path:
    """Return where a file or a folder is written until it is whole: NAME.part beside it, and an ``ending``.

    Raises
    ------
    UsageError
        The place is given as ``.``, ``/`` or ``..``, without its name.
    """
    if place.name in ("", ".."):
        raise UsageError(f"{place}: legal is a path that ends in the name of what is made there")
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
    with naming(path):
        partial = fresh(part(path, ending))
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
        if partial.is_symlink():
            partial.unlink()
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
    """Return an error in one line; of an ``OSError`` the file and the reason."""
    if isinstance(error, OSError) and error.filename and error.strerror:
        return f"{error.filename}: {error.strerror}"
    return explained(error)


def _room(error: OSError, folder: Path) -> str:
    """Tell how much is free where a file found no room; empty of another error."""
    if error.errno not in FULL:
        return ""
    with contextlib.suppress(OSError):
        return f" ({shutil.disk_usage(folder).free / 2**20:,.1f} MB are free in {folder})"
    return ""


def _try(folder: Path, name: str, asked: str) -> None:
    # The folders that lack are tried under another name: another thread or process may be about to use these.
    there = next((parent for parent in (folder, *folder.parents) if os.path.lexists(parent)), Path())
    lacking = folder.relative_to(there).parts
    trial = there / f".colias-{uuid.uuid4().hex}.part"
    try:
        if not there.is_dir():
            raise FileExistsError(errno.EEXIST, "", str(there))
        place = trial
        for lack in ("", *lacking):
            place = place / lack
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
