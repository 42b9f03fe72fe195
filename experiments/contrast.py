"""Crossings by shells from black to white, before the same wall. Not in the paper."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Contrast, Experiment

EXPERIMENT = Experiment(
    name="contrast",
    summary="crossings by shells from black to white",
    design=Contrast(),
    varies="shell_grey",
    repeats=10,
    claims=(),
)
