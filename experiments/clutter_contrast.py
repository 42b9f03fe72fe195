"""Five greys at five speeds before a natural image that shifts left (the paper's simu-sys-grayscale)."""

from experiments import Clip, Figure, OfflineExperiment

GREYS, SPEEDS = (0.0, 64.0, 128.0, 191.0, 255.0), (40.0, 60.0, 80.0, 100.0, 120.0)

EXPERIMENT = OfflineExperiment(
    name="clutter-contrast",
    summary="objects of five greys cross at 40 .. 120 px/s before a natural image shifting at -8 px/s",
    clips=(
        *(
            Clip(f"grey {grey:g} at {speed:g}", "cluttered", (("grey", grey), ("speed", speed)))
            for grey in GREYS
            for speed in SPEEDS
        ),
        Clip("background alone", "cluttered", (("object", "absent"), ("speed", 40.0))),
    ),
    models=(
        "dsnn",
        "emd",
        "dsnn:n_con=1",
        "dsnn:n_con=2",
        "emd:gain=0.7732",  # its gain matched
        "dsnn:n_con=1,k_sig=0.00125",  # as a mean per correlator
        "dsnn:n_con=2,k_sig=0.0025",
    ),
    claims=("C9", "C10", "C11", "C24", "C26"),
    repeats=2,
    recorded=False,
    figure=Figure("contrast"),
)

if __name__ == "__main__":
    EXPERIMENT.main()
