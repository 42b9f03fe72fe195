"""``run.json``: what a run is. Written once, whole and never over another; read by every kind of run alike."""

from __future__ import annotations

import dataclasses
import datetime
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from dsnn.stimuli import StimulusEntry
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import family
from experiments.bench.stats.claim import Claim
from experiments.bench.store import commands, provenance
from experiments.bench.store.places import replacing

NAME = "run.json"
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
OF_KILLED = {".lock", "recordings", f"{NAME}.part"}
"""What a run leaves that was killed before it wrote its description."""
BEGUN = "begun"
"""The entry that says when the run was begun: ISO 8601, UTC. It is a note like `RENDERERS`."""
ENDED = "ended"
"""The entry that says when the last of its trials was done, in the same form."""
COMMAND = "command"
"""The entry with the command line or the call by which it was begun, or last gone on with: see `store.commands`."""
KIND = "kind"
"""The entry that says what kind of run it is: see `experiments.bench.store.kinds`."""
NOTED = (KIND, BEGUN, ENDED, COMMAND, RESUMED, RENDERERS, PIXELS)
"""Entries that a run adds to its parameters and to what computes it. They are compared with nothing."""
LONGEST = 300
"""Characters of a parameter's value in a comparison."""
FEW, MOST_TOLD = 60, 3
"""Characters of a value, and parameters, that a refusal to go on names."""
LABELS = "labels"
"""Where `_by_label` has the labels of models."""
NAMES = ("id", "name", "label")
"""Entries that name an object of a list, the first that it has."""
EXPERIMENT = "the experiment"
OPTIONS = {
    "repeats": "--repeats", "seed": "--seed", "recordings": "--recordings", "replicates": "--replicates",
    "claims": "--claims", "behaviours": "the behaviours",
    "env": "--env", "episodes": "--episodes", "measures": "--measure", "curves": "--curve", "pictures": "--pictures",
}  # fmt: skip
"""Entry of a description -> the option that sets it."""
CLAIMS = "claims"
"""What the description of an experiment calls its claims."""
DERIVED = ("trials", "changed", "clips", "backgrounds")
OF_REPLICATES = ("replicates", "trials", "backgrounds")
"""Entries of a study that grow where it goes on to more replicates: its trials are in the order of these."""
DERIVED_SETTINGS = (("settings", "pose_sd_mm"), ("settings", "heading_sd_deg"))
"""Entries that follow from others."""


def to_json(value: Any) -> str:
    """Indented JSON; dataclasses become objects."""
    return json.dumps(value, indent=2, default=plain) + "\n"


def begun(folder: Path) -> bool:
    """Return whether ``folder`` holds a run's description, readable or not."""
    return (folder / NAME).is_file()


def vacant(folder: Path) -> bool:
    """Return whether ``folder`` is not there, or holds nothing but what is left of a run that never began."""
    return not folder.exists() or all(path.name in OF_KILLED for path in folder.iterdir())


def check_own(folder: Path, asked: str) -> None:
    """Raise `UsageError` where a folder for a run holds other files, with which no run is to be mixed.

    Parameters
    ----------
    folder
        The folder.
    asked
        The option and its value, as ``--out runs/mine``: the message begins with it.
    """
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{asked}: is a file, not a folder")
    if vacant(folder) or begun(folder) or any(map(begun, folder.iterdir())):
        return
    raise UsageError(f"{asked}: holds other files; choose a new folder, or an empty one")


def write_new(folder: Path, description: Mapping[str, Any]) -> None:
    """Write the description, the time and the command, whole or not at all."""
    with replacing(folder / NAME) as partial:
        partial.write_text(to_json({BEGUN: now(), **command_note(), **description}), encoding="utf-8")


def now() -> str:
    """Return the time as `BEGUN` has it."""
    return datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds")


def command_note() -> dict[str, Any]:
    """Return the entry `COMMAND`; none where nobody told of a command."""
    command = commands.current()
    return {} if command is None else {COMMAND: command}


def read_description(folder: Path) -> dict[str, Any]:
    """Read the description in ``folder``; `UsageError` in one line if there is none."""
    try:
        text = (folder / NAME).read_text(encoding="utf-8")
    except (FileNotFoundError, NotADirectoryError):
        if (folder / "experiment.json").is_file():
            raise UsageError(f"{folder}: colias-sim 0.3 or earlier made this run, and reads it") from None
        raise UsageError(f"{folder}: no {NAME} there, so it is no run's folder") from None
    description: dict[str, Any] = json.loads(text)
    return description


def reconciled(folder: Path, description: Mapping[str, Any], other_code: bool) -> dict[str, Any]:
    """Return the description in ``folder``, for a run that ``description`` tells of to go on with.

    Where other code goes on, as ``other_code`` allows it to, it is among those listed, and the claims are those that
    are declared now: no row depends on them. A study may go on to more replicates than it has. Raises `UsageError` that
    names the first parameters that differ, or what computes otherwise.
    """
    there, here = read_description(folder), json.loads(to_json(description))
    if _has_more_replicates(here, there):
        there |= {name: here[name] for name in OF_REPLICATES if name in here}
    if other_code:
        there = _with_claims_of(here, there)
    differing = differences(_parameters(there), _parameters(here))
    if differing:
        more = f"; {len(differing) - MOST_TOLD} more differ" if len(differing) > MOST_TOLD else ""
        text = "; ".join(differing[:MOST_TOLD])
        advice = "repeat the first command's options, or " if "--" in text else ""
        if not differences(_parameters(_with_claims_of(here, there)), _parameters(here)):
            advice = "--other-code judges the trials that are done by the claims of now; otherwise "
        raise UsageError(f"{folder}: {text}{more}: {advice}choose another --out")
    if "source" not in here:
        return there
    others = there.setdefault(RESUMED, []) if RESUMED in there else []
    code_differences = [provenance.difference(known, here) for known in (there, *others)]
    if all(code_differences):
        if not other_code:
            raise UsageError(f"{folder}: {code_differences[0]}; --other-code goes on all the same, and marks the rows")
        there[RESUMED] = [*others, {key: here[key] for key in provenance.KEYS}]
    return there


