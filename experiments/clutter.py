"""Crossings before walls from plain to four times the arena's contrast. Not in the paper."""

from experiments import Clutter, Experiment

EXPERIMENT = Experiment(
    name="clutter",
    summary="crossings before walls from plain to strong clutter",
    design=Clutter(),
    varies="wall_contrast",
)

if __name__ == "__main__":
    EXPERIMENT.main()
