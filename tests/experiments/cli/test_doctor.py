"""What ``colias doctor`` finds on healthy and on broken machines, and the reference frame."""

import importlib.metadata

import cv2
import numpy as np

from colias_sim import GLUnavailable, reference
from experiments.cli import doctor


def found():
    return {name: (state, message) for state, name, message in doctor.examine()}


def test_a_healthy_machine_misses_nothing():
    findings = found()
    assert {"python", "packages", "renderer", "reference frame", "network"} <= set(findings)
    assert "missing" not in {state for state, _ in findings.values()}


def test_what_cannot_draw_is_missing_and_the_others_still_answer(monkeypatch):
    def broken():
        raise GLUnavailable("no OpenGL library for egl loads")

    monkeypatch.setattr(reference, "reference_hash", broken)
    findings = found()
    assert findings["renderer"] == ("missing", "no OpenGL library for egl loads")
    assert findings["network"][0] == "ok" and "reference frame" not in findings


def test_packages_outside_their_ranges_are_missing_and_those_of_extras_optional(monkeypatch):
    declared = ["numpy", "packaging<1", "nosuch; extra == 'train'", "absent; python_version < '3'"]
    monkeypatch.setattr(importlib.metadata, "requires", lambda _: declared)
    state, message = found()["packages"]
    assert state == "missing" and "packaging<1" in message and "numpy" not in message and "absent" not in message
    states = {name: (state, "nosuch" in message) for state, name, message in doctor.packages()}
    assert states["extra [train]"] == ("optional", True) and not states["extra [fit]"][1]


def test_the_reference_frame_is_the_one_that_is_kept():
    """Equal pixels wherever they were compared; another renderer may round some otherwise, and draws the same scene."""
    kept = cv2.imread(reference.__file__.replace(".py", ".png"), cv2.IMREAD_COLOR_RGB)
    assert reference.digest(kept) == next(iter(reference.KNOWN))
    drawn = reference.reference_frame()
    assert drawn.shape == (72, 99, 3) and np.array_equal(drawn, reference.reference_frame())
    assert np.abs(drawn.astype(int) - kept).mean() < 2.0
