"""The paper's experiments and some beyond it, one declaration a file; in `experiments.bench` what they share.

A new experiment is a file here that defines ``EXPERIMENT``, and its name in `NAMES`.
"""

NAMES = (
    "general",
    "speed",
    "distance",
    "angular-approach",
    "angular-recession",
    "contrast",
    "clutter",
    "egomotion",
)
