"""Claims C11 and C26 along the constants of Iida's EMD, which are not known: its delay, its spacing, its high-pass.

The paper compares the DSNN with it and gives none of its constants. Not in the paper.
"""

from experiments import Figure, OfflineExperiment
from experiments.clutter_contrast import EXPERIMENT as CONTRAST

SPACINGS, DELAYS_MS, HIGH_PASSES_MS = (1, 2, 4, 8), (15, 50, 150), (50, 250)
VARIANTS = tuple(
    f"emd:spacing={spacing},tau_lp={delay},tau_hp={high_pass}"
    for high_pass in HIGH_PASSES_MS
    for spacing in SPACINGS
    for delay in DELAYS_MS
)

EXPERIMENT = OfflineExperiment(
    name="constants-emd",
    summary="C11 and C26 with the EMD at 24 choices of spacing, delay and high-pass",
    clips=CONTRAST.clips,
    models=("dsnn", *VARIANTS),
    recorded=False,
    figure=Figure("ranges"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
