"""Translations of ``clean`` with one pathway blocked (the paper's simu-clean-dth, -dtv): what ON and OFF each add."""

from experiments import Clip, OfflineExperiment
from experiments.clean import EXPERIMENT as CLEAN

EXPERIMENT = OfflineExperiment(
    name="blocked",
    summary="translations on an even ground, with the ON or the OFF pathway blocked",
    clips=tuple(Clip(c.name, c.stimulus, c.changes) for c in CLEAN.clips if c.name.split()[1][-4:] == "ward"),
    models=("dsnn", "dsnn-on-blocked", "dsnn-off-blocked"),
    claims=("C4",),
)

if __name__ == "__main__":
    EXPERIMENT.main()
