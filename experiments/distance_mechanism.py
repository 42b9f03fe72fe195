"""Reasons why the count falls with distance: count, time in view, firing rate and potential at 6 cm/s, 5 to 15 cm.

The paper's distances are 5, 10 and 15 cm; 6, 8 and 12 cm fill in."""

from experiments import Experiment, Translation

EXPERIMENT = Experiment(
    name="distance-mechanism",
    summary="crossings at 6 cm/s, 5 to 15 cm away: count, time in view, firing rate, potential",
    design=Translation(speeds_cm_s=(6,), distances_cm=(5, 6, 8, 10, 12, 15)),
    varies="distance_cm",
    figure="mechanism",
)

if __name__ == "__main__":
    EXPERIMENT.main()
