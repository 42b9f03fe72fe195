"""The paper's experiments and some beyond it, one declaration a file; in `experiments.bench` what they share.

A new experiment is a file here that defines ``EXPERIMENT``, and its name in `NAMES` or `OFFLINE`.
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
"""With the robot."""

OFFLINE = (
    "clean",
    "blocked",
    "clutter-depth",
    "clutter-translation",
    "clutter-speed",
    "clutter-frames",
    "clutter-contrast",
)
"""With clips of stimuli."""
