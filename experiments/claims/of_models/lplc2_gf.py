"""The claims of the paper behind lplc2-gf."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Zhao, Xi, Li, Guo and Wu 2023, iScience 26:106337"

CLAIMS = (
    ModelClaim(
        id="GF-1",
        says="the giant fibre fires at a dark object that looms at the centre, at every l/v",
        source=SOURCE,
        model="lplc2-gf",
        check="each",
        measure="spikes",
        bound=1.0,
        clips=("dark-looming",),
    ),
    ModelClaim(
        id="GF-2",
        says="it does not fire at translation, gratings or recession",
        source=SOURCE,
        model="lplc2-gf",
        check="none",
        measure="spikes",
        bound=0.0,
        clips=(
            "translating",
            "gratings",
            "dark-receding",
            "light-receding",
        ),
        beside=("dark-looming",),
    ),
    ModelClaim(
        id="GF-3",
        says="the same looming is answered at 100 frames/s, the rate of the paper",
        source=SOURCE,
        model="lplc2-gf:fps=100",
        check="each",
        measure="spikes",
        bound=1.0,
        clips=("looming-100",),
    ),
    ModelClaim(
        id="GF-4",
        says="a virtual robot steered by it avoids collisions",
        source=SOURCE,
        model="lplc2-gf",
        check="not shown",
        why="the paper's virtual robot and its corridor are not built here",
    ),
)
