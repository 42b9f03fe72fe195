"""The models in C, if the extension module is built: fast, in float32, with equal bits on every machine.

``dsnn.h`` documents the C side. This side makes the tables, passes frames, and wraps the results.
"""

from __future__ import annotations

import functools
import importlib
from collections.abc import Iterable
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.filters import gaussian_kernel, residue
from dsnn.model import LayerMaps, Response
from dsnn.native import binding
from dsnn.params import DSNNParams

_loaded: ModuleType | None
try:
    _loaded = importlib.import_module("_dsnn_native")
except ImportError:
    _loaded = None

Floats = npt.NDArray[np.float32]


@functools.cache
def missing() -> str:
    """Explain why the native form cannot run, as the end of a sentence about it; empty if it can."""
    if _loaded is None:
        return "is not built"
    built_from = _loaded.ffi.string(_loaded.lib.vision_source).decode()
    try:
        here = binding.digest()
    except OSError:  # installed without its sources
        return ""
    return "" if built_from == here else "was built from other C sources than those here"


def kernel() -> ModuleType:
    """Load the extension module, cffi's ``ffi`` and ``lib``; ``ImportError`` with the reason from `missing`."""
    reason = missing()
    if reason or _loaded is None:
        raise ImportError(f"the native form {reason}")
    return _loaded


class NativeModel:
    """A model in C: its memory, its output, and how it receives frames. ``name`` is the prefix of its functions."""

    def __init__(self, name: str, config: Any) -> None:
        module = kernel()
        self._ffi, self._lib = module.ffi, module.lib
        size_of, make, self._reset, self._state_size, self._save, self._load = (
            getattr(self._lib, f"{name}_{what}") for what in ("size", "make", "reset", "state_size", "save", "load")
        )
        steps: list[Any] = [getattr(self._lib, f"{name}_step_{kind}", None) for kind in ("u8", "f32")]
        self._step_bytes, self._step_floats = steps
        size = size_of(config)
        if not size:
            raise MemoryError(f"{name} of shape {config.rows, config.columns} needs more memory than can be addressed")
        self._memory = np.zeros(size, np.uint8)
        self._model = make(self._ffi.from_buffer("char[]", self._memory), size, config)
        self._answer = self._ffi.new(f"{name}_answer *")

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._reset(self._model)

    def get_state(self) -> npt.NDArray[np.uint8]:
        """Copy the arrays that the model keeps between two frames."""
        size = self._state_size(self._model)
        if not size:
            raise ValueError("a model that follows the front of another cannot be saved or restored: make one without")
        state = np.empty(size, np.uint8)
        self._save(self._model, self._ffi.from_buffer("uint8_t[]", state))
        return state

    def set_state(self, state: npt.NDArray[np.uint8]) -> None:
        """Restore the arrays; ``ValueError``, and nothing done, for those of another model."""
        same = state.size == self._state_size(self._model)
        if not (same and self._load(self._model, self._ffi.from_buffer("uint8_t[]", state))):
            raise ValueError("the state is of another model, or this one follows the front of another")

    def _see(self, luma: npt.NDArray[Any]) -> Any:
        """Compute the output for the next frame, (R, C) uint8 or floating point; the next call overwrites it."""
        if luma.dtype == np.uint8:
            self._step_bytes(self._model, self._ffi.from_buffer("uint8_t[]", np.ascontiguousarray(luma)), self._answer)
        else:
            floats = np.ascontiguousarray(luma, np.float32)
            self._step_floats(self._model, self._ffi.from_buffer("float[]", floats), self._answer)
        return self._answer


class NativeNetwork(NativeModel):
    """The DSNN's layers in C; `dsnn.direction.network.DSNN` checks the input."""

    def __init__(self, shape: tuple[int, int], params: DSNNParams) -> None:
        self._shape = shape
        config, tables = _network_config(shape, params)
        super().__init__("dsnn", config)
        del tables  # the C side has copied them

    def step(self, luma: npt.NDArray[Any], *, maps: bool) -> Response:
        """Respond to the next frame, (R, C) uint8 or floating."""
        return _response(self._see(luma), self._maps() if maps else None)

    def follow(self, front: NativeNetwork) -> None:
        """Take F from another network, as `dsnn.DSNN.follow` does."""
        if self._lib.dsnn_follow(self._model, front._model):
            self._front = front  # whose memory it reads

    def read(self, params: DSNNParams) -> Response:
        """Respond to the last frame again, as `dsnn.DSNN.read` does."""
        config, _ = _network_config(self._shape, params)
        self._lib.dsnn_read(self._model, config, self._answer)
        return _response(self._answer)

    def azimuth(self) -> float:
        """Locate the motion of the last frame, as `dsnn.direction.network.DSNN.azimuth` does."""
        return float(self._lib.dsnn_azimuth(self._model))

    def _maps(self) -> LayerMaps:
        layers: Floats = np.empty((4, *self._shape), np.float32)
        self._lib.dsnn_maps(self._model, *(self._ffi.from_buffer("float[]", layer) for layer in layers))
        return LayerMaps(*layers)


def _response(answer: Any, maps: LayerMaps | None = None) -> Response:
    return Response(answer.hs, answer.vs, answer.hs_spikes, answer.vs_spikes, maps)


@functools.lru_cache(maxsize=64)
def _network_config(shape: tuple[int, int], params: DSNNParams) -> tuple[Any, list[Any]]:
    """Make the C side's configuration, and the tables that it points to."""
    q, (rows, columns), ffi = params, shape, kernel().ffi
    values: list[Iterable[float]] = [
        [residue(q.u, i) for i in range(1, q.n_p + 1)] or [0.0],
        *(gaussian_kernel(sigma)[4 * sigma :, 0] for sigma in (q.d, 2 * q.d)),
        [q.alpha(tau) for tau in q.delays()],
    ]
    tables = [ffi.new("float[]", [float(value) for value in table]) for table in values]
    config = ffi.new(
        "dsnn_config *",
        dict(
            rows=rows, columns=columns, n_p=q.n_p, d=q.d, n_con=q.n_con, on=q.on, off=q.off, dog=q.dog, fdsr=q.fdsr,
            rectified=q.rectified, common=q.polarity == "common", w_i=q.w_i, sigma_l=q.sigma_l,
            left_fast=1.0 - q.alpha(q.tau_fast), left_slow=1.0 - q.alpha(q.tau_slow), alpha_mp=q.alpha(q.tau_mp),
            scale=rows * columns * q.k_sig, k_sp=q.k_sp, t_sp=q.t_sp,
            taps_fdsr=q.lowpass in ("two-tap", "two-tap-fdsr"), taps_delay=q.lowpass == "two-tap",
        )
        | dict(zip(("residues", "kernel_e", "kernel_i", "alphas"), tables, strict=True)),
    )  # fmt: skip
    return config, tables


class NativeLGMD1(NativeModel):
    """The LGMD1's layers in C; `dsnn.looming.lgmd1.LGMD1` checks the input."""

    def __init__(self, shape: tuple[int, int], **parameters: float) -> None:
        config = kernel().ffi.new("lgmd1_config *", dict(rows=shape[0], columns=shape[1], **parameters))
        super().__init__("lgmd1", config)

    def step(self, luma: npt.NDArray[Any]) -> tuple[float, int]:
        """Return the membrane potential after the next frame, (R, C) uint8 or floating, and its spike, 0 or 1."""
        answer = self._see(luma)
        return answer.potential, int(answer.spike)
