"""The studies and fits that ship: what is varied, which claims and measures, how many replicates.

A new one is a `experiments.Study` or `experiments.Fit` in a file here, and a line of `STUDIES` or `FITS`.
"""

STUDIES = {
    "fidelity": "robot.FIDELITY",
    "eye-range": "robot.EYE_RANGE",
    "fitted-feedback": "robot.FITTED_FEEDBACK",
    "detectors": "detectors.STUDY",
    "onboard": "onboard.STUDY",
    "sensitivity": "robot.SENSITIVITY",
    "sensitivity-clips": "clips.SENSITIVITY",
    "background": "clips.BACKGROUND",
    "constants-2017": "clips.CONSTANTS_2017",
    "constants-emd": "clips.CONSTANTS_EMD",
}
"""Study -> the file here, and its name there. Missing is ``model-claims``, whose claims are each about a model."""

FITS = {"fit-eye": "robot.FIT_EYE", "fit-ideal": "robot.FIT_IDEAL", "fit-clips": "clips.FIT"}
"""Fit -> the file here, and its name there: claims, and a box of what the paper and the data sheets leave open."""
