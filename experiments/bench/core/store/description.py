"""``experiment.json``: what a run is. Written once, whole and never over another; read by every kind of run alike."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from dsnn import CHANNELS
from experiments.bench.core.errors import UsageError
from experiments.bench.core.models import rebuilt
from experiments.bench.core.store import provenance
from experiments.bench.core.store.places import fresh, naming
from experiments.bench.core.user_code import is_file
from experiments.bench.core.verdict import Claim

NAME = "experiment.json"
RESUMED = "resumed_with"
"""The entry that lists what computed the run after `--other-code` let it go on with something else."""
RENDERERS = "renderers"
"""The entry that lists what drew the frames, as `colias_sim.gl.renderer` says it in the processes that did.

It is known when the first trial is over. It is a note: it is no part of the rows' mark, and a run may be gone on with
by another renderer, as all that were tried drew equal pixels.
"""
PIXELS = "reference_frames"
"""The entry that lists the hashes of the reference frame (`colias_sim.reference`) where the frames were drawn.

It is a note like `RENDERERS`. A second hash means that the machines' pixels differ, and a command says so.
"""
THRESHOLDS = "thresholds"
"""The entry with the channels that each model declares, and their spiking thresholds: label -> channel -> number.

It is there for those who read the folder, who do not run the file that declares a model. It is no parameter of the run:
it follows from the model's own, and from its file, whose digest is noted.
"""
OWN_FILES = ("trials.parquet", "frames.parquet", "failures.json")
NOTED = (RESUMED, RENDERERS, PIXELS)
"""Entries that a run adds to what it began with."""
LONGEST = 300
"""Characters of a difference in a message."""


def to_json(value: Any) -> str:
    """Indented JSON; dataclasses become objects."""
    return json.dumps(value, indent=2, default=plain) + "\n"


def begun(folder: Path) -> bool:
    """Whether ``folder`` holds a run's description, readable or not."""
    return os.path.lexists(folder / NAME)


def vacant(folder: Path) -> bool:
    """Whether all that ``folder`` holds, if it is there, is what a run that never began leaves."""
    if not folder.exists():
        return True
    recordings = folder / "recordings"
    left = [path for path in folder.iterdir() if path.name != ".lock" and path.suffix != ".part" and path != recordings]
    return not left and not _recorded(recordings)


def holds_results(folder: Path) -> bool:
    """Whether ``folder`` holds tables or recordings of a run, whatever it was."""
    return any(os.path.lexists(folder / name) for name in OWN_FILES) or _recorded(folder / "recordings")


def _recorded(recordings: Path) -> bool:
    return recordings.is_dir() and any(path.suffix != ".part" for path in recordings.iterdir())


def write_new(folder: Path, description: Mapping[str, Any]) -> None:
    """Write the description, whole or not at all; ``FileExistsError`` if there is one, also of a run begun just now."""
    partial = fresh(folder / f"{NAME}.{os.getpid()}.part")
    try:
        with naming(folder / NAME):
            partial.write_text(to_json(description), encoding="utf-8")
            with partial.open("rb") as file:
                os.fsync(file.fileno())
        try:
            os.link(partial, folder / NAME)  # never over another, as renaming would
        except FileExistsError:
            raise
        except (OSError, AttributeError, NotImplementedError):  # a file system without links
            if begun(folder):
                raise FileExistsError(folder / NAME) from None
            partial.rename(folder / NAME)
    finally:
        with contextlib.suppress(OSError):
            partial.unlink(missing_ok=True)


def read_description(folder: Path) -> dict[str, Any]:
    """The description in ``folder``; `UsageError` in one line that names the file where there is none, or no whole."""
    try:
        value = json.loads((folder / NAME).read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"{folder}: no readable {NAME} there ({error.strerror})") from None
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{folder}: {NAME} cannot be read ({short(error)})") from None
    if not isinstance(value, dict):
        raise UsageError(f"{folder}: {NAME} cannot be read (it holds a {type(value).__name__}, expected an object)")
    return value


