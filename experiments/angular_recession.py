"""Recessions at five angles (the paper's robot-sys-ar): the lines of the approaches, the other way."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Angular, Experiment

EXPERIMENT = Experiment(
    name="angular-recession",
    summary="the lines of the approaches, the other way",
    design=Angular("recession"),
    varies="angle_deg",
    repeats=10,
    claims=("C13", "C19", "C20"),
)
