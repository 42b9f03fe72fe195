"""Reflexes turn the right way, last as long as they should, and escape by any looming model alike."""

import math

import numpy as np
import pytest

from colias_sim.envs import ENVS
from dsnn import Response
from experiments.declare.behaviour import steer
from experiments.paper.behaviours import (
    AHEAD,
    BEHAVIOURS,
    FIXATION_GAINS,
    OPTOMOTOR_GAINS,
    ProportionalIntegral,
    Saccades,
    escape,
)

SILENT = Response()


def test_baselines_are_behaviours_of_envs():
    for env, entry in ENVS.items():
        assert set(entry.baselines) <= set(BEHAVIOURS)
        assert [BEHAVIOURS[name].env for name in entry.baselines if name.startswith("oracle")] == [env]


def stepped(name, seen, frames):
    """Wheels of a behaviour that sees the same for some frames, (frames, 2)."""
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    return np.array([policy(seen) for _ in range(frames)])


@pytest.mark.parametrize(("name", "channel"), [("optomotor-pi", "hs"), ("fixation-pi", "azimuth")])
def test_a_pi_reflex_turns_as_a_policy_that_gives_its_answers(name, channel):
    """Proportional and integral by hand, through the policy's `steer`, to the right of what is positive."""
    gains = {"optomotor-pi": OPTOMOTOR_GAINS, "fixation-pi": FIXATION_GAINS}[name]
    proportional, integral = gains
    command, total = np.zeros(2, np.float32), 0.0
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    for error in np.random.default_rng(1).uniform(-0.3, 0.3, 40).tolist():
        total = np.clip(total + integral * error / 30, -1.0, 1.0)
        answer = proportional * error + total
        command = steer(command, np.array([answer, -answer], np.float32))
        assert policy(Response(**{channel: error})) == pytest.approx(command.tolist(), abs=1e-6)
    right = stepped(name, Response(**{channel: 0.2}), 60)
    assert (right[:, 0] == -right[:, 1]).all() and (right[:, 0] > 0).all()
    np.testing.assert_array_equal(stepped(name, Response(**{channel: -0.2}), 60), -right)
    assert not stepped(name, SILENT, 5).any()


def test_an_integral_does_not_wind_up():
    """After minutes of a full error it takes as many frames to turn back as after its answer's ends are reached."""

    def frames_to_turn_back(frames):
        policy = ProportionalIntegral(lambda seen: seen.hs, 0.5, 1.0)
        for _ in range(frames):
            policy(Response(hs=1.0))
        return next(frame for frame in range(999) if policy(Response(hs=-1.0))[0] < 0)

    assert frames_to_turn_back(90) == frames_to_turn_back(9000)


@pytest.mark.parametrize(("name", "seen", "side"), [
    ("avoidance", Response(hs=0.4, looming_spikes=1), -1.0),
    ("avoidance", Response(hs=-0.4, looming_spikes=1), 1.0),
    ("hybrid", Response(azimuth=-0.4, looming_spikes=1), 1.0),
    ("hybrid", Response(azimuth=0.4, looming_spikes=1), -1.0),
])  # fmt: skip
def test_looming_is_turned_away_from(name, seen, side):
    policy = BEHAVIOURS[name].make(np.random.default_rng())
    ahead = policy(SILENT)
    assert ahead[0] == ahead[1] > 0
    left, right = policy(seen)
    assert left == -right and left * side > 0


def test_a_saccade_lasts_and_looks_away():
    policy = Saccades(lambda seen: 1.0)
    loom = Response(looming_spikes=1)
    turning = [policy(loom)[0] != AHEAD for _ in range(policy.TURN_FRAMES + policy.ECHO_FRAMES)]
    assert turning == [True] * policy.TURN_FRAMES + [False] * policy.ECHO_FRAMES
    assert policy(loom)[0] == -policy(SILENT)[1]  # then at once again


@pytest.mark.parametrize("hold", [True, False])
def test_a_held_side_stays_while_looming_goes_on(hold):
    sides = iter([1.0, -1.0, 1.0, -1.0])
    policy = Saccades(lambda seen: next(sides), hold=hold)
    turns = [policy(Response(looming_spikes=1)) for _ in range(3 * (policy.TURN_FRAMES + policy.ECHO_FRAMES))]
    begun = [math.copysign(1.0, left) for left, right in turns if left == -right][:: policy.TURN_FRAMES]
    assert begun == ([1.0, 1.0, 1.0] if hold else [1.0, -1.0, 1.0])
    for _ in range(policy.HOLD + 1):
        policy(SILENT)
    assert math.copysign(1.0, policy(Response(looming_spikes=1))[0]) == -1.0


def test_a_model_of_one_s_own_drives_one_too():
    behaviour = escape("models/my_model.py")
    assert (behaviour.name, behaviour.model) == ("escape-my_model", "models/my_model.py")
