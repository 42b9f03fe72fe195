"""The paper's experiments, one declaration a file, and in `experiments.bench` the machinery they share.

A new experiment is a file here that defines ``EXPERIMENT``, and its name in `NAMES`.
"""

NAMES = ("speed", "distance")
