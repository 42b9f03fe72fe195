"""``run.json``: every parameter of a run, its seed, and what computed it; one form for every kind of run."""

from __future__ import annotations

import datetime
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from experiments.base.errors import UsageError, short
from experiments.base.files import NAME, Files, to_json
from experiments.store import provenance
from experiments.store.asked import ASKED, command_note

KIND = "kind"
"""The entry with the kind of the run: ``trials``, ``clips``, ..."""
BEGUN, ENDED = "begun", "ended"
"""The entries that say when the run was begun, and when the last of its trials was done: ISO 8601, UTC."""
RENDERERS = "renderers"
"""The entry with what drew the frames (`colias_sim.gl.renderer`), each with the hashes of its reference frames
(`colias_sim.reference`), one unless machines differ. It is no parameter: a run may be resumed with another renderer, as
all that were tried drew equal pixels."""
CPUS = "cpus"
"""The entry with the features of the CPUs that computed the trials (`experiments.store.tables.cpu_features`), one
unless machines differ. It is no parameter: a run may be resumed on another CPU, whose last bits differ."""
THRESHOLDS = "thresholds"
"""The entry with each model's spiking thresholds, label -> channel -> number: readers do not run a model's file."""
NOTES = frozenset((KIND, BEGUN, ENDED, "command", ASKED, RENDERERS, CPUS, THRESHOLDS, *provenance.KEYS))
"""Entries that are not parameters."""
DERIVED = frozenset(("trials", "changed", "clips", "backgrounds"))
"""Entries that follow from others."""
OF_REPLICATES = ("replicates", "trials", "backgrounds")
"""Entries of a study that grow when it resumes with more replicates: its trials are in the order of these."""
MOST_NAMED = 3
"""Parameters that a refusal to resume names."""


def now() -> str:
    """Return the time as `BEGUN` has it."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def begun(folder: Path) -> bool:
    """Return whether ``folder`` holds a run."""
    return (folder / NAME).is_file()


def write_new(folder: Path, description: Mapping[str, Any]) -> None:
    """Write the description, the time and the command, whole or not at all."""
    Files(folder).write_json(NAME, {BEGUN: now(), **command_note(folder), **description})


def begin_whole(folder: Path, description: Mapping[str, Any]) -> None:
    """Make the folder of a run of runs, if it does not hold one of this kind yet.

    A run that resumes there is compared with its parts, not with the description.

    Raises
    ------
    UsageError
        The folder holds a run of another kind.
    """
    kind = description[KIND]
    folder.mkdir(parents=True, exist_ok=True)
    if not begun(folder):
        write_new(folder, {"experiment": kind, "versions": provenance.versions(), **description})
    elif (there := read_description(folder).get(KIND)) != kind:
        raise UsageError(f"{folder}: holds a run of kind {there}, not {kind}; choose another --out")


def read_description(folder: Path) -> dict[str, Any]:
    """Read the description in ``folder``; `UsageError` in one line if there is none."""
    if not begun(folder):
        if (folder / "experiment.json").is_file():
            raise UsageError(f"{folder}: colias-sim 0.3 or earlier made this run, and reads it")
        raise UsageError(f"{folder}: no {NAME} there, so it is no run's folder")
    try:
        description: dict[str, Any] = json.loads((folder / NAME).read_text(encoding="utf-8"))
    except ValueError as error:
        raise UsageError(f"{folder / NAME}: is not a run's description: {error}") from None
    return description


def resumed(folder: Path, description: Mapping[str, Any], *, complete: bool = False) -> dict[str, Any]:
    """Return the description in ``folder``, for a run described by ``description`` that resumes there.

    A study may resume with more replicates than it has.

    Parameters
    ----------
    folder
        Where the run is.
    description
        That of the run now.
    complete
        Whether no trial is missing. Then nothing is computed, and the run may be judged by other claims.

    Raises
    ------
    UsageError
        Parameters differ, or what computes does; the line names the first.
    """
    here = json.loads(to_json(description))
    there = provenance.moved(read_description(folder), here)
    if here.get("replicates", 0) > there.get("replicates", 0) > 0:
        there |= {name: here[name] for name in OF_REPLICATES if name in here}
    if complete and isinstance(there.get("experiment"), dict) and "claims" in there["experiment"]:
        there["experiment"] |= {"claims": here["experiment"]["claims"]}
    found = [*differences(there, here), *(provenance.differences(there, here) if "source" in here else ())]
    if differing := [f"{name} is {short(a)} there and {short(b)} now" for name, a, b in found]:
        first = "; ".join(differing[:MOST_NAMED])
        raise UsageError(f"{folder}: {first}: use the first command's options and files, or choose another --out")
    return there


def differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Return name and both values of every parameter that differs, as ``--set`` names it; `DERIVED` ones if all are so.

    Of runs of two experiments, only that is returned; of models those that both runs have.
    """
    before, after = (dict(_parameters(description, "")) for description in (there, here))
    names = [name for name in before | after if before.get(name) != after.get(name)]
    found = [(name, before.get(name), after.get(name)) for name in names]
    if before.get("experiment") != after.get("experiment"):
        return [entry for entry in found if entry[0] == "experiment"]
    alone = {name.removesuffix(".source") for name in before.keys() ^ after.keys() if name.endswith(".source")}
    found = [entry for entry in found if not entry[0].startswith(tuple(f"{label}." for label in alone))]
    return [entry for entry in found if entry[0].split(".")[0] not in DERIVED] or found


def _parameters(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield name and value of every parameter: an experiment's name, its design's fields, labels of models, theirs."""
    if isinstance(value, dict):
        for name, item in value.items():
            if not path and name in NOTES:
                continue
            if (path, name) == ("experiment", "name"):
                yield "experiment", item
            else:
                inner = name in ("settings", "design", "network")
                yield from _parameters(item, path if inner else f"{path}.{name}".lstrip("."))
    elif path == "models":
        yield path, [model["label"] if isinstance(model, dict) else model for model in value]
        for model in value if value and isinstance(value[0], dict) else ():
            label = model["label"] if len(value) > 1 else model["label"].partition(":")[0]  # a single one has its name
            yield from _parameters({name: model[name] for name in ("source", "network", "processor")}, label)
    else:
        yield path, value
