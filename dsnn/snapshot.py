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
from dataclasses import dataclass, fields
from functools import reduce
from typing import Any

import numpy as np

Parts = Mapping[str, tuple[str, str]]
Tree = dict[str, object]
Kinds = tuple[type, ...]
_PLAIN: Kinds = (type(None), bool, int, float, str, bytes, np.ndarray, np.generic)

PARTS: Parts = {
    "dsnn.model.Model": ("_scale_known", "shape params form"),
    "dsnn.direction.network.DSNN": ("_network", ""),
    "dsnn.direction.reference.ReferenceNetwork": ("_luminance _residues _on _off", "_shape _params _kernels"),
    "dsnn.direction.reference.Pathway": ("la f _adaptation _delays lp_hs lp_vs", "_params _alphas"),
    "dsnn.direction.emd.EMD": ("_retina _states _means", "_pass _delay _shifts _h _d"),
    "dsnn.direction.emd_normalised.EMDNormalised": ("_retina _states", "_pass _delay _h _d"),
    "dsnn.direction.flow.Flow": ("_before _now _first", "_dis _flow"),
    "dsnn.direction.t4t5.T4T5": ("_local", ""),
    "dsnn.direction.local_motion.LocalMotion": (
        "_retina _states",
        "_q _excitatory _inhibitory _local _offsets _alphas _follow _signals _c _delayed _cells _drive _product"
        " _scratch _window _planes _motion",
    ),
    "dsnn.direction.three_arm.ThreeArm": ("_retina _states", "_pass _delay _h _x _delayed"),
    "dsnn.filters.Retina": ("_before _first", "_change"),
    "dsnn.filters.States": ("_arrays frames", "_every _floor"),
    "dsnn.hybrid.Hybrid": ("_dsnn _lgmd _held", "_frames_held"),
    "dsnn.looming.layers.Detector": ("_count", ""),
    "dsnn.looming.layers.Adaptation": ("_k _adapted", "_hold _t_sfa _k_sp _t_sp"),
    "dsnn.looming.lgmd1.LGMD1": ("_layers", ""),
    "dsnn.looming.lgmd1._NumpyLayers": (
        "_retina _inhibition _change", "_params _kernel _grouping _excitation _s _zeros",
    ),
    "dsnn.looming.lgmd2.LGMD2": (
        "_retina _on _off _adaptation _pm", "_grouping _rises _falls _s _zeros _follow",
    ),
    "dsnn.looming.lgmd2.Pathway": (
        "_states", "_sigma _centre _kernels _alphas signal _delayed _scratch _zeros _s",
    ),
    "dsnn.looming.lplc2.LPLC2": (
        "_retina _states _contrast _outputs",
        "_kernels _neighbours _delay _follow _bias _rows _columns _signals _delayed _cells _drive",
    ),
    "dsnn.looming.lplc2_gf.LPLC2GF": (
        "_retina _states _share_before _v", "_dt _passed _delay _substeps _decay _h _delayed",
    ),
    "dsnn.looming.mlplc2.MLPLC2": ("_local _outputs", "_rows _columns"),
    "dsnn.looming.pon_lgmd.PONLGMD": ("_retina _motion_before", "_surround _neighbours _inhibiting _below"),
    "dsnn.looming.si_lgmd1.SILGMD1": (
        "_retina _delayed _mean_before", "_gains _kept _spared _blocks _lateral",
    ),
    "dsnn.looming.si_lgmd2.SILGMD2": (
        "_retina _on _off _adaptation _mean_before", "_kept _left _follow",
    ),
    "dsnn.looming.si_lgmd2._Pathway": ("_now _before", "_kernels _delay _kept _blocks _scratch"),
    "dsnn.onboard.model.OnboardDSNN": ("_stages", "fixed"),
    "dsnn.onboard.numpy_form.NumpyOnboard": ("_luma _changes _la _h _codes _sums", "_c"),
}  # fmt: skip
"""Class -> the attributes that are its state, and those that follow from them or from its configuration.

A class also has the attributes of its bases. Attributes that a user's subclass adds are state.
"""

MAGIC, VERSION = b"colias-state", 1
_HEAD = struct.Struct("<HIQQ")
"""Format; checksum of JSON and arrays; their lengths. The states of parts follow, which have checksums of their own."""


@dataclass(frozen=True)
class Kind:
    """What a state is of.

    Parameters
    ----------
    name
        The object, for messages.
    configuration
        Its configuration as a text: equal texts mean that a state of one fits the other.
    """

    name: str
    configuration: str

    @property
    def digest(self) -> str:
        """Digest of the configuration."""
        return hashlib.sha256(self.configuration.encode()).hexdigest()[:16]


def attributes(part: object, parts: Parts) -> tuple[list[str], set[str]] | None:
    """List the attributes of an object that are its state, and those that are not.

    Parameters
    ----------
    part
        The object.
    parts
        The table.

    Returns
    -------
    tuple or None
        Attributes that are state, in the order of the table, then attributes that no list has; and the others. ``None``
        for an object whose class is not in the table.
    """
    rows = [parts.get(f"{one.__module__}.{one.__qualname__}") for one in reversed(type(part).__mro__)]
    known = [row for row in rows if row is not None]
    if not known:
        return None
    state = list(dict.fromkeys(name for row in known for name in row[0].split()))
    rest = {name for row in known for name in row[1].split()}
    return [*state, *(name for name in vars(part) if name not in rest and name not in state)], rest


