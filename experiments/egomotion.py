"""Crossings while the observer itself turns or drives. Not in the paper."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Egomotion, Experiment

EXPERIMENT = Experiment(
    name="egomotion",
    summary="crossings while the observer turns or drives",
    design=Egomotion(),
    varies="observer_turn_deg_s",
    repeats=10,
    claims=(),
)
