"""The random streams of trials, episodes and statistics, by name. Two names never share their numbers.

Every random draw of ``experiments`` comes from `stream`; those of clips come from `dsnn.stimuli.streams`, those of an
env's world and film from `colias_sim.streams`.

- A **trial** with the robot has a seed of its own, hashed from the run's seed and the trial's index
  (`experiments.show.robot.trial_seed`), and draws from three streams at that seed; from a fourth where a processor
  skips frames.
- Repeat r of a **clip**, and episode r of a **behaviour**, have the run's seed plus r. So episode 1 of a run with seed
  0 is what episode 0 of a run with seed 1 is; within a run no two repeats are alike. Repeat r of a clip has scene r
  too (`experiments.show.clips.clips_of`).
- **Bootstrap** and **permutations** always start at seed 0: equal tables get equal intervals and p values. The
  bootstrap over training seeds starts at the first of them.
"""

from collections.abc import Mapping

import numpy as np

ROOM = 3
"""Begins the spawn keys of this package's streams, but the trials', which are older and have one word."""

KEYS: Mapping[str, tuple[int, ...]] = {
    "trial.placing": (0,),  # where the stimulus starts, and its heading
    "trial.scenery": (1,),  # light, phase of the wall, and how unequal the motors are
    "trial.noise": (2,),  # of the camera
    "policy": (ROOM, 0),  # what a behaviour draws itself
    "bootstrap.mean": (ROOM, 1),
    "permutations.order": (ROOM, 2),  # of trials among groups
    "bootstrap.blocks": (ROOM, 3),  # of footage
    "permutations.signs": (ROOM, 5),  # of differences
    "bootstrap.training": (ROOM, 6),  # of training seeds
    "permutations.points": (ROOM, 7),  # of a tuning curve
    "course.nominal": (ROOM, 4),  # the errors of a start pose whose spread is 0
    "firmware.clips": (ROOM, 15),  # what the chip's program is measured with
    "conformance.frame": (ROOM, 17),  # that a model is shown again and again
    "trial.shuffled": (ROOM, 21),  # the order of frames in a control
    "benchmark.sample": (ROOM, 25),  # the trials that a verifier does again
    "fit.sample": (ROOM, 18),  # how the even sample of a fit's box is scrambled
    "plausible.box": (ROOM, 20),  # apparatus drawn from what nobody knows
    "trial.events": (ROOM, 80),  # thresholds and noise of an event camera
    "trial.processor": (ROOM, 19),  # the first frame that a processor takes
}
"""Name -> the spawn key that tells its numbers from the others'. A new name takes a new key."""

_WORDS: Mapping[str, tuple[int, ...]] = {"policy": (1,)}
"""Streams older than their names: seeded by the seed and these words, so that episodes stay as they were."""

_WORD = 2**32
"""A larger seed has a second word, which could be one of `_WORDS`."""


def stream(name: str, seed: int) -> np.random.Generator:
    """Return a new generator of the stream ``name`` at ``seed``, 0 or more. ``ValueError`` on an unknown name."""
    if name not in KEYS:
        raise ValueError(f"no random stream '{name}': known are {', '.join(KEYS)}")
    if name in _WORDS and seed < _WORD:
        return np.random.default_rng((seed, *_WORDS[name]))
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=KEYS[name]))
