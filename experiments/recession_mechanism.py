"""Reasons why the count goes with the angle of recession as it does (C13, C19, C20): excitation, inhibition and their
residue.

The trials are those of `angular-recession` at the same seed, the models those of `approach-mechanism`.
"""

from experiments import Angular, Experiment
from experiments.approach_mechanism import MODELS

EXPERIMENT = Experiment(
    name="recession-mechanism",
    summary="excitation and inhibition in the trials of angular-recession, and what w_i leaves of symmetric motion",
    design=Angular("recession"),
    varies="angle_deg",
    models=MODELS,
    figure="excitation",
)

if __name__ == "__main__":
    EXPERIMENT.main()
