"""What the background alone shows."""

import numpy as np

from dsnn import DSNN, DSNNParams
from dsnn.stimuli import stimulus


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
