"""Search for a setting that keeps the claims about clips together, over the network's constants and the frame rate.

C5, C6, C7 and C11 hang on constants of another model that are not known: no setting of the DSNN decides them.
The paper gives the speeds of its clips in px and does not say whether per second or per frame. The clips' frame rate is
free for that, while the network keeps its own: at 7.5 frames/s an object shifts by 4 times as many px a frame as at 30.
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
        "plain.fps+cluttered.fps=7.5,15,30,60",
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
