"""The claims of the paper behind lplc2."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Hua, Fu, Peng, Yue and Luan 2022, IJCNN"

CLAIMS = (
    ModelClaim(
        id="LPLC2-1",
        says="a dark object that looms at the centre is answered, at every l/v",
        source=SOURCE,
        model="lplc2",
        check="each",
        measure="spikes",
        bound=1.0,
        clips=("dark-looming",),
    ),
    ModelClaim(
        id="LPLC2-2",
        says="translation, of objects and of gratings, is not answered",
        source=SOURCE,
        model="lplc2",
        check="none",
        measure="spikes",
        bound=0.0,
        clips=(
            "translating",
            "gratings",
        ),
        beside=("dark-looming",),
    ),
    ModelClaim(
        id="LPLC2-3",
        says="recession is not answered",
        source=SOURCE,
        model="lplc2",
        check="none",
        measure="spikes",
        bound=0.0,
        clips=(
            "dark-receding",
            "light-receding",
        ),
        beside=("dark-looming",),
    ),
    ModelClaim(
        id="LPLC2-4",
        says="the centre counts: expansion 20 degrees off it gives at most half of the potential",
        source=SOURCE,
        model="lplc2",
        check="share",
        measure="peak",
        bound=0.5,
        clips=("off-centre",),
        against=("dark-looming",),
    ),
)
