"""C13 to C20 at the setting that ``fit-eye`` found, where a feedback of the pose takes the place of the wheels.

With the robot's wheels it keeps C14 to C20, and C13 where a straight approach ends within 2 mm of its line. A feedback
keeps every path on its line. The numbers are those of the winner of ``colias fit fit-eye`` at seed 0.
"""

from experiments import Study
from experiments.studies.fit_eye import CLAIMS, WHOLE

WINNER = (
    "dsnn.t_sp=0.0474296", "dsnn.k_sp=1.17751", "dsnn.n_con=6", "dsnn.d=2", "dsnn.tau_s=67.221,261.389",
    "camera.ae_target=115.535", "camera.gamma=true", "camera.vignetting=2.17018", "scene.light=1.49107",
)  # fmt: skip

STUDY = Study(
    name="fitted-feedback",
    summary="C13 to C20 at the setting that fit-eye found, with a feedback of the pose in place of the wheels",
    claims=CLAIMS,
    experiments=WHOLE,
    assignments=("camera.preset=ov7670", *WINNER),
)
