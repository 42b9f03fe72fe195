"""A clip for the playground: a dark object crosses before a natural image that shifts left, on 99x72 px."""

from experiments import Clip, OfflineExperiment

CHANGES = (
    ("grey", 0.0), ("rows", 72), ("columns", 99), ("width", 20.0), ("height", 36.0), ("speed", 60.0),
    ("background_speed", -8.0),
)  # fmt: skip

EXPERIMENT = OfflineExperiment(
    name="playground-clutter",
    summary="a dark object crosses before a natural image shifting at -8 px/s, on 99x72 px",
    clips=(Clip("dark rightward", "cluttered", CHANGES),),
    models=("dsnn",),
    repeats=1,
)
