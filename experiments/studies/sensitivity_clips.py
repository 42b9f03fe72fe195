"""Sensitivity of the claims about clips to each parameter of the network, moved by itself.

The models that the claims compare the DSNN with stay as they are; the DSNN with a blocked pathway, and its other
variants, move with it. `K_sp` changes counts of spikes alone, which no claim about clips reads.
"""

from experiments import Axis, Level, Study
from experiments.studies.sensitivity import DEFAULTS, NETWORK, READINGS

SPIKING = ("k_sp", "t_sp")
MOVES = {
    **{name: text for name, text in NETWORK.items() if text.partition("=")[0] not in SPIKING},
    "T_sp = 0.2": "t_sp=0.2",  # the default of off-line tests is the other end of the paper's range
    **READINGS,
}

STUDY = Study(
    name="sensitivity-clips",
    summary="C1 to C11, C22 to C24 and C26 to C28 on clips, with one thing of the network moved at a time",
    claims=(*(f"C{number}" for number in range(1, 12)), "C22", "C23", "C24", "C26", "C27", "C28"),
    experiments=(
        "clean", "blocked", "clutter-depth", "clutter-translation", "clutter-speed", "clutter-contrast", "street",
        "edges", "apparent", "background-alone",
    ),
    axes=(
        Axis(
            "moved",
            (
                Level(DEFAULTS),
                *(Level(name, (f"dsnn.{text}",)) for name, text in MOVES.items()),
            ),
        ),
    ),
    replicates=1,
)  # fmt: skip
