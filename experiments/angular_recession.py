"""Recessions at five angles (the paper's robot-sys-ar): the lines of the approaches, the other way."""

from experiments.bench.declaration import Experiment
from experiments.bench.designs import Angular

EXPERIMENT = Experiment(
    name="angular-recession",
    summary="the lines of the approaches, the other way",
    design=Angular("recession"),
    varies="angle_deg",
    repeats=10,
    claims=("C13", "C19", "C20"),
)

if __name__ == "__main__":
    from experiments.bench.cli import run_file

    run_file(__file__)
