"""One of each motion (the paper's robot-general-tests): straight approach and recession, a crossing each way."""

from experiments import Experiment, General

EXPERIMENT = Experiment(
    name="general",
    summary="straight approach and recession, a crossing each way",
    design=General(),
    varies="motion",
    claims=("C13", "C14", "C32"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
