"""Three object speeds at five background speeds, dark and light (the paper's simu-sys-speed)."""

from experiments import Clip, Figure, OfflineExperiment
from experiments.clutter_depth import GREYS

SPEEDS, BACKGROUNDS = (40.0, 80.0, 120.0), (-2.0, -4.0, -6.0, -8.0, -10.0)

EXPERIMENT = OfflineExperiment(
    name="clutter-speed",
    summary="crossings at 40, 80, 120 px/s before a natural image shifting at -2 .. -10 px/s",
    clips=tuple(
        Clip(
            f"{shade} {speed:g} before {behind:g}",
            "cluttered",
            (("grey", grey), ("speed", speed), ("background_speed", behind)),
        )
        for shade, grey in GREYS.items()
        for behind in BACKGROUNDS
        for speed in SPEEDS
    ),
    models=("dsnn", "dsn2017", "dsn2017:k_sig=33.22"),  # the last with its gain matched
    claims=("C7", "C8"),
    repeats=2,
    recorded=False,
    figure=Figure("peaks", along="speed", lines="background_speed", panels="grey"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
