"""Crossings before walls from plain to four times the arena's contrast. Not in the paper."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Clutter, Experiment

EXPERIMENT = Experiment(
    name="clutter",
    summary="crossings before walls from plain to strong clutter",
    design=Clutter(),
    varies="wall_contrast",
    repeats=10,
    claims=(),
)
