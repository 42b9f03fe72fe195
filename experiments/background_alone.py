"""A natural image shifts, with nothing before it: what the DoG pre-filter and FDSR each take off the potentials."""

from experiments import Clip, Figure, OfflineExperiment
from experiments.clutter_speed import BACKGROUNDS

EXPERIMENT = OfflineExperiment(
    name="background-alone",
    summary="a natural image shifts at -2 .. -10 px/s, without DoG or FDSR",
    clips=tuple(
        Clip(f"alone at {behind:g}", "cluttered", (("object", "absent"), ("background_speed", behind)))
        for behind in BACKGROUNDS
    ),
    models=(
        "dsnn",
        "dsnn:dog=false",
        "dsnn:fdsr=false",
        "dsnn:dog=false,k_sig=0.3056",  # these two with their gain matched
        "dsnn:fdsr=false,k_sig=33.22",
    ),
    claims=("C27",),
    repeats=5,
    figure=Figure("background"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
