"""Parameters by their keys, ``SECTION.NAME``: set any of models, robot, camera, scene, design; refusals have bounds."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pydantic import TypeAdapter, ValidationError

from colias_sim.config import CameraConfig, EventConfig, ProcessorConfig, RobotConfig, SceneConfig, known_arena
from dsnn import MODELS
from dsnn.field_docs import meaning
from experiments.base.errors import UsageError, as_usage_error, check_known
from experiments.base.values import by_key
from experiments.declare.experiment import Design, Experiment
from experiments.settings.models import PRESET, ConfiguredModel, family, look_up, names, parse_model, presets
from experiments.settings.parameters import Parameters, cell, differing
from experiments.settings.pictures import Pictures
from scenes.hints import nearest

SECTIONS = frozenset(map(family, MODELS))
"""Sections of the registered models."""
FILES = ("scene.arena", "scene.wall", "scene.shell_picture")
"""Parameters that may be paths: tables and titles have the names of the files, as these may be moved."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of the trials of a run. Every model of ``models`` sees the same frames."""

    models: tuple[ConfiguredModel, ...]
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float
    events: EventConfig = dataclasses.field(default_factory=EventConfig)


# Of trials with the robot, and of models alone.


def configure(experiment: Experiment, models: Sequence[str], values: Mapping[str, Any]) -> tuple[Experiment, Settings]:
    """Set parameters by key, over those of the experiment; a `UsageError` names the value, its range and its origin."""
    usual = sections(experiment, models)
    given = by_section({**by_key(experiment.settings), **values}, usual)
    robot, camera, scene, events, processor, design = (
        with_values(section, usual[section], given.get(section, {}))
        for section in ("robot", "camera", "scene", "events", "processor", "experiment")
    )
    if lacking := [name for name in ("pose_sd_mm", "heading_sd_deg") if not hasattr(design, name)]:
        where = f"{experiment.file or experiment.name}: the design {type(design).__name__}"
        raise UsageError(f"{where} must have {' and '.join(lacking)}, spreads of the start from 0 to 100")
    shown = tuple(dataclasses.replace(model, processor=processor) for model in applied(look_up(models), given))
    settings = Settings(shown, robot, camera, scene, design.pose_sd_mm, design.heading_sd_deg, events)
    with as_usage_error("--set: "):
        return dataclasses.replace(experiment, design=design), settings


def sections(experiment: Experiment | None, models: Sequence[str]) -> dict[str, Any]:
    """Section name -> its default value: each model under its family's name, the apparatus, then the design.

    Models of one family with the same parameters (``dsnn``, ``dsnn-reference``) share a section: the first one's
    defaults.
    """
    models_shown = look_up(models)
    applied(models_shown, {})  # what is asked of them has to be legal too
    table: dict[str, Any] = {}
    for model in models_shown:
        table.setdefault(model.section, model.network)
    table |= {**_apparatus(usual_scene(experiment)), "processor": ProcessorConfig()}
    return table if experiment is None else {**table, "experiment": experiment.design}


def _apparatus(scene: SceneConfig) -> dict[str, Any]:
    return {"robot": RobotConfig(), "camera": CameraConfig(), "scene": scene, "events": EventConfig()}


def usual_scene(experiment: Experiment | None) -> SceneConfig:
    """Return the scene that trials have where ``--set`` says nothing: the default one, in the experiment's arena.

    Raises
    ------
    UsageError
        The experiment's arena is unknown.
    """
    if experiment is None or not experiment.arena:
        return SceneConfig()
    with as_usage_error(f"experiment {experiment.name}: "):
        return SceneConfig(arena=known_arena(experiment.arena))


def changes(
    experiment: Experiment, settings: Settings, declared: Design, pictures: Pictures | None = None
) -> Parameters:
    """Return the parameters that are not at their defaults, by key and model; files by their names alone.

    The wall of ``pictures`` is no parameter.
    """
    usual = dataclasses.replace(usual_scene(experiment), wall=settings.scene.wall if pictures else "")
    others = {name: (default, getattr(settings, name)) for name, default in _apparatus(usual).items()}
    others["experiment"] = (declared, experiment.design)
    return {
        key: {label: Path(text).name for label, text in values.items()} if key in FILES else values
        for key, values in differing(settings.models, others=others).items()
    }


def applied(models: Sequence[ConfiguredModel], given: Mapping[str, Mapping[str, Any]]) -> tuple[ConfiguredModel, ...]:
    """Return the models with the settings of their families, then with the settings of each of them."""
    configured = []
    for model in models:
        common = with_values(model.section, model.network, given.get(model.section, {}))
        typed = functools.partial("--model {}: {}={}".format, model.text)
        network = with_values(model.section, common, parse_model(model.text)[1], typed)
        configured.append(dataclasses.replace(model, network=network))
    return tuple(configured)


