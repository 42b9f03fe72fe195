"""Claims C5 to C11 along the speed of the background, from 0.07 to 10 px a frame. Not in the paper.

The paper's tests shift the background at up to 10 px/s as they are read here: a third of a pixel a frame.
"""

from experiments import Clip, Figure, OfflineExperiment
from experiments.clutter_contrast import GREYS
from experiments.clutter_contrast import SPEEDS as OBJECT_SPEEDS
from experiments.clutter_depth import GREYS as EXTREME

SPEEDS = (2.0, 8.0, 15.0, 30.0, 60.0, 150.0, 300.0)
"""Speeds of the background, px/s: 0.07 to 10 px a frame at 30 frames per second."""

DEPTH = tuple(
    Clip(
        f"{shade} {motion} before {behind:g}",
        "cluttered",
        (("motion", motion), ("grey", grey), ("background_speed", behind)),
    )
    for behind in SPEEDS
    for shade, grey in EXTREME.items()
    for motion in ("looming", "receding")
)
TRANSLATION = tuple(
    Clip(
        f"grey {grey:g} at {speed:g} before {-behind:g}",
        "cluttered",
        (("grey", grey), ("speed", speed), ("background_speed", -behind)),
    )
    for behind in SPEEDS
    for grey in GREYS
    for speed in OBJECT_SPEEDS
)
ALONE = tuple(
    Clip(f"alone at {-behind:g}", "cluttered", (("object", "absent"), ("speed", 40.0), ("background_speed", -behind)))
    for behind in SPEEDS
)

EXPERIMENT = OfflineExperiment(
    name="background",
    summary="objects before a natural image shifting at 0.07 .. 10 px a frame: where C5 to C11 break",
    clips=(*DEPTH, *TRANSLATION, *ALONE),
    models=("dsnn", "dsn2017", "emd"),
    recorded=False,
    figure=Figure("background"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
