"""Reasons why the count goes with the angle of recession as it does (C13, C19, C20): excitation, inhibition and their
residue.

The trials are those of `angular-recession` at the same seed, frame by frame. Beside the DSNN they are shown to it with
w_i = 1, and to its two pathways, each alone, with w_i = 0 and 1: excitation and inhibition follow from these.
"""

from experiments import Angular, Experiment

EXPERIMENT = Experiment(
    name="recession-mechanism",
    summary="excitation and inhibition in the trials of angular-recession, and what w_i leaves of symmetric motion",
    design=Angular("recession"),
    varies="angle_deg",
    repeats=10,
    models=(
        "dsnn",
        "dsnn:w_i=1",
        "dsnn-off-blocked:w_i=0",
        "dsnn-on-blocked:w_i=0",
        "dsnn-off-blocked:w_i=1",
        "dsnn-on-blocked:w_i=1",
    ),
    figure="excitation",
)

if __name__ == "__main__":
    EXPERIMENT.main()
