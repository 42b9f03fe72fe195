"""Crossings at 8 cm at every whole speed from 2 to 10 cm/s: at which the count of spikes is largest.

The paper shows 2, 4, 6 and 10 cm/s, and says that the count peaks around roughly 6.
"""

from experiments import Experiment, Translation

EXPERIMENT = Experiment(
    name="speed-steps",
    summary="a black Colias crosses at 8 cm, at 2 to 10 cm/s in steps of 1",
    design=Translation(speeds_cm_s=(2, 3, 4, 5, 6, 7, 8, 9, 10), distances_cm=(8,)),
    varies="speed_cm_s",
    claims=("C31",),
)

if __name__ == "__main__":
    EXPERIMENT.main()
