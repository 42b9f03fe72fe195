"""What ``colias doctor`` finds on healthy and on broken machines, and the reference frame."""

import cv2
import numpy as np

from colias_sim import reference
from experiments.cli import doctor


def found():
    return {name: (state, message) for state, name, message in doctor.examine()}


def test_a_healthy_machine_misses_nothing():
    findings = found()
    assert {"python", "packages", "renderer", "reference frame", "network"} <= set(findings)
    assert "missing" not in {state for state, _ in findings.values()}


def test_the_reference_frame_is_the_one_that_is_kept():
    """Equal pixels wherever they were compared; another renderer may round some otherwise, and draws the same scene."""
    kept = cv2.imread(reference.__file__.replace(".py", ".png"), cv2.IMREAD_COLOR_RGB)
    assert reference.digest(kept) == next(iter(reference.KNOWN))
    drawn = reference.reference_frame()
    assert drawn.shape == (72, 99, 3) and np.array_equal(drawn, reference.reference_frame())
    assert np.abs(drawn.astype(int) - kept).mean() < 2.0
