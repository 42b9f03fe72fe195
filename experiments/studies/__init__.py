"""The studies that ship, one file each: what is varied, which claims and measures, how many replicates.

A new study that ships is a file here that defines ``STUDY``, and its name in `NAMES`. A fit defines ``FIT``, and its
name is in `FITS`.
"""

NAMES = (
    "fidelity",
    "eye-range",
    "fitted-feedback",
    "detectors",
    "onboard",
    "sensitivity",
    "sensitivity-clips",
    "background",
    "constants-2017",
    "constants-emd",
)
"""The studies, without ``model-claims``, whose claims are each about a model of its own."""

FITS = ("fit-eye", "fit-ideal", "fit-clips")
"""The fits: claims, and a box of what the paper and the data sheets leave open."""
