"""One edge in view, with the ON or the OFF pathway blocked: which edge drives which (the paper's simu-clean-dth).

The leading edge of a dark object darkens what it passes, as the trailing edge of a light one does: an OFF edge. The
trailing edge of a dark object and the leading edge of a light one brighten it: an ON edge.
"""

from experiments import Clip, Figure, OfflineExperiment

SPEEDS = (60.0, 120.0)
EDGES = {"off": "OFF (dark leads)", "on": "ON (dark trails)"}
"""An edge's polarity -> what the edge is of a dark object."""

EXPERIMENT = OfflineExperiment(
    name="edges",
    summary="one edge in view, ON or OFF, with either pathway blocked",
    clips=tuple(
        Clip(f"{label} {motion} {speed:g}", "edge", (("polarity", polarity), ("motion", motion), ("speed", speed)))
        for polarity, label in EDGES.items()
        for motion in ("rightward", "leftward")
        for speed in SPEEDS
    ),
    models=("dsnn", "dsnn-on-blocked", "dsnn-off-blocked"),
    claims=("C22",),
    figure=Figure("edges"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
