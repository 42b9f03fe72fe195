"""Cases for the network in C: shapes, parameters and frames over their whole ranges, from a seed."""

import dataclasses
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter

from dsnn import DSNN, LGMD1, DSNNParams, LGMD1Params, OnboardDSNN, OnboardParams
from dsnn.native import binding
from dsnn.onboard.params import READINGS

T = TypeVar("T")
MODELS = {DSNNParams: DSNN, LGMD1Params: LGMD1, OnboardParams: OnboardDSNN}
NATIVE = Path(binding.__file__).parent
ROOT = Path(__file__).parents[2]
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-Wno-psabi", "-ffp-contract=off")
ROBOT_S = ("-D__ARM_FEATURE_DSP", f"-I{Path(__file__).parents[1] / 'arm'}")
"""The code of the on-board network for the Cortex-M4, its instructions in plain C."""
ANSWERS = """
import sys, types
from importlib.util import module_from_spec, spec_from_file_location
import numpy as np
spec = spec_from_file_location("_dsnn_native", sys.argv[2])  # an editable install has a finder for this name
sys.modules["_dsnn_native"] = module_from_spec(spec)
from dsnn import native
from tests.helpers.native_cases import answers

def odd(size, kind):
    return np.zeros(size + 1, kind)[1:]

native.np = types.SimpleNamespace(**vars(np) | {"zeros": odd})
assert not native.missing()
sys.stdout.buffer.write(answers(int(sys.argv[1])))
"""
"""Models get memory of their exact size at an odd address: sanitizers see every byte read or written beside it."""
SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


def every_answer(model: Any, frames: np.ndarray) -> list[Any]:
    """All that a model answers, its maps and its azimuth too: equal only where every bit is."""
    told = []
    for frame in frames:
        response = model.step(frame, maps=True)
        maps = dataclasses.astuple(response.maps) if response.maps is not None else ()
        numbers = dataclasses.astuple(dataclasses.replace(response, maps=None))
        azimuth = model.azimuth() if hasattr(model, "azimuth") else None
        again = model.read(model.params) if hasattr(model, "read") else None
        told.append((numbers, azimuth, again, *(layer.tobytes() for layer in maps)))
    return told


def answers(count: int) -> bytes:
    """What the extension module answers to ``count`` cases, as bytes."""
    told = [every_answer(MODELS[type(q)](frames.shape[1:], q, form="native"), frames) for q, frames in cases(count)]
    return repr(told).encode()


def cases(count: int) -> Iterator[tuple[Any, np.ndarray]]:
    """Parameters of ``count`` of the float models, and of the on-board network after every fourth, with frames.

    The smallest shapes and the extreme parameters are among the first.
    """
    for index in range(count):
        rng = np.random.default_rng([0, index])
        shape = [(2, 2), (2, 9), (9, 2), (3, 3)][index] if index < 4 else tuple(rng.integers(2, 45, 2))
        kind = LGMD1Params if index % 4 == 3 else DSNNParams
        yield drawn(kind, rng, extreme=index % 3 == 0), moving(rng, int(rng.integers(1, 7)), *shape)
        if index % 4 == 1:
            frames = np.rint(moving(rng, int(rng.integers(1, 7)), *shape)).astype(np.uint8)
            yield drawn(OnboardParams, rng, extreme=index % 8 == 1), frames


def drawn(kind: type[T], rng: np.random.Generator, extreme: bool) -> T:
    """Parameters about their defaults or at the ends of their ranges; drawn again where they do not fit together."""
    schema = TypeAdapter(kind).json_schema()["properties"]
    while True:
        values = {name: _drawn(rng, extreme, **field) for name, field in schema.items()}
        try:
            return kind(**values | (READINGS if kind is OnboardParams else {}))
        except ValueError:
            continue


def _drawn(rng: np.random.Generator, extreme: bool, default: Any, type: str = "", **field: Any) -> Any:
    if "enum" in field or type == "boolean":
        return rng.choice(field.get("enum", [True, False])).item()
    if type == "array":
        return tuple(
            _drawn(rng, extreme, start, **part) for start, part in zip(default, field["prefixItems"], strict=True)
        )
    if "anyOf" in field:
        return _drawn(rng, True, 0, **field["anyOf"][0]) if rng.random() < 0.3 else default
    low = field.get("minimum", field.get("exclusiveMinimum", 0) + 1e-6)
    high = field.get("maximum", field.get("exclusiveMaximum", 0) - 1e-3)
    value = (
        rng.choice([low, high]) if extreme and rng.random() < 0.4 else np.clip(rng.uniform(0, 3) * default, low, high)
    )
    return round(value) if type == "integer" else float(value)


def moving(rng: np.random.Generator, count: int, rows: int, columns: int) -> np.ndarray:
    kind = rng.integers(5)
    if kind == 0:  # flicker
        frames = np.zeros((count, rows, columns)) + 255 * (np.arange(count) % 2)[:, None, None]
    elif kind == 1:  # still
        frames = np.full((count, rows, columns), float(rng.integers(256)))
    elif kind == 2:  # a chequered board that moves
        board = np.indices((rows, columns + count)).sum(0) // 2 % 2 * 255.0
        frames = np.stack([board[:, i : i + columns] for i in range(count)])
    else:
        frames = rng.uniform(0, 255, (count, rows, columns))
    return frames.astype(np.float32 if rng.integers(2) else np.uint8)


def compiled(folder: Path, *options: str) -> None:
    """Build the extension module in ``folder`` with a compiler's options."""
    build = [COMPILER, *options, "-fPIC", f"-I{NATIVE}", f"-I{sysconfig.get_path('include')}"]
    sources = [NATIVE / name for name in binding.SOURCES if name.endswith(".c")]
    subprocess.run([*build, *STRICT, "-c", *sources], cwd=folder, check=True, timeout=300)
    binding.write(str(folder / "_dsnn_native.c"))
    objects = [f"{source.stem}.o" for source in sources]
    command = [*build, "-w", "-shared", "_dsnn_native.c", *objects, "-o", "_dsnn_native.so"]
    subprocess.run(command, cwd=folder, check=True, timeout=300)


def answered(folder: Path, count: int) -> bytes:
    """What the module in ``folder`` answers to ``count`` cases; a sanitizer's report ends it, and is shown."""
    find = [COMPILER, "-print-file-name=libasan.so"]
    sanitizer = subprocess.run(find, capture_output=True, text=True, check=True).stdout.strip()
    done = subprocess.run(
        [sys.executable, "-c", ANSWERS, str(count), folder / "_dsnn_native.so"],
        cwd=ROOT, capture_output=True, timeout=900,
        env=os.environ | {"PYTHONMALLOC": "malloc", "LD_PRELOAD": sanitizer, "ASAN_OPTIONS": "detect_leaks=0"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr.decode(errors="replace")[-3000:]
    return done.stdout
