"""Approaches at five angles (the paper's robot-sys-ar): from 20 cm to 5 cm before the camera."""

from experiments import Angular, Experiment

EXPERIMENT = Experiment(
    name="angular-approach",
    summary="from 20 cm to 5 cm before the camera, at five angles",
    design=Angular("approach"),
    varies="angle_deg",
    claims=("C13", "C17", "C18", "C21", "C32"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
