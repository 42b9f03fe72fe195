"""What single looming detectors are known for, as their papers publish it."""

import math

import numpy as np
import pytest

from dsnn import LGMD2, LPLC2, LPLC2GF, MLPLC2, LPLC2GFParams
from dsnn.stimuli import stimulus
from tests.dsnn.clips import SHAPE, approach


def test_collision_after_enough_spikes():
    """In the approach it is announced near its end, and a reset takes it back."""
    model, count, seen = LGMD2(SHAPE), 0, []
    for frame in approach():
        spikes = model.step(frame).looming_spikes
        count = count + spikes if spikes else 0
        seen.append(model.collision)
        assert model.collision == (count >= 8)
    assert not any(seen[:50]) and any(seen[50:])
    model.reset()
    assert not model.collision


def published_square(l_over_v_s, frames=100):
    """The looming of Zhao and others: 100 wide, drawn 240 px from the eye on 800x600, each fourth pixel."""
    nearest = min(round(50 * 240 / 300), round(50 * 240 / 400))
    speed = 50 / l_over_v_s
    for index in range(1, frames + 1):
        side = 100 * 240 / (nearest + speed - round(index * speed / 100))
        screen = np.full((600, 800), 255, np.uint8)
        top, left = (max(round(half - side / 2), 1) - 1 for half in (300, 400))
        screen[top : round(300 + side / 2), left : round(400 + side / 2)] = 0
        yield np.ascontiguousarray(screen[::4, ::4])


def test_active_cells_are_those_that_the_giant_fibre_s_authors_count():
    """676 and 2116 in the last two frames at l / v = 5 ms, squares of 26 and 46; a corner less than pixels a side."""
    model = LPLC2GF((150, 200), LPLC2GFParams())
    counts = [model.active_cells(frame) for frame in published_square(0.005)]
    assert [math.isqrt(n) for n in counts[-2:]] == [26 - 1, 46 - 1]
    assert counts[-2:] == [25**2, 45**2] and counts[0] == 0


def test_a_larger_receptive_field_fires_at_a_larger_square():
    """The paper's finding: the size of the receptive field sets the size at which the giant fibre fires."""
    sizes = []
    for side in (40, 80):
        model = LPLC2GF((150, 200), LPLC2GFParams(side=side))
        clip = stimulus("looming", rows=150, columns=200, fps=100, focal_px=60.0, l_over_v_s=0.05, end_deg=90.0)
        spikes = model.run(frame.luma for frame in clip).looming_spikes
        sizes.append(clip[int(spikes.nonzero()[0][0])].truth.box.width)
    assert sizes == sorted(set(sizes))


def test_the_membrane_is_a_leaky_integrator():
    """At a steady current below threshold it settles at rest plus R I, by its time constant."""
    model = LPLC2GF((8, 8), LPLC2GFParams())
    for _ in range(30):
        assert model._integrate(0.5) == 0
    assert model._v == pytest.approx(-60 + 5 * (1 - math.exp(-1)), abs=1e-9)
    assert model._integrate(1e4) > 0


@pytest.mark.parametrize("model", [LPLC2, MLPLC2])
def test_an_lplc2_needs_motion_outward_in_all_four_quadrants(model):
    """A dark square whose lower left corner stays where it is: no motion outward in the lower left."""
    whole, part = np.full((2, 30, 72, 99), 200, np.uint8)
    for i in range(30):
        whole[i, 36 - i : 36 + i, 49 - i : 50 + i] = 40
        part[i, 30 - i : 30, 56 : 57 + i] = 40
    looming, corner = (model((72, 99)).run(clip).looming.max() - 0.5 for clip in (whole, part))
    assert looming > 0.1 and corner < looming / 10
