"""Looming and receding before a natural image that shifts right (the paper's simu-nature-depth)."""

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

if __name__ == "__main__":
    EXPERIMENT.main()
