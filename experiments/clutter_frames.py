"""The speeds of clutter-speed taken as px per frame, as the paper writes them: beyond any correlator's span."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Clip, Figure, OfflineExperiment
from experiments.clutter_depth import GREYS
from experiments.clutter_speed import BACKGROUNDS, SPEEDS

EXPERIMENT = OfflineExperiment(
    name="clutter-frames",
    summary="the same speeds read as px per frame, as the paper writes them, and not as the px/s that its claims need",
    clips=tuple(
        Clip(
            f"{shade} {speed:g} before {behind:g} px/frame",
            "cluttered",
            (("grey", grey), ("speed", speed), ("background_speed", behind), ("speed_unit", "px/frame")),
        )
        for shade, grey in GREYS.items()
        for behind in BACKGROUNDS
        for speed in SPEEDS
    ),
    models=("dsnn", "dsn2017"),  # C6 and C8 are judged of them under this reading too
    repeats=2,
    figure=Figure("peaks", along="speed", lines="background_speed", panels="grey"),
    recorded=False,
)
