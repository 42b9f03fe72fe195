"""One of each motion (the paper's robot-general-tests): straight approach and recession, a crossing each way."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Experiment, General

EXPERIMENT = Experiment(
    name="general",
    summary="straight approach and recession, a crossing each way",
    design=General(),
    varies="motion",
    repeats=10,
    claims=("C13", "C14"),
)
