"""Make parameter classes: frozen, validated dataclasses whose fields have units and appear in `help`."""

from __future__ import annotations

import dataclasses
import inspect
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, dataclass_transform, get_args, get_origin

from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass
from pydantic.fields import FieldInfo

Class = TypeVar("Class", bound=type[Any])
_RAISES = (
    "", "Raises", "------", "pydantic.ValidationError",
    "    A value is not legal. It is a ``ValueError`` that names field, value and bound.",
)  # fmt: skip
_BOUNDS = (("ge", "[{:g}"), ("gt", "({:g}")), (("le", "{:g}]"), ("lt", "{:g})"))


@dataclass_transform(frozen_default=True, field_specifiers=(Field,))
def parameters(cls: Class) -> Class:
    """Turn a class into a frozen pydantic dataclass that refuses unknown fields, infinities and NaN.

    Parameters
    ----------
    cls
        The class. The string below a field is its documentation.

    Returns
    -------
    type
        The same class, its fields listed in its docstring (`with_field_docs`).
    """
    config = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True)
    made: Class = dataclass(frozen=True, config=config)(cls)  # type: ignore[assignment]
    return with_field_docs(made)


def unit(name: str) -> Any:
    """Declare the unit of a parameter: ``tau: Annotated[float, unit("ms")]``.

    Parameters
    ----------
    name
        The unit, or the name of the parameter that holds it.

    Returns
    -------
    pydantic.fields.FieldInfo
        Metadata of the annotation. Lists and tables read the unit from the field's JSON schema.
    """
    return Field(json_schema_extra={"unit": name})


Milliseconds = Annotated[float, Field(ge=0.0, le=10_000.0), unit("ms")]
"""A time constant."""


def meaning(cls: type[Any], name: str) -> str:
    """Return a field's documentation in one line: the string below it, or its ``description``.

    It searches the base classes too, because pydantic documents only the fields that a class declares itself.
    """
    infos = (vars(base).get("__pydantic_fields__", {}).get(name) for base in cls.__mro__)
    text = next((info.description for info in infos if info is not None and info.description), "")
    return " ".join(text.split()).rstrip(".")


def kind(info: FieldInfo) -> str:
    """Describe type and range of a field, such as ``float in [0, 1)``."""
    legal = _range(info.metadata) or _range_within(info.annotation)
    return f"{_type(info.annotation)}{f' in {legal}' if legal else ''}"


def with_field_docs(cls: Class) -> Class:
    """Append a numpydoc section ``Parameters`` to the docstring of a pydantic dataclass.

    Parameters
    ----------
    cls
        The class. Each field has a ``description``, or is documented by the string below it.

    Returns
    -------
    type
        The same class. The section lists type, range, default, description and unit of each field, inherited ones too.
        A section ``Raises`` follows it.
    """
    fields: dict[str, FieldInfo] = cls.__pydantic_fields__
    lines = [inspect.cleandoc(cls.__doc__ or ""), "", "Parameters", "----------"]
    for field in dataclasses.fields(cls):
        info = fields[field.name]
        default = "required" if info.is_required() else f"default {info.default!r}"
        lines += [f"{field.name} : {kind(info)}, {default}", f"    {_sentence(meaning(cls, field.name))}{_unit(info)}"]
    cls.__doc__ = "\n".join([*lines, *_RAISES]) + "\n"
    return cls


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def _unit(info: FieldInfo) -> str:
    """Return the unit of a field, or of a tuple's entries, as a sentence; empty without a unit."""
    entries = [part.__metadata__ for part in get_args(info.annotation) if get_origin(part) is Annotated]
    for field in (info, *(item for metadata in entries for item in metadata)):
        extra = getattr(field, "json_schema_extra", None)
        if isinstance(extra, dict) and "unit" in extra:
            return f" Unit: {extra['unit']}."
    return ""


def _type(annotation: Any) -> str:
    """Return a type as numpydoc writes it."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return _type(parts[0])
    if origin is Literal:
        return "{" + ", ".join(map(repr, parts)) + "}"
    if annotation is Ellipsis:
        return "..."
    if origin in (Union, UnionType):
        return " or ".join(map(_type, parts))
    if origin is not None:
        return f"{origin.__name__}[{', '.join(map(_type, parts))}]"
    return "None" if annotation is NoneType else str(getattr(annotation, "__name__", annotation))


def _range(metadata: Any) -> str:
    """Return an interval such as ``[0, 1)``; empty if it is unbounded."""
    ends = [
        next((form.format(getattr(m, sign)) for m in metadata for sign, form in side if _has(m, sign)), "")
        for side in _BOUNDS
    ]
    return ", ".join(ends) if all(ends) else ""


def _has(constraint: Any, sign: str) -> bool:
    return getattr(constraint, sign, None) is not None


def _range_within(annotation: Any) -> str:
    """Return the interval of a tuple's entries, if all share it."""
    ranges = {
        _range([n for m in part.__metadata__ for n in (m, *getattr(m, "metadata", ()))])
        for part in get_args(annotation)
        if get_origin(part) is Annotated
    }
    return ranges.pop() if len(ranges) == 1 else ""
