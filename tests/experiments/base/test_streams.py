"""No two random streams of the project are one, and those that are older than their names kept their numbers."""

import itertools

from colias_sim import streams as of_envs
from colias_sim.envs.randomise import FACTORS
from dsnn.stimuli import streams as of_clips
from experiments.base import streams as of_bench

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