def reconciled(folder: Path, description: Mapping[str, Any], other_code: bool) -> dict[str, Any]:
    """The description in ``folder``, for a run that ``description`` tells of to go on with.

    Where other code goes on, as ``other_code`` allows it to, it is among those listed. Raises `UsageError` that
    names the first parameter that differs, or what computes otherwise.
    """
    there, here = read_description(folder), json.loads(to_json(description))
    try:
        differs = difference(_parameters(there), _parameters(here))
    except RecursionError:
        raise UsageError(f"{folder}: {NAME} cannot be read (nested too deeply)") from None
    if differs:
        raise UsageError(f"{folder}: {differs}")
    try:
        for entry in (RENDERERS, PIXELS):
            noted(there, entry)
    except ValueError as error:
        raise UsageError(f"{folder}: {NAME} cannot be read ({error})") from None
    if "source" not in here:
        return there
    others = there.setdefault(RESUMED, []) if RESUMED in there else []
    if not isinstance(others, list) or not all(isinstance(other, dict) for other in others):
        raise UsageError(f"{folder}: {NAME} cannot be read ({RESUMED} should be a list of objects)")
    said = [provenance.difference(known, here) for known in (there, *others)]
    if all(said):
        if not other_code:
            raise UsageError(f"{folder}: {said[0]}; --other-code goes on all the same, and marks the rows")
        there[RESUMED] = [*others, {key: here[key] for key in provenance.KEYS}]
    return there


def _parameters(description: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in description.items() if name not in (*provenance.KEYS, *NOTED, THRESHOLDS)}


def stored_thresholds(description: Mapping[str, Any], model: Mapping[str, Any]) -> dict[str, float | None] | None:
    """Find the channels that a model of a stored run declares, and their spiking thresholds. No file is run for it.

    Parameters
    ----------
    description
        The run's ``experiment.json``.
    model
        The model's entry there: ``label``, ``source`` and ``network``.

    Returns
    -------
    dict of str to float or None, or None
        As `ConfiguredModel.thresholds`. ``None`` where nothing tells: a run of an older version stored none, and its
        model is no registered one.
    """
    stored = description.get(THRESHOLDS)
    own = stored.get(model["label"]) if isinstance(stored, Mapping) else None
    if isinstance(own, Mapping):
        return {
            channel: float(own[channel]) if isinstance(own[channel], int | float) else None
            for channel in CHANNELS if channel in own
        }  # fmt: skip
    source = model["source"]
    if not isinstance(source, str) or is_file(source):
        return None
    try:
        return rebuilt(model["label"], source, model["network"]).thresholds
    except (UsageError, ValueError, TypeError):
        return None


def noted(description: Mapping[str, Any], entry: str) -> list[str]:
    """Return what an entry of `NOTED` lists so far. Raises ``ValueError`` where it is no list of texts."""
    listed = description.get(entry, [])
    if not isinstance(listed, list) or not all(isinstance(each, str) for each in listed):
        raise ValueError(f"{entry} should be a list of texts")
    return listed


def codes(description: Mapping[str, Any]) -> frozenset[str]:
    """The marks that rows of a run may have: of the code it was begun with, and of others that went on with it."""
    return frozenset(
        code for each in (description, *description.get(RESUMED, ())) if isinstance(code := each.get("code", ""), str)
    )


def difference(there: Any, here: Any, path: str = "") -> str:
    """The first parameter in which two descriptions differ, in words; empty if none does."""
    return next(_differences(there, here, path), "")


def _differences(there: Any, here: Any, path: str) -> Iterator[str]:
    if isinstance(there, dict) and isinstance(here, dict):
        for key in [*there, *(key for key in here if key not in there)]:
            yield from _differences(there.get(key), here.get(key), f"{path}.{key}".lstrip("."))
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here):
        for index, (a, b) in enumerate(zip(there, here, strict=True)):
            yield from _differences(a, b, f"{path}[{index}]")
    elif there != here:
        yield f"{path} is {_shown(there)} there and {_shown(here)} now"


def _shown(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}..."


def short(error: BaseException) -> str:
    """What an error says, in one line that fits a terminal's."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def plain(value: Any) -> Any:
    """What JSON does not know: dataclasses become objects, anything else text; of a claim its words, not its judge."""
    if isinstance(value, Claim):
        return value.described()
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        # A field that makes no two values differ is no parameter.
        return {field.name: getattr(value, field.name) for field in dataclasses.fields(value) if field.compare}
    return str(value)
