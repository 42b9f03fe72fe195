"""Effects of the ensemble and its delays: the speed tests with the DSNN beside variants of itself, 2 to 30 cm/s.

The paper's text says that connecting several cells, with delays that depend on their spacing, improves the response to
speed, and that the peak over speeds comes from the sampling distance and the number of connections. The variants have
fewer connections, wider spacing, or one delay for all pairs. They see the same frames.

The paper's speeds are 2, 4, 6 and 10 cm/s. 8 cm/s is a speed of claim C25. 3 and 5 fill in where the count rises.
15, 20 and 30 are beyond the paper's, up to near the robot's top speed: they show where the potential is largest.
"""

from experiments import Experiment, Translation

MODELS = (
    "dsnn", "dsnn:n_con=1", "dsnn:n_con=2", "dsnn:n_con=4", "dsnn:d=2", "dsnn:tau_s=10,10", "dsnn:tau_s=50,50",
    "dsnn:tau_s=100,100", "dsnn:tau_s=200,200",
    "dsnn:tau_s=200,10",  # falling with spacing: the other reading of the paper's words
    "dsnn:n_con=1,k_sig=0.00125", "dsnn:n_con=2,k_sig=0.0025",  # as a mean per correlator: C24
)  # fmt: skip

EXPERIMENT = Experiment(
    name="ensembles",
    summary="crossings at 8 cm, 2 to 30 cm/s: the DSNN beside itself with other connections and delays",
    design=Translation(speeds_cm_s=(2, 3, 4, 5, 6, 8, 10, 15, 20, 30), distances_cm=(8,)),
    varies="speed_cm_s",
    claims=("C24", "C25", "C30"),
    models=MODELS,
    figure="mechanism",
)

if __name__ == "__main__":
    EXPERIMENT.main()
