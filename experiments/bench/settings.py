"""``--set SECTION.NAME=VALUE``: reach any parameter by its dotted name, with the legal range in every refusal."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import TypeAdapter, ValidationError

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from experiments.bench.declaration import Experiment, Settings
from experiments.bench.files import UsageError
from experiments.bench.models import Chosen, choose, family
from experiments.bench.plan import Plan, check


def sections(experiment: Experiment | None, models: Sequence[str]) -> dict[str, Any]:
    """Section name -> its default value: each model under its family's name, the apparatus, then the design.

    Models of one family (``dsnn``, ``dsnn-reference``) share a section: the first one's defaults.
    """
    table: dict[str, Any] = {}
    for name in models:
        chosen = choose(name)
        table.setdefault(family(chosen.label), chosen.network)
    table |= {"robot": RobotConfig(), "camera": CameraConfig(), "scene": SceneConfig()}
    return table if experiment is None else {**table, "experiment": experiment.design}


def configure(experiment: Experiment, models: Sequence[str], assignments: Iterable[str]) -> tuple[Experiment, Settings]:
    """Apply ``SECTION.NAME=VALUE`` texts; raises `UsageError` naming the value, its range and its origin."""
    values = sections(experiment, models)
    collected = collect(assignments, values)
    chosen = _chosen(models, collected)
    for section in ("robot", "camera", "scene", "experiment"):
        values[section] = changed(section, values[section], collected.get(section, {}))
    design = values["experiment"]
    settings = Settings(
        models=chosen,
        robot=values["robot"],
        camera=values["camera"],
        scene=values["scene"],
        pose_sd_mm=design.pose_sd_mm,
        heading_sd_deg=design.heading_sd_deg,
    )
    try:
        return dataclasses.replace(experiment, design=design), settings
    except ValueError as error:
        raise UsageError(f"--set: {error}") from None


def _chosen(models: Sequence[str], collected: Mapping[str, Mapping[str, str]]) -> tuple[Chosen, ...]:
    chosen = tuple(choose(name) for name in models)
    labels = [model.label for model in chosen]
    for label in labels:
        if labels.count(label) > 1:
            raise UsageError(f"--model {label}: given twice")
    return tuple(
        dataclasses.replace(model, network=changed(section, model.network, collected.get(section, {})))
        for model in chosen
        for section in [family(model.label)]
    )


def plan(
    experiment: Experiment, models: Sequence[str], assignments: Iterable[str], repeats: int | None, seed: int
) -> Plan:
    """A checked plan from what a person typed; `UsageError` for what cannot be run."""
    count = experiment.repeats if repeats is None else repeats
    if count < 1:
        raise UsageError(f"--repeats {count}: legal is a whole number from 1 up")
    if seed < 0:
        raise UsageError(f"--seed {seed}: legal is a whole number from 0 up")
    made = Plan(*configure(experiment, models, assignments), count, seed)
    check(made)
    return made


def collect(assignments: Iterable[str], values: Mapping[str, Any]) -> dict[str, dict[str, str]]:
    """Section -> name -> text; each key checked, the last of two values for one key counting."""
    known = [f"{section}.{field.name}" for section, value in values.items() for field in dataclasses.fields(value)]
    collected: dict[str, dict[str, str]] = {}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise UsageError(f"--set {assignment}: expected SECTION.NAME=VALUE, for example dsnn.n_con=6")
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1, cutoff=0.0)[0]
            raise UsageError(f"--set {assignment}: no parameter '{key}' (nearest: {near}; all: colias parameters)")
        section, _, name = key.partition(".")
        collected.setdefault(section, {})[name] = text
    return collected


def changed(section: str, value: Any, changes: Mapping[str, str]) -> Any:
    """``value`` with ``changes`` (name -> text) applied together and validated; `UsageError` if one is not legal."""
    if not changes:
        return value
    properties = _properties(type(value))
    parsed = {name: _split(text, properties[name]) for name, text in changes.items()}
    present = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    try:  # by the adapter, not the constructor: it checks a design that is a plain dataclass too
        return TypeAdapter(type(value)).validate_python({**present, **parsed})
    except ValidationError as error:
        problem = error.errors()[0]
        name = str(problem["loc"][0])
        legal = _legal(properties[name])
        said = problem["msg"].removeprefix("Value error, ")
        reason = f"legal is {legal}" if legal else said
        raise UsageError(f"--set {section}.{name}={changes.get(name, '')}: {reason}") from None


def _split(text: str, schema: Mapping[str, Any]) -> str | list[str]:
    """A sequence is typed with commas; pydantic turns the parts into numbers."""
    return text.split(",") if schema.get("type") == "array" else text


def _properties(cls: type) -> dict[str, dict[str, Any]]:
    schema = TypeAdapter(cls).json_schema()
    properties: dict[str, dict[str, Any]] = schema["properties"]
    return properties


def _legal(schema: Mapping[str, Any]) -> str:
    """The legal values of a field in words, from its JSON schema; empty if only a validator knows."""
    if schema.get("type") == "array":
        parts = schema.get("prefixItems") or [schema["items"]]
        count = f"{len(parts)} values" if "prefixItems" in schema else "one or more values"
        return f"{count}, separated by commas, each {_legal(parts[0])}"
    if "enum" in schema:
        return ", ".join(map(str, schema["enum"]))
    if schema.get("type") == "boolean":
        return "true or false"
    if schema.get("type") in ("number", "integer"):
        kind = "a whole number" if schema["type"] == "integer" else "a number"
        return " ".join([kind, *_bounds(schema)])
    return ""


def _bounds(schema: Mapping[str, Any]) -> Iterator[str]:
    words = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "to", "exclusiveMaximum": "below"}
    return (f"{word} {schema[bound]:g}" for bound, word in words.items() if bound in schema)


@dataclasses.dataclass(frozen=True, slots=True)
class Parameter:
    """A row of ``colias parameters``."""

    key: str
    value: str
    legal: str
    description: str


def parameters(experiment: Experiment, models: Sequence[str]) -> Iterator[Parameter]:
    """Every key that ``--set`` takes, with its present value."""
    for section, value in sections(experiment, models).items():
        properties = _properties(type(value))
        for field in dataclasses.fields(value):
            present = getattr(value, field.name)
            text = ",".join(f"{v:g}" for v in present) if isinstance(present, tuple) else str(present)
            schema = properties[field.name]
            yield Parameter(f"{section}.{field.name}", text, _legal(schema), schema.get("description", ""))
