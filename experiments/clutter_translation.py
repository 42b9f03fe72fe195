"""Rightward translation before a natural image that shifts left (the paper's simu-nature-trans)."""

from experiments import Clip, OfflineExperiment
from experiments.clutter_depth import GREYS

EXPERIMENT = OfflineExperiment(
    name="clutter-translation",
    summary="dark and light objects cross before a natural image shifting at -8 px/s",
    clips=tuple(
        Clip(f"{shade} rightward", "cluttered", (("grey", grey), ("background_speed", -8.0)))
        for shade, grey in GREYS.items()
    ),
    models=("dsnn", "dsn2017", "dsn2017:k_sig=33.22"),  # the last with its gain matched
    claims=("C6",),
    repeats=5,
)

if __name__ == "__main__":
    EXPERIMENT.main()
