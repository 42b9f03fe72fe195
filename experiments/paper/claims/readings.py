"""The readings of the paper that were taken where it leaves room, with the claims that each was chosen for."""

from collections.abc import Mapping

from experiments.declare.claim import PAPER, claim_ids

DELAYS, UNITS, WINDOW = "tau s rises with spacing", "speeds in px per second", "whole crossing"
"""Readings that are judged on trials of their own. `WINDOW` is the one that no claim was used to choose."""

READINGS: Mapping[str, tuple[str, ...]] = {
    # "in the FDSR mechanism, the delayed signal is subtracted to the original passed one" (Eq. 7) names no
    # rectifier. Taken is F = max(LA - A, 0). With its sign, F is large and negative on the trailing side of
    # every edge; products of two such values are positive, and HS and VS both saturate for motion of any
    # direction.
    "half wave rectified F": ("F not rectified",),
    # A low-pass is a differential equation (Eq. 6); how it is made discrete is not in the text. Taken is
    # backward Euler, alpha = dt / (dt + tau). The exact gain leaves exp(-33) of a rise at 30 frames a second
    # and tau = 1 ms, and the network is silent; backward Euler leaves 1 / 34 of it, which is what F then is.
    "exact lowpass would be silent": ("exact low-pass",),
    # LA is given where both Gaussians have one sign (Eq. 4). Taken is 0 where they differ.
    "la zero where signs differ": ("LA by the centre's sign",),
    # "the delays vary in each directional combination [...] depending on different spacings and obey a linearly
    # decaying function" (Fig. 3, its part c). Taken is rising, 10 to 200 ms; read plainly, the words make the
    # delay fall. Under that the claim is judged on ensembles, whose trials at the paper's four speeds are of
    # the same design.
    DELAYS: ("falling with spacing, 200 to 10 ms",),
    # "40, 80, 120 (pixels per frame)", "Vb = -8 (pixels per frame)" (Fig. 9, Fig. 10). Taken is px per second:
    # at 120 px a frame an object is across the image within 5 frames, and farther in one than the widest pair
    # of detectors spans.
    UNITS: ("pixels per frame",),
    # Nothing says how approaching and receding trials set off and stop. Taken is 17 cm/s2: sharp starts make
    # straight recession fire, which C13 forbids, and soft ones silence recession at 15 degrees, which C19 wants
    # to fire.
    "start acceleration": ("sudden starts, 100 cm/s2", "soft starts, 10 cm/s2"),
    # "K_sp", "1 ~ 3" (tableParams). Taken is 1 on the robot, 2 off-line. It scales how many spikes a frame has.
    "k sp of one on the robot": ("K_sp = 2", "K_sp = 3"),
    # "We accumulated the elicited spikes of the HS system during each translation process [...], which were all
    # with a nearly identical translating time window" (Fig. 16). Taken is the whole crossing; C29 says the same
    # of one window.
    WINDOW: ("spikes in one time window for all speeds",),
}
"""Reading taken -> the others, in the order in which the report tells them."""

CHOSEN_FOR: Mapping[str, tuple[str, ...]] = {
    DELAYS: ("C15",),
    UNITS: ("C5", "C6", "C7", "C8", "C9", "C10", "C11", "C24", "C26", "C27"),
    "start acceleration": ("C13", "C19"),
    "k sp of one on the robot": ("C15", "C16", "C17", "C19", "C20", "C29"),
    WINDOW: ("C15",),
}
"""Reading -> ids of the claims that it was chosen for; the others were chosen for all claims together."""


def bears_on(reading: str) -> tuple[str, ...]:
    """Return the ids of the claims that a reading was chosen for."""
    return CHOSEN_FOR.get(reading) or claim_ids(PAPER)


def used_to_choose(claim: str) -> tuple[str, ...]:
    """Return the readings that were chosen because a claim favoured them, those chosen for all claims too."""
    return tuple(reading for reading in READINGS if reading != WINDOW and claim in bears_on(reading))
