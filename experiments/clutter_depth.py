"""Looming and receding before a natural image that shifts right (the paper's simu-nature-depth)."""

if __name__ == "__main__":  # before the imports: Ctrl-C is seen to first, and nothing is imported twice
    from experiments.bench.cli.entry import run_file

    run_file(__file__)

from experiments import Clip, OfflineExperiment

GREYS = {"dark": 0.0, "light": 255.0}
"""Darker and lighter than anything of the photograph."""

EXPERIMENT = OfflineExperiment(
    name="clutter-depth",
    summary="dark and light objects loom and recede before a natural image shifting at +8 px/s",
    clips=tuple(
        Clip(f"{shade} {motion}", "cluttered", (("motion", motion), ("grey", grey), ("background_speed", 8.0)))
        for shade, grey in GREYS.items()
        for motion in ("looming", "receding")
    ),
    models=("dsnn", "dsn2017", "dsn2017:k_sig=33.22"),  # the last with its gain matched
    claims=("C5",),
    repeats=5,
)
