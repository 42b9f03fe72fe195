"""Apparent motion in two strokes, of one sign and of opposite signs (the paper's motion-models).

Beside the DSNN are shown the DSNN with w_i = 1, whose answers to a single step cancel, and EMDs of the same spacing,
which correlate steps of either sign and answer opposite signs the other way: a four-quadrant detector.
"""

from experiments import Clip, OfflineExperiment

POLARITIES, DELAYS = ("on-on", "off-off", "on-off", "off-on"), (1, 2)

EXPERIMENT = OfflineExperiment(
    name="apparent",
    summary="two bars step one after the other, ON or OFF each",
    clips=tuple(
        Clip(
            f"{polarity} {motion} {delay}",
            "apparent",
            (("polarity", polarity), ("motion", motion), ("delay_frames", delay)),
        )
        for delay in DELAYS
        for polarity in POLARITIES
        for motion in ("rightward", "leftward")
    ),
    models=("dsnn", "dsnn:w_i=1", "emd:spacing=4"),
    claims=("C23",),
)

if __name__ == "__main__":
    EXPERIMENT.main()
