"""Twenty models whose response is no vision of motion, or has its sign wrong, and the word that is right for each.

The words were written before any of these models was shown anything.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from dsnn import EMD, EMDParams, ModelEntry, Response
from experiments.settings.models import ConfiguredModel

Respond = Callable[["Memory", np.ndarray], float]


@dataclass(frozen=True)
class Nothing:
    """No parameter."""


@cache
def weights(pixels: int) -> tuple[np.ndarray, np.ndarray]:
    """Random weights of 50 units: from the pixels, and among themselves."""
    seeded = np.random.default_rng(1)
    return seeded.normal(size=(50, pixels)) / np.sqrt(pixels), seeded.normal(size=(50, 50)) / np.sqrt(50)


class Memory:
    """What a model keeps: frames so far, the first, the last, a generator, and a detector of motion that works."""

    def __init__(self, shape):
        self.count, self.first, self.last = 0, None, None
        self.rng = np.random.default_rng()
        self.detector = EMD(shape, EMDParams())
        self.turned = EMD(shape[::-1], EMDParams())
        self.state = np.zeros(50)
        self.inward, self.recurrent = weights(int(np.prod(shape)))
        self.sign = self.rng.choice([-1.0, 1.0])


class Broken:
    """A model of one function."""

    def __init__(self, shape, channel: str, respond: Respond):
        self.shape, self.channel, self.respond = shape, channel, respond
        self.reset()

    def reset(self):
        self.memory = Memory(self.shape)

    def step(self, frame):
        luma, memory = frame.astype(float) / 255.0, self.memory
        memory.frame = frame
        memory.first = luma if memory.first is None else memory.first
        memory.last = luma if memory.last is None else memory.last
        value = float(self.respond(memory, luma))
        memory.count, memory.last = memory.count + 1, luma
        return Response(**{self.channel: float(np.clip(value, 0.5, 1.0)) if self.channel == "looming" else value})


def sides(luma) -> float:
    """Light on the right less light on the left."""
    half = luma.shape[1] // 2
    return float(luma[:, -half:].mean() - luma[:, :half].mean())


def reservoir(memory: Memory, luma) -> float:
    memory.state = np.tanh(memory.recurrent @ memory.state + memory.inward @ luma.ravel())
    return float(memory.state.mean())


def dark_growth(memory: Memory, luma) -> float:
    """How much less is dark than in the last frame."""
    return float((memory.last < 0.3).mean() - (luma < 0.3).mean())


def edges(luma) -> float:
    return float((np.abs(np.diff(luma, axis=1)) > 0.2).sum()) / 100.0


BLIND, WRONG = "blind", "wrong sign"
BROKEN: dict[str, tuple[str, str, Respond]] = {
    "constant": (BLIND, "hs", lambda m, x: 0.3),
    "clock": (BLIND, "hs", lambda m, x: np.sin(m.count / 5)),
    "ramp": (BLIND, "hs", lambda m, x: 0.01 * m.count),
    "noise": (BLIND, "hs", lambda m, x: m.rng.normal()),
    "onset": (BLIND, "hs", lambda m, x: np.exp(-m.count / 10)),
    "first-frame-only": (BLIND, "hs", lambda m, x: sides(m.first)),
    "brightness": (BLIND, "hs", lambda m, x: x.mean()),
    "contrast": (BLIND, "hs", lambda m, x: x.std()),
    "flicker": (BLIND, "hs", lambda m, x: 10 * np.abs(x - m.last).mean()),
    "edge-counter": (BLIND, "hs", lambda m, x: edges(x)),
    "place": (BLIND, "hs", lambda m, x: sides(x)),
    "wrong-sign": (WRONG, "hs", lambda m, x: -m.detector.step(m.frame).hs),
    "mirrored-eye": (WRONG, "hs", lambda m, x: m.detector.step(np.fliplr(m.frame).copy()).hs),
    "other-axis": (BLIND, "hs", lambda m, x: m.detector.step(m.frame).vs),
    "any-sign": (BLIND, "hs", lambda m, x: abs(m.detector.step(m.frame).hs)),
    "sign-by-chance": (BLIND, "hs", lambda m, x: m.sign * m.detector.step(m.frame).hs),
    "random-network": (BLIND, "hs", reservoir),
    "looming-clock": (BLIND, "looming", lambda m, x: 0.5 + 0.005 * m.count),
    "looming-darkness": (BLIND, "looming", lambda m, x: 1.0 - x.mean() / 2),
    "receding": (WRONG, "looming", lambda m, x: 0.5 + 5 * dark_growth(m, x)),
}
"""Name -> the right word, the channel, and what it responds to a frame in 0..1."""


def chosen(name: str) -> ConfiguredModel:
    """Return a broken model as runs have it."""
    (_, channel, respond), network = BROKEN[name], Nothing()
    entry = ModelEntry(name, "broken", lambda shape, _: Broken(shape, channel, respond), network, (channel,))
    return ConfiguredModel(name, name, network, entry)
