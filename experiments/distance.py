"""Systematic translation, distances (the paper's robot-sys-trans b): 6 cm/s at 5, 10 and 15 cm."""

from experiments import Experiment, Translation

EXPERIMENT = Experiment(
    name="distance",
    summary="a black Colias crosses at 6 cm/s, at 5, 10 and 15 cm",
    design=Translation(speeds_cm_s=(6,), distances_cm=(5, 10, 15)),
    varies="distance_cm",
    claims=("C16",),
)

if __name__ == "__main__":
    EXPERIMENT.main()
