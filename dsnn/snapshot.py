"""Save and restore what a model or a simulator keeps from frame to frame, as one value of bytes.

A state has a header (what it is of, and a digest of its configuration), a tree of plain values as JSON, and the bytes
of its arrays. Nothing in it is executed. `PARTS` says for each class which attributes are its state.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
import zlib
from collections import deque
from collections.abc import Mapping
from dataclasses import fields
from functools import reduce
from typing import Any

import numpy as np

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
    "dsnn.onboard.numpy_form.NumpyOnboard": "_luma _changes _la _h _codes _sums",
}
"""The models and their layers. Networks in C bring ``get_state`` and ``set_state``."""

MAGIC, VERSION = b"colias-state", 1
_HEAD = struct.Struct("<HIQQ")
"""Format; checksum of JSON and arrays; their lengths. The states of parts follow, which have checksums of their own."""
_PLAIN: Kinds = (type(None), bool, int, float, str, bytes, np.ndarray, np.generic, np.random.Generator)


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
    def inner(one: Any, name: str = "") -> Any:
        return _taken(one, f"{where}{name}", parts, plain, met)

    if isinstance(value, plain):
        met += [value] if isinstance(value, np.random.Generator) else []
        return value
    if type(value) is dict:
        return {name: inner(one, f"[{name!r}]") for name, one in value.items()}
    if type(value) is deque:
        return deque(map(inner, value), value.maxlen)
    if type(value) in (list, tuple):
        return type(value)(map(inner, value))
    if (names := attributes(value, parts)) is not None:
        there = {name: getattr(value, name) for name in names if hasattr(value, name)}
        return {name: inner(one, f".{name}") for name, one in there.items() if not any(one is other for other in met)}
    if hasattr(value, "get_state") and not whole:
        return value.get_state()
    kind = "" if whole else f" is a {type(value).__name__}, which"
    raise ValueError(f"{where}{kind} cannot be saved: give it get_state() and set_state(state)")


def put(part: object, tree: Mapping[str, Any], parts: Parts) -> None:
    """Give an object the state of `take`. Arrays and generators that it shares with others stay the same objects.

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
        case np.ndarray(), np.ndarray():
            fits = bool(current.flags.writeable) and (current.shape, current.dtype) == (value.shape, value.dtype)
            current[...] = value if fits else current
            return fits
        case np.random.Generator(), np.random.Generator():
            fits = type(current.bit_generator) is type(value.bit_generator)
            current.bit_generator.state = value.bit_generator.state if fits else current.bit_generator.state
            return fits
        case (list() | tuple(), list() | tuple()) if len(current) == len(value) > 0:
            return all(_filled(one, other, parts) for one, other in zip(current, value, strict=True))
        case (dict(), dict()) if current.keys() == value.keys() and value:
            return all(_filled(current[name], value[name], parts) for name in value)
        case _, dict() if attributes(current, parts) is not None:
            put(current, value, parts)
            return True
    if hasattr(current, "set_state"):
        current.set_state(value)
    return hasattr(current, "set_state")


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
    body = [kind[0], _digest(kind), _plain(tree, arrays, states)]
    checked = [text := json.dumps(body, separators=(",", ":")).encode(), *arrays]
    check = reduce(lambda sum_, one: zlib.crc32(one, sum_), checked, len(text))
    head = _HEAD.pack(VERSION, check, len(text), sum(map(len, checked)))
    return b"".join((MAGIC, head, *checked, *states))


def _digest(kind: Kind) -> str:
    return hashlib.sha256(kind[1].encode()).hexdigest()[:16]


def _plain(value: Any, arrays: list[memoryview], states: list[bytes]) -> object:
    """Convert a value to JSON; append the bytes of arrays, and states, to the lists."""

    def plain(one: Any) -> object:
        return _plain(one, arrays, states)

    match value:
        case np.ndarray() | np.generic():
            array = np.ascontiguousarray(value)
            arrays.append(array.reshape(-1).view(np.uint8).data)
            scalar = isinstance(value, np.generic)
            return {"array": [array.dtype.str, np.shape(value), scalar, scalar or not value.flags.writeable]}
        case None | bool() | int() | float() | str():
            return value
        case bytes():
            states.append(value)
            return {"bytes": [len(value), 0 if value.startswith(MAGIC) else zlib.crc32(value)]}
        case list():
            return [plain(one) for one in value]
        case tuple():
            return {"tuple": plain(list(value))}
        case deque():
            return {"deque": [plain(list(value)), value.maxlen]}
        case dict():
            return {"dict": [[name, plain(one)] for name, one in value.items()]}
        case np.random.Generator():
            return {"generator": plain(value.bit_generator.state)}
    return {type(value).__name__: plain({one.name: getattr(value, one.name) for one in fields(value)})}


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
    version, check, text, checked = _HEAD.unpack(state[len(MAGIC) : at].ljust(_HEAD.size, b"\0"))
    if len(state) >= at and version != VERSION:
        raise ValueError(f"the format of a state must be {VERSION}, got {version}: save it with this version")
    whole = memoryview(state)[at : at + checked]
    if not 0 < text <= len(whole) == checked or zlib.crc32(whole, text & 0xFFFFFFFF) != check:
        raise ValueError(_DAMAGED)
    name, digest, plain = json.loads(bytes(whole[:text]))
    if name != kind[0]:
        raise ValueError(f"the state must be of {kind[0]}, got one of {name}")
    if digest != _digest(kind):
        raise ValueError(f"the state must be of {name} with the same settings, got one with others")
    reader = _Reader(whole[text:], state[at + checked :], values)
    tree: dict[str, Any] = reader.value(plain)
    if reader.states:
        raise ValueError(_DAMAGED)
    return tree


_DAMAGED = "the state must be whole, got damaged bytes: save it again"


class _Reader:
    """Reads values from JSON, and from the bytes of arrays and states, in their order."""

    def __init__(self, arrays: memoryview, states: bytes, values: Kinds) -> None:
        self._arrays, self.states = arrays, states
        self._values = {one.__name__: one for one in values}

    def value(self, plain: Any) -> Any:
        """Return the value of a piece of JSON."""
        if isinstance(plain, list):
            return [self.value(one) for one in plain]
        if not isinstance(plain, dict):
            return plain
        ((kind, inner),) = plain.items()
        match kind:
            case "array":
                return self._array(*inner)
            case "bytes":
                return self._bytes(*inner)
            case "tuple":
                return tuple(self.value(inner))
            case "deque":
                return deque(self.value(inner[0]), inner[1])
            case "dict":
                return {name: self.value(one) for name, one in inner}
            case "generator":
                bits = self.value(inner)
                known = {one.__name__: one for one in np.random.BitGenerator.__subclasses__()}
                generator = np.random.Generator(known[bits["bit_generator"]]())
                generator.bit_generator.state = bits
                return generator
        return self._values[kind](**self.value(inner))

    def _array(self, kind: str, shape: list[int], scalar: bool, fixed: bool) -> Any:
        size = np.dtype(kind).itemsize * math.prod(shape)
        mine, self._arrays = self._arrays[:size], self._arrays[size:]
        # A fixed array lies over immutable bytes of its own: nobody can make it writable.
        array = np.frombuffer(bytes(mine) if fixed else mine, kind).reshape(shape)
        return array[()] if scalar else array if fixed else array.copy()

    def _bytes(self, length: int, check: int) -> bytes:
        taken, self.states = self.states[:length], self.states[length:]
        if len(taken) < length or (check and zlib.crc32(taken) != check):
            raise ValueError(_DAMAGED)
        return taken
