"""Claims C5, C6 and C7 along the sigmoid scale of the model of 2017, whose own constants are not known.

The paper compares the DSNN with its forerunner and gives none of its constants. With the DSNN's sigmoid scale, 0.01,
the forerunner is at its ceiling in every clip before clutter. Not in the paper.
"""

from experiments import Figure, OfflineExperiment
from experiments.clutter_depth import EXPERIMENT as DEPTH
from experiments.clutter_speed import EXPERIMENT as SPEED

SCALES = ("0.01", "0.1", "1", "3", "10", "30", "100", "1000")
"""K_sig; the first is the DSNN's own, which is assumed elsewhere."""
VARIANTS = tuple(f"dsn2017:k_sig={scale}" for scale in SCALES)

EXPERIMENT = OfflineExperiment(
    name="constants-2017",
    summary="C5, C6 and C7 with the model of 2017 at sigmoid scales over five decades",
    clips=(*DEPTH.clips, *SPEED.clips),
    models=("dsnn", *VARIANTS),
    recorded=False,
    figure=Figure("ranges"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
