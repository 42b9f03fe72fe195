"""Recessions at five angles (the paper's robot-sys-ar): the lines of the approaches, the other way."""

from experiments import Angular, Experiment

EXPERIMENT = Experiment(
    name="angular-recession",
    summary="the lines of the approaches, the other way",
    design=Angular("recession"),
    varies="angle_deg",
    claims=("C13", "C19", "C20", "C32"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
