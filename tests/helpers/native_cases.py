"""Cases for the network in C: shapes, parameters and frames over their whole ranges, from a seed."""

from __future__ import annotations

import dataclasses
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dsnn import DSNN, LGMD1, DSNNParams, LGMD1Params, OnboardDSNN, OnboardParams
from dsnn.native import binding
from dsnn.onboard.params import READINGS

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
from tests.helpers.native_cases import cases

def odd(size, kind):
    return np.zeros(size + 1, kind)[1:]

native.np = types.SimpleNamespace(**vars(np) | {"zeros": odd})
assert not native.missing()
sys.stdout.buffer.write(b"".join(case.answers() for case in cases(int(sys.argv[1]))))
"""
"""Models get memory of their exact size at an odd address: sanitizers see every byte read or written beside it."""
SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


@dataclass(frozen=True)
class Case:
    """One model with its parameters, and the frames it is shown, (T, R, C) uint8 or float32."""

    params: DSNNParams | LGMD1Params | OnboardParams
    frames: np.ndarray

    def answers(self) -> bytes:
        """What the extension module answers, as bytes."""
        shape = self.frames.shape[1:]
        fields = []
        if isinstance(self.params, LGMD1Params):
            detector = LGMD1(shape, self.params, form="native")
            for frame in self.frames:
                a = detector.step(frame)
                fields += [np.float64(a.looming), np.int32(a.looming_spikes)]
        elif isinstance(self.params, OnboardParams):
            network = OnboardDSNN(shape, self.params, form="native")
            for frame in self.frames:
                a = network.step(frame, maps=True)
                fields.append(np.array([a.hs * 32768, a.vs * 32768, a.hs_spikes, a.vs_spikes], np.int32))
            c = network.fixed
            fractions = (c.p_frac, c.la_frac, c.f_frac, c.f_frac)
            layers = zip((a.maps.p, a.maps.la, a.maps.f_on, a.maps.f_off), fractions, strict=True)
            fields += [np.rint(layer * 2.0**bits).astype(np.int32) for layer, bits in layers]
        else:
            network = DSNN(shape, self.params, form="native")
            for frame in self.frames:
                a = network.step(frame, maps=True)
                counts = np.array([a.hs_spikes, a.vs_spikes], np.int32)
                fields += [np.array([a.hs, a.vs]), counts, np.float64(network.azimuth())]
            fields += [a.maps.p, a.maps.la, a.maps.f_on, a.maps.f_off]
        return b"".join(value.tobytes() for value in fields)


def cases(count: int, seed: int = 0) -> Iterator[Case]:
    """``count`` of the float models, and one of the on-board network after every fourth; the smallest shapes and the
    extreme parameters are among the first."""
    for index in range(count):
        rng = np.random.default_rng([seed, index])
        shape = [(2, 2), (2, 9), (9, 2), (3, 3)][index] if index < 4 else tuple(rng.integers(2, 45, 2))
        params = _lgmd1(rng) if index % 4 == 3 else _dsnn(rng, extreme=index % 3 == 0)
        yield Case(params, _frames(rng, int(rng.integers(1, 7)), *shape))
        if index % 4 == 1:
            frames = np.rint(_frames(rng, int(rng.integers(1, 7)), *shape)).astype(np.uint8)
            yield Case(onboard(rng, extreme=index % 8 == 1), frames)


def onboard(rng: np.random.Generator, extreme: bool) -> OnboardParams:
    """Parameters over their whole ranges, in any format; drawn again where the format refuses them."""
    while True:
        floats = dataclasses.asdict(_dsnn(rng, extreme)) | READINGS
        formats = dict(
            state_bits=int(rng.choice([8, 16])), companding=bool(rng.random() < 0.7),
            lamina_bits=int(rng.choice([8, 16])), rounding=str(rng.choice(["nearest", "truncate"])),
            halved=bool(rng.random() < 0.3),
            f_bits=int(rng.integers(16)) if rng.random() < 0.3 else None,
        )  # fmt: skip
        try:
            return OnboardParams(**floats, **formats)
        except ValueError:
            continue


def _between(rng: np.random.Generator, low: float, high: float, extreme: bool) -> float:
    return float(rng.choice([low, high])) if extreme and rng.random() < 0.5 else float(rng.uniform(low, high))


def _dsnn(rng: np.random.Generator, extreme: bool) -> DSNNParams:
    def value(low: float, high: float) -> float:
        return _between(rng, low, high, extreme)

    return DSNNParams(
        n_p=round(value(0, 60 if extreme else 6)), u=value(0.0, 3.0), d=round(value(1, 16 if extreme else 4)),
        n_con=round(value(1, 64 if extreme else 9)), w_i=value(0.0, 1.0), sigma_l=value(0.0, 0.999),
        tau_fast=value(0.0, 10_000.0), tau_slow=value(0.0, 10_000.0), tau_s=(value(0.0, 10_000.0), value(0.0, 300.0)),
        tau_mp=value(0.0, 10_000.0), k_sig=value(1e-6, 1e3), k_sp=value(0.0, 20.0), t_sp=value(0.0, 1.0),
        fps=value(0.01, 10_000.0), on=bool(rng.integers(2)), off=bool(rng.integers(2)), fdsr=bool(rng.integers(2)),
        dog=bool(rng.random() < 0.8), polarity=str(rng.choice(["common", "centre"])), rectified=bool(rng.integers(2)),
        lowpass=str(rng.choice(["backward-euler", "exact"])),
    )  # fmt: skip


def _lgmd1(rng: np.random.Generator) -> LGMD1Params:
    return LGMD1Params(
        w_i=rng.uniform(0, 10), w_side=rng.uniform(0, 10), w_corner=rng.uniform(0, 10), c_w=rng.uniform(1e-3, 1e3),
        delta_c=rng.uniform(1e-6, 1e3), t_g=rng.choice([0.0, 30.0, 1e6]), t_ffi=rng.uniform(0, 255),
        t_sp=rng.uniform(0.501, 1.0),
    )  # fmt: skip


def _frames(rng: np.random.Generator, count: int, rows: int, columns: int) -> np.ndarray:
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
