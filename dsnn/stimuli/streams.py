"""Independent random streams of the stimuli, by name and seed.

Every random number of this package comes from `stream`. With one seed a clip may draw from several streams: its
pattern, its background, the camera's jitter. Two names, or two seeds of a name, never share their numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

ROOM = 1
"""First word of this package's spawn keys. Other packages' keys start with another word, or have only one."""

KEYS: Mapping[str, int] = MappingProxyType(
    {
        "stimulus": 0,  # dots, squares, leaves, the phase of a grating: a clip has one stimulus
        "cluttered.start": 1,  # which part of the background a clip starts at
        "background.pink": 2,  # the noise of a background
        "jitter": 3,  # the shifts of a trembling camera
        "target.start": 4,  # where in its scene a clip of a small target begins
        "street.ground": 10,  # what stands still in a street
        "street.leaves": 11,  # its leaves, and how they sway
        "street.movers": 12,  # who walks in a group
        "scene.dead-leaves": 20,  # discs
        "scene.foliage": 21,  # leaves that hang
        "scene.street": 22,  # houses
    }
)
"""Name -> the number of its stream. A new name takes a new number."""

_WORDS: Mapping[str, tuple[int, ...]] = MappingProxyType({"stimulus": (), "cluttered.start": (1,)})
"""Streams older than their names. They are seeded by the seed and these words, so that clips stay the same."""

_WORD = 2**32
"""A seed from here on has a second word, which could be one of `_WORDS`."""


def stream(name: str, seed: int) -> np.random.Generator:
    """Make a generator of the stream ``name`` at ``seed``, 0 or more; ``ValueError`` for an unknown name."""
    if name not in KEYS:
        raise ValueError(f"no random stream '{name}': known are {', '.join(KEYS)}")
    if name in _WORDS and seed < _WORD:
        return np.random.default_rng((seed, *_WORDS[name]))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(ROOM, KEYS[name])))
