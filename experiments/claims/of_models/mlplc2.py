"""The claims of the paper behind mlplc2."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Liu and Fu 2025, arXiv 2504.04477"

CLAIMS = (
    ModelClaim(
        id="MLPLC2-1",
        says="dark and light objects that loom at the centre are answered, at every l/v",
        source=SOURCE,
        model="mlplc2",
        check="each",
        measure="spikes",
        bound=1.0,
        clips=(
            "dark-looming",
            "light-looming",
        ),
    ),
    ModelClaim(
        id="MLPLC2-2",
        says="attention finds what looms elsewhere: expansion 20 degrees off the axis is answered too",
        source=SOURCE,
        model="mlplc2",
        check="each",
        measure="spikes",
        bound=1.0,
        clips=("off-centre",),
    ),
    ModelClaim(
        id="MLPLC2-3",
        says="translation, of objects and of gratings, is not answered",
        source=SOURCE,
        model="mlplc2",
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
        id="MLPLC2-4",
        says="recession is not answered",
        source=SOURCE,
        model="mlplc2",
        check="none",
        measure="spikes",
        bound=0.0,
        clips=(
            "dark-receding",
            "light-receding",
        ),
        beside=("dark-looming",),
    ),
)
