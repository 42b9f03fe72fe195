"""No two random streams of the project are one, and those that are older than their names kept their numbers."""

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import colias_sim
import dsnn
import experiments
from colias_sim import streams as of_envs
from colias_sim.envs.randomise import FACTORS
from dsnn.stimuli import Jittered, stimulus
from dsnn.stimuli import streams as of_clips
from experiments.bench.run import streams as of_bench
from scenes import generate

SEEDS = (0, 1, 2, 3, 7, 1000, 2018, 2019, 2**32 - 1, 2**32, 2**32 + 1, 2**40)
WORD = 2**32


def draws(generator):
    """What a stream's first numbers are, whatever is made of them."""
    return generator.bit_generator.random_raw(8).tobytes()


def every_stream():
    """(stream, seed) -> its first numbers."""
    first_numbers = {}
    for seed in SEEDS:
        first_numbers |= {(f"clip {name}", seed): draws(of_clips.stream(name, seed)) for name in of_clips.KEYS}
        first_numbers |= {(name, seed): draws(of_bench.stream(name, seed)) for name in of_bench.KEYS}
        if seed < WORD:  # how Gymnasium seeds is its own: by the seed's words
            first_numbers["world", seed] = draws(of_envs.world(seed))
            episode = of_envs.episode(of_envs.world(seed))
            first_numbers["film", seed] = draws(of_envs.film(episode))
            first_numbers |= {(f"factor {name}", seed): draws(of_envs.factor(episode, name)) for name in FACTORS}
    return first_numbers


def older_than_its_name(one, other):
    """Clips and episodes are never one computation, and each must stay as it was: these two pairs share their seeds."""
    pairs = ({"clip stimulus", "world"}, {"clip cluttered.start", "policy"})
    return {one[0], other[0]} in pairs and one[1] == other[1]


def test_no_two_streams_are_equal():
    first_numbers = every_stream()
    assert len(first_numbers) > 140
    equal = [
        (one, other)
        for one, other in itertools.combinations(first_numbers, 2)
        if first_numbers[one] == first_numbers[other] and not older_than_its_name(one, other)
    ]
    assert equal == []


def test_no_two_names_of_a_package_have_one_key():
    for module in (of_clips, of_bench):
        assert len(set(module.KEYS.values())) == len(module.KEYS)
    assert of_clips.ROOM != of_bench.ROOM
    assert len(set(generate.SEEDS.values())) == len(generate.SEEDS)


@pytest.mark.parametrize("seed", [0, 1, 5])
def test_a_camera_trembles_by_other_numbers_than_those_its_clip_is_made_of(seed):
    """The leaderboard's clip: where the background starts, and the shifts, came from one stream."""
    clip = stimulus("cluttered", seed, rows=16, columns=32, width=8, height=8, object="absent", fps=10.0)
    shifts = Jittered(clip, 1.0, seed).shifts
    for before in (np.random.default_rng((seed, 1)), np.random.default_rng(seed)):
        assert not np.isin(np.clip(before.standard_normal(shifts.shape), -4, 4), shifts).any()


def test_a_pink_background_is_not_the_leaves_of_the_same_seed():
    leaves = stimulus("foliage", 3, rows=48, columns=96, amplitude_px=(0.0, 0.0))[0].luma.astype(float)
    pink = {"background": "pink", "object": "absent", "background_speed": 0.0, "width": 8, "height": 8}
    ground = stimulus("cluttered", 3, rows=48, columns=48, **pink)[0].luma.astype(float)
    # The window of 48 columns may be anywhere in the 96 that repeat.
    alike = [np.corrcoef(ground.ravel(), np.roll(leaves, -x, axis=1)[:, :48].ravel())[0, 1] for x in range(96)]
    assert max(alike) < 0.9


def test_every_draw_has_a_named_stream():
    """Generators are made in the modules that name them, and nowhere else."""
    calls = r"default_rng\(|RandomState\(|np\.random\.seed\(|random\.seed\("
    # An example in a docstring is a user's own generator.
    pattern = re.compile(rf"^(?!\s*(?:>>>|\.\.\.) ).*(?:{calls})|^import random", re.MULTILINE)
    folders = {Path(package.__file__).parent for package in (dsnn, colias_sim, experiments)}
    files = [file for folder in folders for file in folder.rglob("*.py")]
    assert len(files) > 80
    assert {file.name for file in files if pattern.search(file.read_text(encoding="utf-8"))} == {"streams.py"}
