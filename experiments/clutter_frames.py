"""The clips before clutter with every speed taken as px per frame, as the paper writes them: C5 to C11, C24, C26, C27.

At 30 frames a second that is 30 times as fast: beyond any correlator's span.
"""

from dataclasses import replace

from experiments import Clip, Figure, OfflineExperiment
from experiments.background_alone import EXPERIMENT as ALONE
from experiments.clutter_contrast import EXPERIMENT as CONTRAST
from experiments.clutter_depth import EXPERIMENT as DEPTH
from experiments.clutter_speed import EXPERIMENT as SPEED
from experiments.clutter_translation import EXPERIMENT as TRANSLATION

OF = (DEPTH, TRANSLATION, SPEED, CONTRAST, ALONE)
"""The experiments whose clips these are; their claims are judged under this reading too."""


def prefix(experiment: OfflineExperiment) -> str:
    """Return what the names of the clips of an experiment begin with here."""
    return f"{experiment.name}: "


def _per_frame(experiment: OfflineExperiment, clip: Clip) -> Clip:
    return replace(clip, name=prefix(experiment) + clip.name, changes=dict(clip.changes) | {"speed_unit": "px/frame"})


EXPERIMENT = OfflineExperiment(
    name="clutter-frames",
    summary="the clips before clutter with speeds read as px per frame, as the paper writes them, and not as px/s",
    clips=tuple(_per_frame(experiment, clip) for experiment in OF for clip in experiment.clips),
    models=("dsnn", "dsn2017", "emd", "dsnn:n_con=1", "dsnn:n_con=2", "dsnn:dog=false", "dsnn:fdsr=false"),
    repeats=2,
    figure=Figure("ranges"),
    recorded=False,
)

if __name__ == "__main__":
    EXPERIMENT.main()
