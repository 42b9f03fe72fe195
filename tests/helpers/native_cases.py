"""Cases for ``dsnn/native/cases.c``: shapes, parameters and frames over their whole ranges, from a seed."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dsnn import DSNN, LGMD1, DSNNParams, LGMD1Params, OnboardDSNN, OnboardParams
from dsnn.filters import gaussian_kernel, residue
from dsnn.native import binding
from dsnn.onboard.fixed import Fixed, constants
from dsnn.onboard.header import TABLES
from dsnn.onboard.params import READINGS

NATIVE = Path(binding.__file__).parent
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
STRICT = ("-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-Wno-psabi", "-ffp-contract=off")
ROBOT_S = ("-D__ARM_FEATURE_DSP", f"-I{Path(__file__).parents[1] / 'arm'}")
"""The code of the on-board network for the Cortex-M4, its instructions in plain C."""
SANITIZED = ("-O1", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


@dataclass(frozen=True)
class Case:
    """One model with its parameters, and the frames it is shown, (T, R, C) uint8 or float32."""

    params: DSNNParams | LGMD1Params | OnboardParams
    frames: np.ndarray

    def written(self) -> bytes:
        """The case as the C program reads it."""
        count, rows, columns = self.frames.shape
        film = np.array([rows, columns, count, self.frames.dtype != np.uint8], np.int32)
        p = self.params
        if isinstance(p, LGMD1Params):
            parts = [
                np.int32(1), film, np.array([p.w_i, p.w_side, p.w_corner, p.t_g], np.float32),
                np.array([p.c_w, p.delta_c, p.t_ffi, p.t_sp]), self.frames,
            ]  # fmt: skip
        elif isinstance(p, OnboardParams):
            parts = [np.int32(2), film, *_fixed(constants((rows, columns), p)), self.frames]
        else:
            left = [1.0 - p.alpha(tau) for tau in (p.tau_fast, p.tau_slow)]
            parts = [
                np.int32(0), film,
                np.array([p.n_p, p.d, p.n_con, p.on, p.off, p.dog, p.fdsr, p.rectified], np.int32),
                np.int32(p.polarity == "common"),
                np.array([p.w_i, p.sigma_l, *left], np.float32),
                np.array([p.alpha(p.tau_mp), rows * columns * p.k_sig, p.k_sp, p.t_sp]),
                np.array([residue(p.u, i) for i in range(1, p.n_p + 1)], np.float32),
                gaussian_kernel(p.d)[4 * p.d :].astype(np.float32),
                gaussian_kernel(2 * p.d)[8 * p.d :].astype(np.float32),
                np.array([p.alpha(tau) for tau in p.delays()], np.float32), self.frames,
            ]  # fmt: skip
        return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)

    def answers(self) -> bytes:
        """What the extension module answers, in the program's bytes."""
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


def _fixed(c: Fixed) -> list[np.ndarray]:
    """The constants in the order of ``onboard_config``, each table with its count before it."""
    names = [name for name in Fixed.__slots__ if name not in TABLES]
    parts = [np.array(getattr(c, name), np.int64 if name == "plate_limit" else np.int32) for name in names]
    for name, kind in TABLES.items():
        entries = np.array(getattr(c, name), kind.removesuffix("_t"))
        parts += [np.array(len(entries), np.int32), entries]
    return parts


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


def compiled(folder: Path, *options: str) -> Path:
    """The program, built in ``folder``."""
    program = folder / "cases"
    sources = [str(NATIVE / name) for name in (*(s for s in binding.SOURCES if s.endswith(".c")), "cases.c")]
    subprocess.run([COMPILER, *STRICT, *options, *sources, "-o", str(program)], check=True, timeout=300)
    return program


def answered(program: Path, chosen: Sequence[Case]) -> bytes:
    """What the program answers to the cases; a sanitizer's report ends it, and is shown."""
    done = subprocess.run(
        [program], input=b"".join(case.written() for case in chosen), capture_output=True, timeout=900
    )
    assert done.returncode == 0, done.stderr.decode(errors="replace")[-3000:]
    return done.stdout
