"""Reasons why the count goes with the angle of approach as it does (C13, C17, C18): excitation, inhibition and their
residue.

The trials equal `angular-approach`'s at the same seed. The models are the DSNN, the DSNN with w_i = 1, and its two
pathways, each alone, with w_i = 0 and 1: excitation and inhibition follow from these.
"""

from experiments import Angular, Experiment

MODELS = (
    "dsnn", "dsnn:w_i=1", "dsnn-off-blocked:w_i=0", "dsnn-on-blocked:w_i=0", "dsnn-off-blocked:w_i=1",
    "dsnn-on-blocked:w_i=1",
)  # fmt: skip

EXPERIMENT = Experiment(
    name="approach-mechanism",
    summary="excitation and inhibition in the trials of angular-approach, and what w_i leaves of symmetric motion",
    design=Angular("approach"),
    varies="angle_deg",
    models=MODELS,
    figure="excitation",
)

if __name__ == "__main__":
    EXPERIMENT.main()
