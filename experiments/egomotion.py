"""Crossings while the observer itself turns or drives. Not in the paper."""

from experiments import Egomotion, Experiment

EXPERIMENT = Experiment(
    name="egomotion",
    summary="crossings while the observer turns or drives",
    design=Egomotion(),
    varies="observer_turn_deg_s",
)

if __name__ == "__main__":
    EXPERIMENT.main()
