"""Rightward translation before a natural image that shifts left (the paper's simu-nature-trans)."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

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
