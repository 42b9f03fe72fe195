"""``--set SECTION.NAME=VALUE``: set any parameter by its dotted name; a refusal has its bounds."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from pydantic import TypeAdapter, ValidationError

from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from dsnn import MODELS
from dsnn.field_docs import meaning
from experiments.base.errors import UsageError, check_known
from experiments.base.values import assignments as assignments
from experiments.settings.models import PRESET as PRESET
from experiments.settings.models import ConfiguredModel, family, look_up, names, parse_model, presets
from experiments.settings.parameters import cell
from scenes.hints import nearest

SECTIONS = frozenset(map(family, MODELS))
"""Sections of the registered models."""


def applied(
    models: Sequence[ConfiguredModel], collected: Mapping[str, Mapping[str, str]]
) -> tuple[ConfiguredModel, ...]:
    """Return the models with the settings of their families, then with the settings of each of them."""
    configured = []
    for model in models:
        common = changed(model.section, model.network, collected.get(model.section, {}))
        typed = functools.partial("--model {}: {}={}".format, model.text)
        configured.append(
            dataclasses.replace(model, network=changed(model.section, common, parse_model(model.text)[1], typed))
        )
    return tuple(configured)


def watchers(
    models: Sequence[str],
    assignments: Iterable[str],
    others: Mapping[str, Any] = MappingProxyType({}),
    fps: float | None = None,
) -> tuple[tuple[ConfiguredModel, ...], dict[str, dict[str, str]]]:
    """Models with their off-line parameters, and what was assigned: section -> name -> text.

    ``others`` are further sections; ``fps`` is the models' frame rate where none is assigned.
    Raises `UsageError` for what is not legal.
    """
    models_shown = look_up(models, "offline")
    values = dict(others)
    for model in models_shown:
        if model.section in others:
            raise UsageError(f"--model {model.text}: that name is a section of --set; give it another")
        values.setdefault(model.section, model.network)
    collected = collect(assignments, values)
    if fps is not None:
        for section, value in values.items():
            if section not in others and hasattr(value, "fps"):
                collected[section] = {"fps": str(fps), **collected.get(section, {})}
    return applied(models_shown, collected), collected


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


def collect(assignments: Iterable[str], values: Mapping[str, Any], option: str = "--set") -> dict[str, dict[str, str]]:
    """Section -> name -> text; each key checked, the last of two values for one key counting.

    ``values`` has the sections there are, ``option`` is the option that the texts were typed after.
    """
    known = [f"{section}.{name}" for section, value in values.items() for name in names(value)]
    collected: dict[str, dict[str, str]] = {}
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        if not equals:
            raise UsageError(f"{option} {assignment}: expected SECTION.NAME=VALUE, for example dsnn.n_con=6")
        section, _, name = key.partition(".")
        if key not in known:
            if section not in values and section in SECTIONS:
                raise UsageError(f"{option} {assignment}: no model shown has '{key}': add --model {section}")
            near = nearest(key, known, after="; ")
            raise UsageError(
                f"{option} {assignment}: no parameter '{key}' ({near}sections here are {', '.join(values)}; all:"
                " colias list parameters)"
            )
        collected.setdefault(section, {})[name] = text
    return collected


def changed(
    section: str, value: Any, changes: Mapping[str, str], typed: Callable[[str, str], str] | None = None
) -> Any:
    """``value`` with ``changes`` (name -> text) applied together and validated; `UsageError` if one is out of bounds.

    A preset, where the class has some, is applied first: the other changes are made to it.
    ``typed`` is how a name and its text were typed, where that was not by ``--set``.
    """
    say = typed or (lambda name, text: f"--set {section}.{name}={text}")
    if PRESET in changes and (known := presets(value)):
        check_known(f"{say(PRESET, changes[PRESET])}: {PRESET}", changes[PRESET], known)
        value = known[changes[PRESET]]
        changes = {name: text for name, text in changes.items() if name != PRESET}
    if not changes:
        return value
    properties = _properties(value.__class__)
    parsed = {name: _split(text, properties[name]) for name, text in changes.items()}
    present = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    try:  # by the adapter, not the constructor: it checks a design that is a plain dataclass too
        return TypeAdapter(type(value)).validate_python({**present, **parsed})
    except ValidationError as error:
        problem = error.errors()[0]
        name = str(problem["loc"][0]) if problem["loc"] else ""
        reason = problem["msg"].removeprefix("Value error, ")
        schema, given = properties.get(name, {}), changes.get(name, "")
        if problem["loc"][1:] and schema.get("type") == "array" and problem["type"] != "missing":  # one of several
            schema, given = (schema.get("prefixItems") or [schema["items"]])[0], problem["input"]
        if problem["type"] != "value_error" and (legal := _legal(schema)):
            reason = f"{name} must be {legal}, got {given}"
        where = [say(name, changes.get(name, ""))] if name else [say(*change) for change in changes.items()]
        raise UsageError(f"{', '.join(where)}: {' '.join(reason.split())}") from None


def _split(text: str, schema: Mapping[str, Any]) -> Any:
    """Parse a sequence typed with commas, or None where that is legal.

    Pydantic makes numbers of texts, but not one of listed numbers.
    """
    if text == "None" and "anyOf" in schema:
        return None
    if schema.get("type") == "array":
        return text.split(",")
    return next((value for value in schema.get("enum", ()) if str(value) == text), text)


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


@dataclass(frozen=True, slots=True)
class Settings:
    """Settings of the trials of a run. Every model of ``models`` sees the same frames."""

    models: tuple[ConfiguredModel, ...]
    robot: RobotConfig
    camera: CameraConfig
    scene: SceneConfig
    pose_sd_mm: float
    heading_sd_deg: float