def take(part: object, parts: Parts, values: Kinds = ()) -> Tree:
    """Copy the state of an object.

    Parameters
    ----------
    part
        The object, of a class in ``parts``.
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
        An attribute is neither a value nor a part in the table, and has no ``get_state``.
    """
    return _tree(part, parts, (*_PLAIN, *values), [])


def _tree(part: object, parts: Parts, plain: Kinds, met: list[int]) -> Tree:
    names, _ = attributes(part, parts) or ([], set())
    tree: Tree = {}
    for name in names:
        if hasattr(part, name) and id(value := getattr(part, name)) not in met:
            tree[name] = _taken(value, f"{type(part).__name__}.{name}", parts, plain, met)
    return tree


def _taken(value: Any, where: str, parts: Parts, plain: Kinds, met: list[int]) -> object:
    if isinstance(value, np.random.Generator):
        met.append(id(value))
        return value
    if isinstance(value, plain):
        return value
    if type(value) is dict:
        return {name: _taken(one, f"{where}[{name!r}]", parts, plain, met) for name, one in value.items()}
    if type(value) is deque:
        return deque((_taken(one, where, parts, plain, met) for one in value), value.maxlen)
    if type(value) in (list, tuple):
        return type(value)(_taken(one, where, parts, plain, met) for one in value)
    if attributes(value, parts) is not None:
        return _tree(value, parts, plain, met)
    if hasattr(value, "get_state"):
        return value.get_state()
    raise ValueError(f"{where} is a {type(value).__name__}, which cannot be saved: give it get_state() and set_state()")


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
        current = getattr(part, name, None)
        if not _filled(current, value, parts):
            setattr(part, name, value)


def _filled(current: Any, value: Any, parts: Parts) -> bool:
    """Put a value into an object that is there already; false where it has to be replaced."""
    if isinstance(current, np.ndarray) and isinstance(value, np.ndarray):
        fits = current.flags.writeable and (current.shape, current.dtype) == (value.shape, value.dtype)
        if fits:
            current[...] = value
        return fits
    if isinstance(current, np.random.Generator) and isinstance(value, np.random.Generator):
        if type(current.bit_generator) is not type(value.bit_generator):
            return False
        current.bit_generator.state = value.bit_generator.state
        return True
    if isinstance(current, list | tuple) and isinstance(value, list | tuple) and len(current) == len(value):
        return bool(value) and all(_filled(one, other, parts) for one, other in zip(current, value, strict=True))
    if isinstance(current, dict) and isinstance(value, dict) and current.keys() == value.keys():
        return bool(value) and all(_filled(current[name], value[name], parts) for name in value)
    if isinstance(value, dict) and attributes(current, parts) is not None:
        put(current, value, parts)
        return True
    if hasattr(current, "set_state"):
        current.set_state(value)
        return True
    return False


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
    arrays: list[bytes | memoryview] = []
    states: list[bytes] = []
    body = {"name": kind.name, "digest": kind.digest, "tree": _plain(tree, arrays, states)}
    checked = [text := json.dumps(body, separators=(",", ":")).encode(), *arrays]
    check = reduce(lambda sum_, one: zlib.crc32(one, sum_), checked, len(text))
    head = _HEAD.pack(VERSION, check, len(text), sum(map(len, checked)))
    return b"".join((MAGIC, head, *checked, *states))


def _plain(value: Any, arrays: list[bytes | memoryview], states: list[bytes]) -> object:
    """Convert a value to JSON; append the bytes of arrays, and states, to the lists."""

    def plain(one: Any) -> object:
        return _plain(one, arrays, states)

    match value:
        case np.ndarray() | np.generic():
            array = np.ascontiguousarray(value)
            arrays.append(array.reshape(-1).view(np.uint8).data)
            scalar, fixed = isinstance(value, np.generic), isinstance(value, np.ndarray) and not value.flags.writeable
            return {"array": [array.dtype.str, np.shape(value), scalar, fixed]}
        case None | bool() | int() | float() | str():
            return value
        case bytes():
            (states if (state := value.startswith(MAGIC)) else arrays).append(value)
            return {"bytes": [len(value), state]}
        case list():
            return [plain(one) for one in value]
        case tuple():
            return {"tuple": [plain(one) for one in value]}
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
    if not text <= len(whole) == checked or not text or zlib.crc32(whole, text & 0xFFFFFFFF) != check:
        raise ValueError(f"the state must be whole, got {len(state)} damaged bytes: save it again")
    body = json.loads(bytes(whole[:text]))
    if body["name"] != kind.name:
        raise ValueError(f"the state must be of {kind.name}, got one of {body['name']}")
    if body["digest"] != kind.digest:
        raise ValueError(f"the state must be of {kind.name} with the same settings, got one with others")
    reader = _Reader(whole[text:], state[at + checked :], values)
    tree: dict[str, Any] = reader.value(body["tree"])
    if reader.states:
        raise ValueError(f"the state must be whole, got {len(reader.states)} bytes more: save it again")
    return tree


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

    def _bytes(self, length: int, state: bool) -> bytes:
        if state:
            taken, self.states = self.states[:length], self.states[length:]
        else:
            taken, self._arrays = bytes(self._arrays[:length]), self._arrays[length:]
        if len(taken) < length:
            raise ValueError(f"the state must be whole, got {length - len(taken)} bytes less: save it again")
        return taken