def watchers(
    models: Sequence[str],
    values: Mapping[str, Any] = MappingProxyType({}),
    others: Mapping[str, Any] = MappingProxyType({}),
    fps: float | None = None,
) -> tuple[ConfiguredModel, ...]:
    """Return models with their off-line parameters, and with ``values`` by key.

    ``others`` are further sections; ``fps`` is the models' frame rate where none is set.
    Raises `UsageError` for what is not legal.
    """
    shown = look_up(models, "offline")
    usual = dict(others)
    for model in shown:
        if model.section in others:
            raise UsageError(f"--model {model.text}: that name is a section of --set; give it another")
        usual.setdefault(model.section, model.network)
    given = by_section(values, usual)
    if fps is not None:
        for section in {model.section for model in shown if hasattr(model.network, "fps")}:
            given[section] = {"fps": fps, **given.get(section, {})}
    return applied(shown, given)


def events_of(values: Mapping[str, Any]) -> EventConfig:
    """Return the settings of an event camera, with those of ``values`` by key that are its own."""
    own = {key: value for key, value in values.items() if key.startswith("events.")}
    config: EventConfig = in_sections(own, {"events": EventConfig()})["events"]
    return config


MOST_REPEATS = 10_000
"""Repeats of one run. More would take days, and their plan more memory than most machines have."""
MOST_SEED = 4 * 10**18
"""Seeds stand in tables as 64-bit integers, and so do the seeds that a run counts up from its own."""


def check_counts(seed: int, repeats: int = 1, option: str = "--repeats") -> None:
    """Raise `UsageError` for a seed or a number of repeats, typed as ``option``, that no run can have."""
    if not 1 <= repeats <= MOST_REPEATS:
        raise UsageError(f"{option} must be between 1 and {MOST_REPEATS}, got {repeats}")
    if not 0 <= seed <= MOST_SEED:
        raise UsageError(f"--seed must be between 0 and {MOST_SEED}, got {seed}")


# Of any section: the one place that knows keys, and the one that checks values.


def by_section(
    values: Mapping[str, Any], sections: Mapping[str, Any], option: str = "--set"
) -> dict[str, dict[str, Any]]:
    """Return section -> name -> value; each key checked.

    ``sections`` has those that there are, ``option`` is the option that the values were typed after.
    """
    keys = [f"{section}.{name}" for section, present in sections.items() for name in names(present)]
    found: dict[str, dict[str, Any]] = {}
    for key, value in values.items():
        section, _, name = key.partition(".")
        if key not in keys:
            where = f"{option} {key}={cell(value)}"
            if section not in sections and section in SECTIONS:
                raise UsageError(f"{where}: no model shown has '{key}': add --model {section}")
            near = nearest(key, keys, after="; ")
            raise UsageError(
                f"{where}: no parameter '{key}' ({near}sections here are {', '.join(sections)}; all:"
                " colias list parameters)"
            )
        found.setdefault(section, {})[name] = value
    return found


def in_sections(values: Mapping[str, Any], sections: Mapping[str, Any]) -> dict[str, Any]:
    """Return sections with ``values`` by key; `UsageError` for an unknown key and a value out of bounds."""
    given = by_section(values, sections)
    return {section: with_values(section, present, given.get(section, {})) for section, present in sections.items()}


def with_values(
    section: str, present: Any, values: Mapping[str, Any], typed: Callable[[str, Any], str] | None = None
) -> Any:
    """Return parameters with ``values`` by name, set together and validated; `UsageError` if one is out of bounds.

    A preset, where the class has some, is applied first: the other values are set in it.
    ``typed`` is how a name and its value were typed, where that was not by ``--set``.
    """
    say = typed or (lambda name, value: f"--set {section}.{name}={cell(value)}")
    if PRESET in values and (named := presets(present)):
        check_known(f"{say(PRESET, values[PRESET])}: {PRESET}", values[PRESET], named)
        present = named[values[PRESET]]
        values = {name: value for name, value in values.items() if name != PRESET}
    if not values:
        return present
    properties = _properties(present.__class__)
    parsed = {name: _parsed(value, properties[name]) for name, value in values.items()}
    usual = {field.name: getattr(present, field.name) for field in dataclasses.fields(present)}
    try:  # by the adapter, not the constructor: it checks a design that is a plain dataclass too
        return TypeAdapter(type(present)).validate_python({**usual, **parsed})
    except ValidationError as error:
        problem = error.errors()[0]
        name = str(problem["loc"][0]) if problem["loc"] else ""
        reason = problem["msg"].removeprefix("Value error, ")
        schema, given = properties.get(name, {}), values.get(name, "")
        if problem["loc"][1:] and schema.get("type") == "array" and problem["type"] != "missing":  # one of several
            schema, given = (schema.get("prefixItems") or [schema["items"]])[0], problem["input"]
        if problem["type"] != "value_error" and (legal := _legal(schema)):
            reason = f"{name} must be {legal}, got {cell(given)}"
        where = [say(name, values.get(name, ""))] if name else [say(*pair) for pair in values.items()]
        raise UsageError(f"{', '.join(where)}: {' '.join(reason.split())}") from None


