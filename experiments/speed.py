"""Systematic translation, speeds (the paper's robot-sys-trans a): 8 cm away at 2, 4, 6 and 10 cm/s."""

from experiments import Experiment, Translation

EXPERIMENT = Experiment(
    name="speed",
    summary="a black Colias crosses at 8 cm, at 2, 4, 6 and 10 cm/s",
    design=Translation(speeds_cm_s=(2, 4, 6, 10), distances_cm=(8,)),
    varies="speed_cm_s",
    claims=("C15", "C29"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
