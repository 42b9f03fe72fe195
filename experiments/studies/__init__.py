"""The studies that ship, one file each: what is varied, which claims and measures, how many replicates.

A new study that ships is a file here that defines ``STUDY``, and its name in `NAMES`.
"""

NAMES = (
    "fidelity",
    "eye-range",
    "detectors",
    "onboard",
    "sensitivity",
    "sensitivity-clips",
    "background",
    "constants-2017",
    "constants-emd",
)
"""The studies, without ``model-claims``, whose claims are each about a model of its own."""
