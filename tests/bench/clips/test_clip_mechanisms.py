"""What edges, pairs of steps and the background alone show, and their experiments from the command line."""

import numpy as np
import pytest

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import stimulus

DIRECTIONS = ("rightward", "leftward")


@pytest.mark.parametrize("motion", DIRECTIONS)
@pytest.mark.parametrize("w_i", [0.9, 1.0])
def test_a_pathway_never_mixes_signs(motion, w_i):
    """Steps of opposite signs answer as their flashes do, alike in both directions; with w_i = 1 not at all."""
    same, opposite = (
        DSNN((60, 120), DSNNParams.offline(w_i=w_i)).run(
            frame.luma for frame in stimulus("apparent", motion=motion, polarity=polarity, rows=60, columns=120)
        )
        for polarity in ("on-on", "on-off")
    )
    sign = 1 if motion == "rightward" else -1
    assert (sign * same.hs).max() > 0.1
    flashes = 0.35 if w_i < 1 else 0.03
    assert np.abs(opposite.hs).max() < flashes * (sign * same.hs).max()
    assert (opposite.hs.max() > 0.02) == (w_i < 1)


def test_fdsr_prefers_objects_to_background_and_the_dog_does_not():
    """What the documentation says of C27: the share of an object's HS to that of the background alone.

    With a sigmoid so wide that potentials stay linear, and from when the background's start has died away.
    """

    def strongest_hs(present, **switches):
        field = {"rows": 60, "columns": 160, "height": 40.0, "grey": 255.0, "object": present}
        clip = stimulus("cluttered", background_speed=-30.0, **field)
        answer = DSNN(clip.shape, DSNNParams.offline(k_sig=1000.0, **switches)).run(frame.luma for frame in clip)
        return np.abs(answer.hs[12:]).max() if present == "absent" else answer.hs[12:].max()

    share = {
        switch: strongest_hs("present", **changes) / strongest_hs("absent", **changes)
        for switch, changes in {"intact": {}, "dog": {"dog": False}, "fdsr": {"fdsr": False}}.items()
    }
    assert share["dog"] > 1.5 * share["intact"], "without the DoG an object stands out more"
    assert share["fdsr"] < share["intact"] / 1.5, "without FDSR less"
