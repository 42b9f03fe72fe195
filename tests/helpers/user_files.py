"""A model and an experiment of a user's own, as files."""

from experiments.base.templates import render

MODEL = render("cli/new/model.py.j2", name="gradient", stem="my_model") + "\n"
"""What ``colias new model`` writes, under another name than its file's."""
EXPERIMENT = """
from experiments import Experiment, Translation

EXPERIMENT = Experiment(
    name="my_experiment",
    summary="fast crossings, close by",
    design=Translation(speeds_cm_s=(15, 25), distances_cm=(6,)),
    varies="speed_cm_s",
    repeats=5,
)
"""
FILES = {"my_model.py": MODEL, "my_experiment.py": EXPERIMENT}
