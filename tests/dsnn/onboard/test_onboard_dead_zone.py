"""Delays too long for the codes of D: where a signal stands still, held against D followed frame by frame."""

import dataclasses

import numpy as np
import pytest

from dsnn.filters import alpha
from dsnn.onboard.codes import coded, decoded
from dsnn.onboard.dead_zone import SMALL, dead_zone, longest_delay
from dsnn.onboard.numpy_form import rounded
from dsnn.onboard.params import OnboardParams

FORMATS = {
    "companded": {},
    "companded, truncated": {"rounding": "truncate"},
    "linear": {"companding": False},
    "linear, truncated": {"companding": False, "rounding": "truncate"},
    "16 bits": {"state_bits": 16},
    "16 bits, truncated": {"state_bits": 16, "rounding": "truncate"},
}


def network(tau_s: float, **changes) -> OnboardParams:
    return dataclasses.replace(OnboardParams.robot(), tau_s=(10.0, tau_s), **changes)


def followed(params: OnboardParams, delayed: int, field: int) -> int:
    """D after F has been the same for so long that D no longer changes; both in units of F."""
    gain = int(alpha(max(params.delays()), params.dt) * 32768.0 + 0.5)
    truncate = params.rounding == "truncate"
    while True:
        exact = np.array([(delayed << 15) + gain * (field - delayed)])
        if params.state_bits == 16:
            now = int(rounded(exact, 15, truncate)[0])
        else:
            now = int(decoded(coded(exact, params.companding, truncate), params.companding)[0])
        if now == delayed:
            return delayed
        delayed = now


def top(params: OnboardParams) -> int:
    return 32767 if params.state_bits == 16 else int(decoded(np.array([255]), params.companding)[0])


@pytest.mark.parametrize("tau", [50.0, 200.0, 2100.0, 2200.0, 3000.0, 10_000.0])
@pytest.mark.parametrize("changes", FORMATS.values(), ids=FORMATS)
def test_d_stands_still_where_it_is_said_to(changes, tau):
    """From the top it falls as far as the largest value that stands still; it rises from 0 for a larger F alone."""
    params = network(tau, **changes)
    (falling, rising), most = dead_zone(params), top(params)
    assert followed(params, most, 0) == round(falling * most)
    still = round(rising * most)
    assert followed(params, 0, still) == 0
    assert still == most or followed(params, 0, still + 1) > 0


@pytest.mark.parametrize("changes", FORMATS.values(), ids=FORMATS)
@pytest.mark.parametrize("fps", [30.0, 200.0])
def test_the_longest_delay_is_the_last_without_a_dead_zone(changes, fps):
    longest = longest_delay(network(200.0, fps=fps, **changes))
    for tau, matters in ((longest - 0.01, False), (longest * 1.001 + 0.01, True)):
        if tau <= 10_000.0:
            assert (max(dead_zone(network(tau, fps=fps, **changes))) > SMALL) == matters
