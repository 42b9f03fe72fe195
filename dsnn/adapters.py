"""Other people's networks as models: a function, a PyTorch module or an ONNX file, each a `ModelEntry` in one call.

The frame is float32 (R, C), from 0 (black) to 1 (white). The network returns one number, the potential of one channel;
a sequence of numbers is one for each channel.

State
    A model begins with a deep copy of the network as you pass it, and ``reset()`` makes a new copy: so what the network
    keeps in its attributes belongs to one model, and is forgotten. A function's globals and closures are not copied:
    keep nothing there.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn.field_docs import parameters
from dsnn.model import SPIKING, Model, Response
from dsnn.registry import ModelEntry

Frame = npt.NDArray[np.float32]
Respond = Callable[[Frame], float | Sequence[float]]


@parameters
class AdapterParams:
    """Parameters of any adapted network."""

    gain: float = 1.0
    """Factor on what the network returns; of ``looming``, on what is above rest, 0.5."""
    t_sp: float | None = None
    """Threshold on the size of a potential, above which a frame has a spike; without it there are none."""


class Adapted(Model[AdapterParams]):
    """A network behind the interface of a model: see `from_callable`.

    Parameters
    ----------
    shape
        (R, C) of the frames.
    params
        The gain and the threshold.
    network
        Called with each frame.
    channels
        What it returns.
    """

    def __init__(
        self, shape: tuple[int, int], params: AdapterParams | None, network: Respond, channels: Sequence[str]
    ) -> None:
        super().__init__(shape, params, AdapterParams)
        self._network, self._channels = network, channels
        self.reset()

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._now = copy.deepcopy(self._network)

    def _respond(self, luminance: npt.NDArray[Any], maps: bool) -> Response:
        image = np.asarray(luminance, np.float32) / np.float32(255)
        values = np.ravel(self._now(image)).tolist()
        rests = [0.5 if channel == "looming" else 0.0 for channel in self._channels]
        found: dict[str, Any] = {
            channel: rest + self.params.gain * (value - rest)
            for channel, rest, value in zip(self._channels, rests, values, strict=True)
        }
        if (level := self.params.t_sp) is not None:
            for channel in SPIKING:
                value = found.get(channel, 0.0)
                found[f"{channel}_spikes"] = int(value > level) - int(value < -level)
        return Response(**found)


def from_callable(name: str, network: Respond, channels: Sequence[str] = ("hs",)) -> ModelEntry:
    """Make a model of a function of a frame, or of an object that is called with one.

    Parameters
    ----------
    name
        Its name in tables.
    network
        Returns a potential for each of ``channels``. A model has a deep copy of its own, and resets by a new one.
    channels
        Which those are, in order: any of ``hs``, ``vs``, ``looming`` (0.5 at rest, to 1) and ``azimuth``.

    Returns
    -------
    ModelEntry
        The model, with the parameters ``gain`` and ``t_sp``.

    Examples
    --------
    >>> from dsnn.adapters import from_callable
    >>> MODEL = from_callable("brightness", lambda frame: frame.mean() - 0.5)
    """

    def build(shape: tuple[int, int], params: AdapterParams) -> Adapted:
        return Adapted(shape, params, network, channels)

    return ModelEntry(name, f"{name}, adapted", build, AdapterParams(), tuple(channels))


class _Torch:
    def __init__(self, module: Any) -> None:
        self._module = module.eval()
        self._state: Sequence[Any] = ()

    def __call__(self, frame: Frame) -> Any:
        import torch  # not before: it is an extra

        with torch.no_grad():
            found = self._module(torch.from_numpy(frame)[None, None], *self._state)
        if isinstance(found, tuple):
            found, *self._state = found
        return found.numpy()


def from_torch(name: str, module: Any, channels: Sequence[str] = ("hs",)) -> ModelEntry:
    """Make a model of a ``torch.nn.Module``. Needs PyTorch: the extra ``[train]``.

    Parameters
    ----------
    name
        Its name in tables.
    module
        It is called with a tensor (1, 1, R, C), without gradients and in ``eval`` mode, and returns a potential for
        each channel. A recurrent one returns a tuple, the potentials and its state, which it receives after the next
        frame; at the first frame it is called with the frame alone.
    channels
        As of `from_callable`.

    Returns
    -------
    ModelEntry
        The model.
    """
    return from_callable(name, _Torch(module), channels)


class _Onnx:
    def __init__(self, path: str) -> None:
        self._path = path
        self._session: Any = None
        self._state: dict[str, Any] = {}

    def __call__(self, frame: Frame) -> Any:
        if self._session is None:
            import onnxruntime as ort  # not before: it is an extra

            options = ort.SessionOptions()
            options.intra_op_num_threads = 1  # the cores are the trials'
            self._session = ort.InferenceSession(self._path, options, providers=["CPUExecutionProvider"])
            self._state = {one.name: np.zeros(one.shape, np.float32) for one in self._session.get_inputs()[1:]}
        image = {self._session.get_inputs()[0].name: frame[np.newaxis, np.newaxis]}
        found, *state = self._session.run(None, {**image, **self._state})
        self._state = dict(zip(self._state, state, strict=False))
        return found


def from_onnx(name: str, path: str | Path, channels: Sequence[str] = ("hs",)) -> ModelEntry:
    """Make a model of an ONNX file. Needs onnxruntime: the extra ``[onnx]``.

    Parameters
    ----------
    name
        Its name in tables.
    path
        The file. Its first input is float32 (1, 1, R, C), its first output a potential for each channel. Further inputs
        are its state, of fixed shapes: zeros at first, then the further outputs, in order.
    channels
        As of `from_callable`.

    Returns
    -------
    ModelEntry
        The model. The file is opened at the first frame.
    """
    return from_callable(name, _Onnx(str(path)), channels)


def hexagons(
    shape: tuple[int, int], hfov_deg: float, rings: int = 15, pitch_deg: float = 5.8
) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Return where the columns of a fly's eye look in a frame, by the camera's angles.

    Columns are those of a hexagonal lattice about the middle of the view, sorted by their coordinates u, then v, as
    flyvis has them: a step of v is right and half down, one of u is down.

    Parameters
    ----------
    shape
        (R, C) of the frame.
    hfov_deg
        Horizontal field of view of its pinhole camera, below 180 degrees.
    rings
        Rings of columns about the middle one: 15 are 721 columns.
    pitch_deg
        Angle between neighbours.

    Returns
    -------
    x, y
        Column and row of each in px, (N,), as `cv2.remap` takes them. Most are outside of a narrow frame; those beyond
        90 degrees are NaN.
    """
    steps = range(-rings, rings + 1)
    u, v = np.array([(a, b) for a in steps for b in steps if abs(a + b) <= rings], float).T
    azimuth, elevation = np.radians(pitch_deg * np.array([np.sqrt(3) / 2 * v, u + v / 2]))
    ahead = np.maximum(np.abs(azimuth), np.abs(elevation)) < np.pi / 2
    focal = shape[1] / 2 / np.tan(np.radians(hfov_deg) / 2)
    places = (np.tan(azimuth), np.tan(elevation) / np.cos(azimuth))  # a column is a line of sight, at two angles
    x, y = (np.where(ahead, (size - 1) / 2 + focal * place, np.nan).astype(np.float32)
            for size, place in zip(shape[::-1], places, strict=True))  # fmt: skip
    return x, y
