"""Studies of the claims about the robot: eyes, wheels, and each parameter moved by itself."""

from typing import Any

from experiments import Study
from experiments.paper.studies.onboard import BEST, CLAIMS, probe_of

WHOLE = ("general", "speed", "distance", "angular-approach", "angular-recession")
"""The paper's experiments with the robot."""
OV7670 = "camera.preset=ov7670"
DEFAULTS = "defaults"

EYES = {"default": (), "ov7670": (OV7670,)}
WHEELS = {"pose feedback": (), "open loop": ("robot.preset=colias4",)}


def driven(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return how the stimulus moved at each point: mean errors of its speed, and of its distance from the path."""
    import polars as pl  # not before: it takes its time to load, and listing studies needs none

    rows = []
    for point, model in result.judged:
        trials = result.rows(point, model).unique("trial", keep="last")  # some are shown to several models
        speed = (pl.col("achieved_speed_cm_s") / pl.col("speed_cm_s") - 1.0).abs().mean()
        errors = trials.select(speed.alias("speed error"), pl.col("path_error_mm").mean().alias("path error (mm)"))
        rows.append({**dict(point), "trials": trials.height, **errors.row(0, named=True)})
    return {"How the stimulus moved": rows}


FIDELITY = Study(
    name="fidelity",
    summary="the claims about the robot with the default camera or its own, with pose feedback or its wheels open loop",
    claims=(*CLAIMS, "C21", "C29", "C31"),
    axes={"eye": EYES, "wheels": WHEELS},
    models=(),  # those that each claim is about
)
"""The claims about the robot with the model of its eye, and with its wheels; not those of speeds beyond these."""

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
MOVED = {
    DEFAULTS: (),
    **{name: (f"dsnn.{text}", f"{BEST}.{text}") for name, text in NETWORK.items()},
    **{name: (f"dsnn.{text}",) for name, text in READINGS.items()},
    **APPARATUS,
}
SENSITIVITY = Study(
    name="sensitivity",
    summary="C13 to C20 and C29 with one thing moved at a time, in float and in the robot's arithmetic",
    claims=(*CLAIMS, "C29"),
    experiments=WHOLE,
    axes={"moved": MOVED},
    models=("dsnn", BEST),
    replicates=1,
)
"""Sensitivity of the claims about the robot to each parameter of network and apparatus, moved by itself."""
PROBE = probe_of(DEFAULTS, f"{BEST} {DEFAULTS}")
ONLY = dict.fromkeys((*READINGS, *APPARATUS), ("dsnn",))
"""What is kept of the models in every frame; the moves at which the network of the robot is not judged."""
