"""Approaches at five angles (the paper's robot-sys-ar): from 20 cm to 5 cm before the camera."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Angular, Experiment

EXPERIMENT = Experiment(
    name="angular-approach",
    summary="from 20 cm to 5 cm before the camera, at five angles",
    design=Angular("approach"),
    varies="angle_deg",
    repeats=10,
    claims=("C13", "C17", "C18", "C21"),
)