def _has_more_replicates(here: Mapping[str, Any], there: Mapping[str, Any]) -> bool:
    now, before = here.get("replicates"), there.get("replicates")
    return isinstance(now, int) and isinstance(before, int) and now > before


def _with_claims_of(here: Mapping[str, Any], there: dict[str, Any]) -> dict[str, Any]:
    """Return ``there`` with the claims that the experiment of ``here`` declares; as it is where one has no claims."""
    now, before = here.get("experiment"), there.get("experiment")
    if isinstance(now, dict) and isinstance(before, dict) and CLAIMS in now and CLAIMS in before:
        return there | {"experiment": before | {CLAIMS: now[CLAIMS]}}
    return there


def _parameters(description: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in description.items() if name not in (*provenance.KEYS, *NOTED, THRESHOLDS)}


def differences(there: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """Return what two descriptions have otherwise, each parameter once, by the option that sets it where there is one.

    Of a run of another experiment, nothing else is told.
    """
    named: dict[str, str] = {}
    derived = []
    for path, before, now in _differing(_by_label(there), _by_label(here), ()):
        name = _option(path, here)
        text = f"{name} is {_words(before)} there and {_words(now)} now"
        if path[0] in DERIVED or path in DERIVED_SETTINGS:
            derived.append(text)
        else:
            named.setdefault(name, text)
    return [named[EXPERIMENT]] if EXPERIMENT in named else list(named.values()) or derived


def _by_label(value: Any) -> Any:
    """Lists of models as tables, so that the models of two runs are compared by their labels."""
    if isinstance(value, dict):
        return {key: _by_label(item) for key, item in value.items()}
    labels = (
        [item.get("label") if isinstance(item, dict) else None for item in value] if isinstance(value, list) else []
    )
    if not labels or not all(isinstance(label, str) for label in labels) or len(set(labels)) < len(labels):
        return value
    return {LABELS: labels, **{label: _by_label(item) for label, item in zip(labels, value, strict=True)}}


def _differing(there: Any, here: Any, path: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], Any, Any]]:
    """Path and both values of everything that differs; of two lists of models, those that both have."""
    if isinstance(there, dict) and isinstance(here, dict):
        both = [key for key in there if key in here]
        models = LABELS in both
        for key in both if models else [*there, *(key for key in here if key not in there)]:
            yield from _differing(there.get(key), here.get(key), (*path, key))
    elif isinstance(there, list) and isinstance(here, list) and len(there) == len(here) and _nested(there):
        for index, (a, b) in enumerate(zip(there, here, strict=True)):
            yield from _differing(a, b, (*path[:-1], f"{path[-1]}[{index}]"))
    elif there != here:
        yield path, there, here


def _nested(values: Sequence[Any]) -> bool:
    return any(isinstance(item, dict | list) for item in values)


def _option(path: tuple[str, ...], here: Mapping[str, Any]) -> str:
    """Return the option that sets what is at ``path``; the path itself where none does so alone."""
    name = ".".join(path)
    match path[1:] if path[0] == "settings" else path:
        case ("experiment",) | ("experiment", "name"):
            return EXPERIMENT
        case ("experiment", "design", *rest):
            return f"--set experiment.{'.'.join(rest)}"
        case ("models", label, "network", *rest):
            return f"--set {family(label.partition('@')[0])}.{'.'.join(rest)}"
        case ("models", key) if key == LABELS:
            return "--model"
        case ("robot" | "camera" | "scene" as section, *rest):
            return f"--set {section}.{'.'.join(rest)}"
        case ("axes", *axis):
            return f"--over {'.'.join(axis)}"
        case ("options", *option):
            return f"--set {'.'.join(option)}"
        case (key,) if key in OPTIONS:
            return OPTIONS[key]
    return name


def _words(value: Any) -> str:
    """Return a value in a few words: of a list its items, of objects their names."""
    if isinstance(value, list):
        names = [next((item[key] for key in NAMES if key in item), item) if isinstance(item, dict) else item
                 for item in value]  # fmt: skip
        text = ", ".join(name if isinstance(name, str) else _item(name) for name in names) or "none"
    elif isinstance(value, dict) and isinstance(value.get("name"), str):
        text = _item(value["name"])
    else:
        text = _item(value)
    return text if len(text) <= FEW else f"{text[: FEW - 3]}..."


def _item(value: Any) -> str:
    """Return a value as JSON, a whole number without a decimal point."""
    return f"{value:.0f}" if isinstance(value, float) and value.is_integer() else json.dumps(value)


def short(error: BaseException) -> str:
    """Return what an error says, in one line that fits a terminal's."""
    return " ".join(str(error).split())[:200] or type(error).__name__


def plain(value: Any) -> Any:
    """Turn what JSON does not know into what it does: dataclasses into objects, a claim into words, others to text."""
    if isinstance(value, Claim):
        return value.described()
    if isinstance(value, StimulusEntry):
        return value.name
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        # A field that makes no two values differ is no parameter; one that came later may be left out where it is not
        # set, so that what was declared before it reads as it did.
        return {
            field.name: getattr(value, field.name)
            for field in dataclasses.fields(value)
            if field.compare and (getattr(value, field.name) or not field.metadata.get("where_set"))
        }
    return str(value)
