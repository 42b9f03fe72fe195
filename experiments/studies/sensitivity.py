"""Sensitivity of the claims about the robot to each parameter of network and apparatus, moved by itself."""

from experiments import Axis, Level, Study
from experiments.studies.onboard import BEST, series_of

DEFAULTS = "defaults"
NETWORK = {
    "N_p = 0": "n_p=0",
    "N_p = 6": "n_p=6",
    "d = 4": "d=4",
    "N_con = 4": "n_con=4",
    "tau_s = 10 for all": "tau_s=10,10",
    "tau_s = 200 for all": "tau_s=200,200",
    "tau_s falling, 200..10": "tau_s=200,10",
    "K_sp = 2": "k_sp=2",
    "K_sp = 3": "k_sp=3",
    "T_sp = 0.16": "t_sp=0.16",
    "no FDSR": "fdsr=false",
}
"""Each parameter at the end of the paper's own range that the default is not at, K_sp also within it; the last is its
forerunner."""
READINGS = {
    "F not rectified": "rectified=false",
    "LA by the centre's sign": "polarity=centre",
    "exact low-pass": "lowpass=exact",
}
"""The equations that the paper leaves open, read otherwise; in float alone, as `dsnn.onboard.params.READINGS` says."""
APPARATUS = {
    "no camera noise": ("camera.shot_noise=0", "camera.read_noise=0"),
    "camera noise x 2": ("camera.shot_noise=2.56", "camera.read_noise=1.28"),
    "light x 0.7": ("scene.light=0.7",),
    "dim arena": ("scene.arena=dim",),
    "plain wall": ("scene.arena=plain",),
    "wall contrast x 2": ("scene.wall_contrast=2",),
    "sudden starts, 100 cm/s2": ("experiment.acceleration_cm_s2=100",),
    "soft starts, 10 cm/s2": ("experiment.acceleration_cm_s2=10",),
}
MOVED = Axis(
    "moved",
    (
        Level(DEFAULTS),
        *(Level(name, (f"dsnn.{text}", f"{BEST}.{text}")) for name, text in NETWORK.items()),
        *(Level(name, (f"dsnn.{text}",), models=("dsnn",)) for name, text in READINGS.items()),
        *(Level(name, settings, models=("dsnn",)) for name, settings in APPARATUS.items()),
    ),
)

STUDY = Study(
    name="sensitivity",
    summary="C13 to C20 and C29 with one thing moved at a time, in float and in the robot's arithmetic",
    claims=("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20", "C29"),
    experiments=("general", "speed", "distance", "angular-approach", "angular-recession"),
    axes=(MOVED,),
    models=("dsnn", BEST),
    replicates=1,
    probe=series_of((DEFAULTS, f"{BEST} {DEFAULTS}")),
)
