"""Crossings by shells from black to white, before the same wall. Not in the paper."""

from experiments.bench.declaration import Experiment
from experiments.bench.designs import Contrast

EXPERIMENT = Experiment(
    name="contrast",
    summary="crossings by shells from black to white",
    design=Contrast(),
    varies="shell_grey",
    repeats=10,
    claims=(),
)

if __name__ == "__main__":
    from experiments.bench.cli import run_file

    run_file(__file__)
