"""Save and restore what a model or a simulator keeps from frame to frame, as one value of bytes.

A state has a header (what it is of, and a digest of its configuration), a tree of plain values as JSON, and the bytes
of its arrays. Nothing in it is executed. `PARTS` says for each class which attributes are its state.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import lru_cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

Parts = Mapping[str, str]
"""Class -> the names of the attributes that are its state, besides those of its bases."""
Kind = tuple[str, str]
"""What a state is of, for messages; and its configuration as a text, which must be equal."""
Kinds = tuple[type, ...]
Tree = dict[str, object]

PARTS: Parts = {
    "dsnn.model.Model": "_scale_known",
    "dsnn.direction.network.DSNN": "_network",
    "dsnn.direction.network.ReferenceDSNN": "",
    "dsnn.direction.reference.ReferenceNetwork": "_luminance _residues _on _off",
    "dsnn.direction.reference.Pathway": "la f _adaptation _delays lp_hs lp_vs",
    "dsnn.direction.emd.EMD": "_retina _states _means",
    "dsnn.direction.emd_normalised.EMDNormalised": "_retina _states",
    "dsnn.direction.flow.Flow": "_before _now _first",
    "dsnn.direction.t4t5.T4T5": "_local",
    "dsnn.direction.local_motion.LocalMotion": "_retina _states",
    "dsnn.direction.three_arm.ThreeArm": "_retina _states",
    "dsnn.filters.Retina": "_before _first",
    "dsnn.filters.States": "_arrays frames",
    "dsnn.hybrid.Hybrid": "_dsnn _lgmd _held",
    "dsnn.looming.layers.Detector": "_count",
    "dsnn.looming.layers.Adaptation": "_k _adapted",
    "dsnn.looming.lgmd1.LGMD1": "_layers",
    "dsnn.looming.lgmd1._NumpyLayers": "_retina _inhibition _change",
    "dsnn.looming.lgmd2.LGMD2": "_retina _on _off _adaptation _pm",
    "dsnn.looming.lgmd2.Pathway": "_states",
    "dsnn.looming.lplc2.LPLC2": "_retina _states _contrast _outputs",
    "dsnn.looming.lplc2_gf.LPLC2GF": "_retina _states _share_before _v",
    "dsnn.looming.mlplc2.MLPLC2": "_local _outputs",
    "dsnn.looming.pon_lgmd.PONLGMD": "_retina _motion_before",
    "dsnn.looming.si_lgmd1.SILGMD1": "_retina _delayed _mean_before",
    "dsnn.looming.si_lgmd2.SILGMD2": "_retina _on _off _adaptation _mean_before",
    "dsnn.looming.si_lgmd2._Pathway": "_now _before",
    "dsnn.onboard.model.OnboardDSNN": "_stages",
    "dsnn.small_target.layers.Gamma": "stages",
    "dsnn.small_target.layers.SmallTargetModel": "_fast _slow _states",
    "dsnn.small_target.estmd.ESTMD": "",
    "dsnn.small_target.dstmd.DSTMD": "",
    "dsnn.onboard.numpy_form.NumpyOnboard": "_luma _changes _la _h _codes _sums",
}
"""The models and their layers. Networks in C bring ``get_state`` and ``set_state``."""

MAGIC, VERSION = b"colias-state", 1
_HEAD = struct.Struct("<HQQQQ")
"""Format; checksum of JSON and arrays; length of the JSON, of both, and of everything. The states of parts follow,
which have checksums of their own."""
_JSON: Kinds = (type(None), bool, int, float, str)
_PLAIN: Kinds = (*_JSON, bytes, np.ndarray, np.generic, np.random.Generator)


def attributes(part: object, parts: Parts) -> list[str] | None:
    """List the attributes that are the state of an object.

    Parameters
    ----------
    part
        The object.
    parts
        The table.

    Returns
    -------
    list of str or None
        The names, those of its bases first. ``None`` if the table does not have its class, which may keep more than its
        bases do, and the class has no ``get_state`` of its own.
    """
    kinds = type(part).__mro__
    rows = [parts.get(f"{kind.__module__}.{kind.__qualname__}") for kind in kinds]
    if rows[0] is None and (not any(rows) or "get_state" not in vars(kinds[0])):
        return None
    return list(dict.fromkeys(" ".join(filter(None, reversed(rows))).split()))


def take(part: object, parts: Parts, values: Kinds = ()) -> Tree:
    """Copy the state of an object.

    Parameters
    ----------
    part
        The object.
    parts
        The table.
    values
        Dataclasses that are values.

    Returns
    -------
    dict
        Attribute -> its value, or the tree of a part. A random generator that was met before is left out.

    Raises
    ------
    ValueError
        The object or an attribute is neither a value nor of a class in the table, and has no ``get_state``.
    """
    tree: Tree = _taken(part, type(part).__name__, parts, (*_PLAIN, *values), [], whole=True)
    return tree


def _taken(value: Any, where: str, parts: Parts, plain: Kinds, met: list[Any], *, whole: bool = False) -> Any:
    def inner(one: Any, name: object = "") -> Any:
        return _taken(one, f"{where}{name}", parts, plain, met)

    if isinstance(value, plain):
        met += [value] if isinstance(value, np.random.Generator) else []
        return value
    if type(value) is dict:
        return {name: inner(one, [name]) for name, one in value.items()}
    if type(value) is deque:
        return deque(map(inner, value), value.maxlen)
    if type(value) in (list, tuple):
        return type(value)(map(inner, value))
    if (names := attributes(value, parts)) is not None:
        there = {name: getattr(value, name) for name in names if hasattr(value, name)}
        return {name: inner(one, f".{name}") for name, one in there.items() if not any(one is other for other in met)}
    if hasattr(value, "get_state") and not whole:
        return value.get_state()
    raise ValueError(f"{where} ({type(value).__name__}) cannot be saved: give it get_state() and set_state(state)")


def put(part: object, tree: Mapping[str, Any], parts: Parts) -> None:
    """Give an object the state of `take`. Arrays that it shares with others stay the same objects.

    Parameters
    ----------
    part
        An object with the configuration of the one that was saved.
    tree
        Its state.
    parts
        The table.
    """
    for name, value in tree.items():
        if not _filled(getattr(part, name, None), value, parts):
            setattr(part, name, value)


def _filled(current: Any, value: Any, parts: Parts) -> bool:
    """Put a value into an object that is there already; false where it has to be replaced."""
    match current, value:
        case np.ndarray(flags=flags), np.ndarray() if flags.writeable and current.shape == value.shape:
            if same := current.dtype == value.dtype:
                current[...] = value
            return bool(same)
        case (list() | tuple(), list() | tuple()) if len(current) == len(value) > 0:
            return all(_filled(one, other, parts) for one, other in zip(current, value, strict=True))
        case (dict(), dict()) if current.keys() == value.keys() and value:
            return _filled([current[name] for name in value], [*value.values()], parts)
        case _, dict() if attributes(current, parts) is not None:
            put(current, value, parts)
            return True
    if own := hasattr(current, "set_state"):
        current.set_state(value)
    return own


def pack(kind: Kind, tree: Tree) -> bytes:
    """Write a tree as bytes.

    Parameters
    ----------
    kind
        What it is the state of.
    tree
        Its state, from `take`.

    Returns
    -------
    bytes
        The state.
    """
    arrays: list[memoryview] = []
    states: list[bytes] = []
    body = [kind[0], zlib.crc32(kind[1].encode()), _plain(tree, arrays, states)]
    text = json.dumps(body, separators=(",", ":")).encode()
    checked = b"".join((text, *arrays))
    every = len(checked) + sum(map(len, states))
    head = _HEAD.pack(VERSION, _checksum(checked, len(text)), len(text), len(checked), every)
    return b"".join((MAGIC, head, checked, *states))


def _checksum(data: bytes | memoryview, begin: int) -> int:
    """Sum words of 64 bits, each times its own odd number, and a CRC of what is left: faster than a CRC."""
    words = np.frombuffer(data, "<u8", len(data) // 8)
    return (int(words @ _odd(words.size)) + zlib.crc32(data[8 * words.size :], begin)) % (1 << 64)


@lru_cache(maxsize=4)
def _odd(number: int) -> npt.NDArray[np.uint64]:
    return np.arange(1, 2 * number, 2, dtype=np.uint64)


def _plain(value: Any, arrays: list[memoryview], states: list[bytes]) -> object:
    """Convert a value to JSON; append the bytes of arrays, and states, to the lists."""
    if type(value) in _JSON:
        return value
    if isinstance(value, list):
        return [one if type(one) in _JSON else _plain(one, arrays, states) for one in value]
    if type(value) is dict and all(type(name) is str for name in value):
        inner = {name: one if type(one) in _JSON else _plain(one, arrays, states) for name, one in value.items()}
        return {"dict": inner}
    if isinstance(value, bytes) and value.startswith(MAGIC):
        states.append(value)
        return {"state": [sum(map(len, states[:-1])), sum(map(len, states))]}
    if isinstance(value, np.ndarray | np.generic):
        array, scalar = np.ascontiguousarray(value), isinstance(value, np.generic)
        arrays.append(array.reshape(-1).view(np.uint8).data)
        begin, fixed = sum(map(len, arrays[:-1])), scalar or not value.flags.writeable
        return {"array": [begin, begin + array.nbytes, array.dtype.str, list(np.shape(value)), scalar, fixed]}
    made_of = _INNER.get(type(value), _fields)
    return {type(value).__name__: _plain(made_of(value), arrays, states)}


def _fields(value: Any) -> dict[str, Any]:
    """Return what a dataclass is made of; fields that it is not made of are computed again."""
    return {field.name: getattr(value, field.name) for field in fields(value) if field.init}


def unpack(state: bytes, kind: Kind, values: Kinds = ()) -> dict[str, Any]:
    """Read a tree from bytes.

    Parameters
    ----------
    state
        The state, from `pack`.
    kind
        What it must be the state of.
    values
        Dataclasses that are values.

    Returns
    -------
    dict
        The tree. Its arrays are copies.

    Raises
    ------
    ValueError
        The bytes are no state, are damaged, have another format, or are of something else. The message is a sentence.
    """
    at = len(MAGIC) + _HEAD.size
    if not isinstance(state, bytes) or not state.startswith(MAGIC):
        found = f"{len(state)} other bytes" if isinstance(state, bytes) else f"a {type(state).__name__}"
        raise ValueError(f"a state must be the bytes that get_state() returned, got {found}")
    version, check, *lengths = _HEAD.unpack(state[len(MAGIC) : at].ljust(_HEAD.size, b"\0"))
    (text, checked, every), whole = lengths, memoryview(state)[at:]
    if whole and version != VERSION:
        raise ValueError(f"the format of a state must be {VERSION}, got {version}: save it with this version")
    if not 0 < text <= checked <= every == len(whole) < 1 << 32 or _checksum(whole[:checked], text) != check:
        raise ValueError("the state must be whole, got damaged bytes: save it again")
    name, digest, plain = json.loads(bytes(whole[:text]))
    if name != kind[0]:
        raise ValueError(f"the state must be of {kind[0]}, got one of {name}")
    if digest != zlib.crc32(kind[1].encode()):
        raise ValueError(f"the state must be of {name} with the same settings, got one with others")
    made = _OUTER | {one.__name__: lambda inner, one=one: one(**inner) for one in values}
    made |= {"array": partial(_array, whole[text:checked]), "state": lambda ends: bytes(whole[checked:][slice(*ends)])}
    tree: dict[str, Any] = _value(plain, made)
    return tree


def _value(plain: Any, made: Mapping[str, Callable[[Any], Any]]) -> Any:
    """Return the value of a piece of JSON."""
    if type(plain) in _JSON:
        return plain
    if isinstance(plain, list):
        return [one if type(one) in _JSON else _value(one, made) for one in plain]
    ((kind, inner),) = plain.items()
    if type(inner) is dict and kind == "dict":
        return {name: one if type(one) in _JSON else _value(one, made) for name, one in inner.items()}
    return made[kind](inner if kind in ("array", "state") else _value(inner, made))


def _array(arrays: memoryview, inner: tuple[int, int, str, list[int], bool, bool]) -> Any:
    begin, end, kind, shape, scalar, fixed = inner
    # A fixed array lies over immutable bytes of its own: nobody can make it writable.
    array = np.frombuffer(bytes(arrays[begin:end]) if fixed else arrays[begin:end], kind).reshape(shape)
    return array[()] if scalar else array if fixed else array.copy()


def _generator(state: dict[str, Any]) -> np.random.Generator:
    known = {kind.__name__: kind for kind in np.random.BitGenerator.__subclasses__()}
    generator = np.random.Generator(known[state["bit_generator"]]())
    generator.bit_generator.state = state
    return generator


_INNER: dict[type, Callable[[Any], object]] = {
    tuple: list, deque: lambda one: [list(one), one.maxlen], dict: lambda one: [[*pair] for pair in one.items()],
    np.random.Generator: lambda one: one.bit_generator.state, bytes: lambda one: np.array([*one], np.uint8),
}  # fmt: skip
"""Kind of value -> what it is made of, of simpler kinds; a dataclass is made of its fields."""
_OUTER: dict[str, Callable[[Any], Any]] = {
    "tuple": tuple, "deque": lambda one: deque(*one), "dict": dict, "Generator": _generator,
    "bytes": lambda one: one.tobytes(),
}  # fmt: skip
"""Name of a kind of value -> its inverse."""
