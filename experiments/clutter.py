"""Crossings before walls from plain to four times the arena's contrast. Not in the paper."""

from experiments.bench.declaration import Experiment
from experiments.bench.designs import Clutter

EXPERIMENT = Experiment(
    name="clutter",
    summary="crossings before walls from plain to strong clutter",
    design=Clutter(),
    varies="wall_contrast",
    repeats=10,
    claims=(),
)

if __name__ == "__main__":
    from experiments.bench.cli import run_file

    run_file(__file__)
