"""Are the claims about clips kept together, with the constants of the network free that the paper gives ranges of?

C5, C6, C7 and C11 hang on constants of another model that are not known: no setting of the DSNN decides them.
"""

from experiments import Fit, Study

FIT = Fit(
    Study(
        name="fit-clips",
        summary="C1 to C4 and C8 to C10 together on clips, over the constants of the network",
        claims=("C1", "C2", "C3", "C4", "C8", "C9", "C10"),
        experiments=("clean", "blocked", "clutter-speed", "clutter-contrast"),
        repeats=None,
        replicates=1,
    ),
    over=(
        "dsnn.k_sig=0.001..0.1",
        "dsnn.t_sp=0.05..0.3",
        "dsnn.n_con=4,6,8",
        "dsnn.d=1..4",
        "dsnn.tau_s.first=5..100",
        "dsnn.tau_s.last=100..400",
    ),
    trials=200,
    share=20,
    sample=128,
)
