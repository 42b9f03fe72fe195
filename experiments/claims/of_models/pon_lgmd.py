"""The claims of the paper behind pon-lgmd."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Fu and Li 2022, Harmonizing motion and contrast vision for robust looming detection"

CLAIMS = (
    ModelClaim(
        id="PON-1",
        says="contrast hardly matters: looming of a quarter of the contrast gives at least half of the potential",
        source=SOURCE,
        model="pon-lgmd",
        check="ratio",
        measure="peak",
        bound=0.5,
        clips=("low-contrast",),
        against=("dark-looming",),
    ),
    ModelClaim(
        id="PON-2",
        says="looming, dark and light, raises the potential above every translation and recession",
        source=SOURCE,
        model="pon-lgmd",
        check="ratio",
        measure="peak",
        bound=1.0,
        clips=(
            "dark-looming",
            "light-looming",
        ),
        against=(
            "translating",
            "dark-receding",
            "light-receding",
        ),
    ),
    ModelClaim(
        id="PON-3",
        says=(
            "a moving background is hardly seen: looming before a drifting grating gives at least twice the "
            "potential of the grating alone"
        ),
        source=SOURCE,
        model="pon-lgmd",
        check="ratio",
        measure="peak",
        bound=2.0,
        clips=("before-grating",),
        against=("grating-alone",),
    ),
)