def _parsed(value: Any, schema: Mapping[str, Any]) -> Any:
    """Parse a sequence typed with commas, or None where that is legal.

    Pydantic makes numbers of the parts, but not one of listed numbers.
    """
    if value == "None" and "anyOf" in schema:
        return None
    if schema.get("type") == "array":
        return value.split(",") if isinstance(value, str) else [value] if isinstance(value, int | float) else value
    return next((listed for listed in schema.get("enum", ()) if str(listed) == value), value)


@functools.cache
def _properties(cls: Any) -> dict[str, dict[str, Any]]:
    """Return the schema of each field, of an optional one with that of its value.

    Pydantic takes its time to make it, and plans ask a hundred times.
    """
    properties = TypeAdapter(cls).json_schema()["properties"]
    return {name: {**schema, **schema.get("anyOf", [{}])[0]} for name, schema in properties.items()}


def _legal(schema: Mapping[str, Any]) -> str:
    """Return the values that a field may have, as text, from its JSON schema; empty if only a validator knows."""
    if schema.get("type") == "array":
        parts = schema.get("prefixItems") or [schema["items"]]
        number = len(parts) if "prefixItems" in schema else schema.get("minItems", 0)
        exact = number > 0 and number == schema.get("maxItems")
        count, each = f"{number} values" if exact else "one or more values", _legal(parts[0])
        return f"{count}, separated by commas{each and f', each {each}'}"
    if "enum" in schema:
        return f"one of {', '.join(map(str, schema['enum']))}"
    if schema.get("type") == "boolean":
        return "true or false"
    if schema.get("type") in ("number", "integer"):
        bounds = " and ".join(_bounds(schema))
        whole = "a whole number" if schema["type"] == "integer" else "" if bounds else "a number"
        return f"{whole} {bounds}".strip()
    return ""


def schema_of(value: Any, name: str) -> Mapping[str, Any]:
    """Return the JSON schema of a parameter: its type, its bounds and its unit.

    Parameters
    ----------
    value
        A section of ``--set``: an instance of the parameters' dataclass.
    name
        The parameter's name in that section; of `PRESET` the schema lists the presets.

    Returns
    -------
    mapping
        As pydantic makes it; of an optional value, the schema of the value.
    """
    if name == PRESET:
        return {"enum": list(presets(value))}
    return _properties(value.__class__)[name]


def _unit(schema: Mapping[str, Any]) -> str:
    """Return the unit of a field, or of each entry of a sequence, from its JSON schema."""
    parts = [schema, *schema.get("prefixItems", ())[:1], *([schema["items"]] if "items" in schema else [])]
    return next((part["unit"] for part in parts if "unit" in part), "")


def _bounds(schema: Mapping[str, Any]) -> Iterator[str]:
    if "minimum" in schema and "maximum" in schema:
        return iter([f"between {schema['minimum']:.12g} and {schema['maximum']:.12g}"])
    words = {"minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below"}
    return (f"{word} {schema[bound]:.12g}" for bound, word in words.items() if bound in schema)


def described(values: Mapping[str, Any]) -> Iterator[dict[str, str]]:
    """Yield every parameter that ``--set`` reaches, a row of ``colias list parameters``.

    Parameters
    ----------
    values
        The sections: name -> an instance of the parameters' dataclass.

    Yields
    ------
    dict of str to str
        ``key``, section and name as they are typed; ``value``, the present one; ``legal``, the values that it may have
        (empty where only a validator knows them); ``unit``; ``description``.
    """
    for section, value in values.items():
        if presets(value):
            words = f"named set of values for several parameters of {section}; a parameter that is set too wins"
            summaries = value.preset_summaries() if hasattr(value, "preset_summaries") else {}
            words += "".join(f"; {name}: {summary}" for name, summary in summaries.items())
            now = next((name for name, preset in presets(value).items() if preset == value), "")
            legal = ", ".join(presets(value))
            yield {"key": f"{section}.{PRESET}", "value": now, "legal": legal, "unit": "", "description": words}
        properties = _properties(value.__class__)
        for field in dataclasses.fields(value):
            present = getattr(value, field.name)
            schema, text = properties[field.name], str(cell(present))
            words = meaning(type(value), field.name) or schema.get("description", "")
            yield {"key": f"{section}.{field.name}", "value": text, "legal": _legal(schema), "unit": _unit(schema),
                   "description": words}  # fmt: skip
