"""The region in which C13 to C20 are kept together under the ideal eye: its size, and the claim that bounds it."""

from experiments import Fit, Study
from experiments.studies.fit_eye import CLAIMS, NETWORK, WHOLE

FIT = Fit(
    Study(
        name="fit-ideal",
        summary="C13 to C20 together under the default camera, over what the paper leaves open of the network",
        claims=CLAIMS,
        experiments=WHOLE,
        replicates=1,
        every_trial=False,
    ),
    over=NETWORK,
    trials=200,
    share=20,
    sample=128,
)
