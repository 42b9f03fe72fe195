"""C13 to C20 under the range of what is not known about the robot's eye and its light, beside the two fixed eyes.

No source says whether the robot's gamma curve was on, where its exposure loop meters, which mean grey it aimed at, how
its lens falls off, or how bright its arena was. Each row of the map is one eye, each column a light and a target.
"""

from colias_sim.registers import GAMMA_VENDOR
from experiments import Axis, Level, Study

OV7670 = "camera.preset=ov7670"
TARGETS = (60, 108, 150)
"""Mean grey that the exposure loop aims at: darker than after a reset, as after a reset, and brighter."""
VENDOR = f"camera.gamma_points={','.join(map(str, GAMMA_VENDOR))}"

DEFAULT = ("camera.ae_target=108", "camera.exposure_samples=1", "camera.row_bands=6")
"""What the other axes move, as the eye ``default`` has it."""


def eye(label: str, *settings: str) -> Level:
    """Return the robot's eye with some settings of its own."""
    return Level(label, (OV7670, *settings))


# More light would shorten an exposure of 3 ms, whose motion blur is hardly seen. A tenth lengthens it to some 29 ms:
# by 2 renders of it in 4 bands of rows, not 8 in 6, HS of crossings at 4 to 10 cm/s differs by 0.006 rms and spikes by
# one at most, in a quarter of the time.
LIGHT = Axis(
    "light", (Level("1"), Level("0.1", ("scene.light=0.1", "camera.exposure_samples=2", "camera.row_bands=4"))), "1"
)
TARGET = Axis("target", tuple(Level(f"{target}", (f"camera.ae_target={target}",)) for target in TARGETS), "108")
EYE = Axis(
    "eye",
    (
        # It has no loop, so one target is enough, and one render of all rows.
        Level("default", ("camera.preset=default", *DEFAULT)),
        eye("ov7670"),
        eye("ov7670, falloff", "camera.vignetting=4"),
        eye("gamma, metered", "camera.gamma=true", "camera.ae_meter=luma"),
        eye("gamma, not metered", "camera.gamma=true"),
        eye("steep gamma, metered", "camera.gamma=true", VENDOR, "camera.ae_meter=luma"),
    ),
    "ov7670",
)
"""The preset ``ov7670`` is there at target 108 and light 1, and ``default`` at light 1.

The others are ``ov7670`` with a lens that falls off as the cosine to the fourth, with the sensor's gamma curve after a
reset, or with the vendor's steeper one. A loop that meters the curve sees its luma, another the light before it.
"""

STUDY = Study(
    name="eye-range",
    summary="C13 to C20 over gamma, metering, falloff, exposure target and light, beside the eyes default and ov7670",
    claims=("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20"),
    axes=(LIGHT, TARGET, EYE),
    repeats=5,
    replicates=2,
)
