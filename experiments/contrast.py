"""Crossings by shells from black to white, before the same wall. Not in the paper."""

from experiments import Contrast, Experiment

EXPERIMENT = Experiment(
    name="contrast",
    summary="crossings by shells from black to white",
    design=Contrast(),
    varies="shell_grey",
)

if __name__ == "__main__":
    EXPERIMENT.main()
