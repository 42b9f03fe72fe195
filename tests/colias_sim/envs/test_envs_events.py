"""Events in the envs: counts as an observation, and a model that senses them."""

import numpy as np

from colias_sim.events import event_counts, joined
from dsnn import Response
from tests.helpers.envs import FIXATION, bare

FAST = {"supersample_columns": 4, "shot_noise_rate_hz": 2.0}
TURN = [-0.2, 0.2]


class Counter:
    """A model that keeps the events that it receives; HS is their number."""

    senses = "events"

    def __init__(self, shape, parameters=None):
        self.shape, self.received = shape, []

    def step(self, events):
        assert not events.flags.writeable and (np.diff(events["t"]) >= 0).all()
        self.received.append(events)
        return Response(hs=float(len(events)))

    def reset(self):
        self.received = []


def test_an_observation_has_the_counts_of_a_step_and_equal_seeds_equal_counts():
    one, again = (bare(FIXATION, observation="events", events=FAST) for _ in range(2))
    first, _ = (env.reset(seed=4)[0] for env in (one, again))
    assert one.observation_space.contains(first) and one.observation_space.shape == (2, 72, 99)
    for _ in range(3):
        (counts, *_), (equal, *_) = (env.step(TURN) for env in (one, again))
        assert counts.dtype == np.uint8 and np.array_equal(counts, equal) and counts.all(axis=0).any()
        assert np.array_equal(counts, event_counts(one.events, (72, 99))) and counts.sum(axis=(1, 2)).min() > 50
    assert not np.array_equal(one.reset(seed=5)[0], first), "thresholds and noise are the episode's own"


def test_a_model_that_senses_events_receives_each_once_whatever_its_processor_skips():
    every, second = (
        bare(FIXATION, observation="neural", model=Counter, events=FAST, frame_skip=2, processor={"every": n})
        for n in (1, 2)
    )
    for env in (every, second):
        env.reset(seed=4)
        env.step(TURN)
        env.step(TURN)
    assert [len(env.model.inner.received) for env in (every, second)] == [5, 3]
    assert np.array_equal(*(joined(env.model.inner.received) for env in (every, second)))
    assert np.array_equal(joined(every.model.inner.received[-2:]), every.events)
