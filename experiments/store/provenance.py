"""Provenance of a run's numbers: the project's code, the user's files, the libraries."""

import functools
import hashlib
import importlib.metadata
import json
import os
import platform
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from dsnn import forms
from experiments.base.errors import UsageError, as_usage_error
from experiments.base.user_code import digests, is_own, is_users, package_folders, sha256
from experiments.declare.claim import Claim

LIBRARIES = (
    "colias-sim", "mujoco", "mujoco-core", "numpy", "opencv-python-headless", "gymnasium", "rerun-sdk", "scipy",
    "pyarrow", "polars", "pydantic", "threadpoolctl", "av",
)  # fmt: skip
"""Every library that a number, a table or a recording depends on. The OpenGL renderer is noted apart
(`description.RENDERERS`)."""
KEYS = ("files", "versions", "source", "code")
"""Entries that `of` returns, without the form: they are not parameters of the run."""
SHOWS = (".pyc", ".j2")
"""Suffixes of the packages' files that no number depends on."""
UNREPEATABLE = ("wall_s",)
"""Columns that differ between runs of equal numbers."""


__version__ = importlib.metadata.version("colias-sim")
"""The version of colias-sim that is installed."""


class OtherCode(UsageError):
    """A worker has other code of colias-sim than the process that began the run."""


def of(sources: Iterable[str] = (), experiment: object = None) -> dict[str, Any]:
    """Return the provenance of a run as ``run.json`` holds it.

    Parameters
    ----------
    sources
        Models, behaviours, policies, arenas and pictures; those that are files of the user's own count.
    experiment
        The experiment; the file that declares it counts if it is the user's own.

    Returns
    -------
    dict
        ``files``: SHA-256, by path, of the user's files and of the modules that they import.
        ``versions``: of Python and the libraries. ``source``: see `source`. ``form``: of the networks
        (`dsnn.forms`), which a run never mixes. ``code``: 12 hex digits of a digest of it all; neither
        the commit nor Python's own version enters it.

    Raises
    ------
    UsageError
        The environment asks for a form that is not known, or not built.
    """
    files: dict[str, str] = {}
    for path in (*filter(is_own, sources), *_declaring(experiment)):
        if not any(Path(path).resolve().is_relative_to(folder) for folder in package_folders().values()):
            files |= digests(Path(path))  # a file of the project's, asked for by its path, is part of its source
    with as_usage_error():
        form = forms.chosen()
    record: dict[str, Any] = {"files": files, "versions": versions(), "source": source(), "form": form}
    return {**record, "code": _code(record)}


def _declaring(experiment: object) -> Iterator[str]:
    """Yield the user's files that declare the experiment, its design's class and its claims' judges, if any do."""
    if experiment is None:
        return
    if file := getattr(experiment, "file", ""):
        yield file
    judges = [claim.judge for claim in getattr(experiment, "claims", ()) if isinstance(claim, Claim)]
    for thing in (type(getattr(experiment, "design", None)), *judges):  # of a script or of a notebook's own modules too
        while isinstance(thing, functools.partial):
            thing = thing.func
        module_name = getattr(thing, "__module__", None) or type(thing).__module__
        file = getattr(sys.modules.get(module_name), "__file__", None)
        if isinstance(file, str) and is_users(Path(file).resolve()):
            yield str(Path(file).resolve())


def _code(record: Mapping[str, Any]) -> str:
    """Return the digest of what computes, for people."""
    files = sorted((Path(path).name, digest) for path, digest in record["files"].items())
    libraries = {name: version for name, version in record["versions"].items() if name != "python"}
    text = json.dumps([record["source"]["digest"], record["form"], files, libraries], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def versions() -> dict[str, str]:
    """Return the versions of Python and of the libraries that compute the numbers; ``unknown`` where there is none."""
    return {"python": platform.python_version(), **{name: _version(name) for name in LIBRARIES}}


@functools.cache
def _version(name: str) -> str:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:  # another build of it, under another name
        return "unknown"


@functools.cache
def digest() -> str:
    """SHA-256 over names and contents of the packages' files, in sorted order; computed once a process."""
    whole = hashlib.sha256()
    for package, folder in sorted(package_folders().items()):
        for file in sorted(folder.rglob("*")):
            path = file.relative_to(folder)
            hidden = any(part.startswith(".") or part == "__pycache__" for part in path.parts)
            if not hidden and not file.name.endswith((*SHOWS, "~")) and file.is_file():
                whole.update(f"{package}/{path.as_posix()} {sha256(file)}\n".encode())
    return whole.hexdigest()


def source() -> dict[str, Any]:
    """Name the project's code: ``digest`` of its packages' files, git's ``commit``, and whether they differ from it.

    ``commit`` and ``dirty`` are ``None`` where the packages are in no git checkout, as those of an installed wheel.
    """
    return {"digest": digest(), **_checkout()}


@functools.cache
def _checkout() -> dict[str, Any]:
    folders = package_folders()
    root = folders["experiments"].parent
    # A checkout may hold an environment with the packages in it: then they are not of its commit.
    if not _git(root, "ls-files", "--", "experiments/__init__.py"):
        return {"commit": None, "dirty": None}
    commit = _git(root, "rev-parse", "HEAD")
    changes = _git(root, "status", "--porcelain", "--", *folders)
    return {"commit": (commit or "").strip() or None, "dirty": None if changes is None else bool(changes.strip())}


def _git(root: Path, *arguments: str) -> str | None:
    """Return git's output; ``None`` where it fails, or is not installed."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    # The checkout may belong to another user, which git distrusts; Python runs its code already.
    command = ["git", "-c", "safe.directory=*", "--no-optional-locks", "-C", str(root), *arguments]
    try:
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    except (OSError, subprocess.SubprocessError, ValueError):
        return None
    return done.stdout


def moved(there: Mapping[str, Any], here: Mapping[str, Any]) -> dict[str, Any]:
    """Return a run's description with each of the user's files at the place where an equal one is ``here``."""
    files, text = here.get("files", {}), json.dumps(there)
    places = {digest: path for path, digest in files.items()}
    for path, digest in there.get("files", {}).items():
        if path not in files and digest in places:
            text = text.replace(json.dumps(path), json.dumps(places[digest]))
    return dict(json.loads(text))


def differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[tuple[str, str | None, str | None]]:
    """Return name and both digests, or versions, of files and libraries that differ, or of colias-sim itself."""
    before, after = _computed_by(there), _computed_by(here)
    names = [name for name in sorted({*before, *after}) if before.get(name) != after.get(name)]
    return [(name, before.get(name), after.get(name)) for name in names]


def _computed_by(description: Mapping[str, Any]) -> dict[str, str]:
    """Return what a run's numbers depend on, by name; Python's own version is not part of it."""
    libraries = {f"the version of {name}": version for name, version in description["versions"].items()
                 if name != "python"}  # fmt: skip
    digests = {"colias-sim's own source": description["source"]["digest"], **description["files"]}
    return {**{name: digest[:12] for name, digest in digests.items()}, **libraries}


def commit(source: Mapping[str, Any]) -> str | None:
    """Return the commit of a state of the source, for people; ``None`` where it is of none."""
    name = source.get("commit")
    return f"{str(name)[:12]}{' with changes' if source.get('dirty') else ''}" if name else None
