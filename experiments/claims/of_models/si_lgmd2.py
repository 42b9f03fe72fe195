"""The claims of the paper behind si-lgmd2."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = (
    "Modeling self-inhibition in neural networks for collision perception against translating motion, with its "
    "public firmware"
)

CLAIMS = (
    ModelClaim(
        id="SI2-1",
        says="dark looming means a collision: at least the four spikes that its rule asks for, at every l/v",
        source=SOURCE,
        model="si-lgmd2",
        check="each",
        measure="spikes",
        bound=4.0,
        clips=("dark-looming",),
    ),
    ModelClaim(
        id="SI2-2",
        says="it prefers what darkens: light looming and dark recession get at most half of the spikes of dark looming",
        source=SOURCE,
        model="si-lgmd2",
        check="share",
        measure="spikes",
        bound=0.5,
        clips=(
            "light-looming",
            "dark-receding",
        ),
        against=("dark-looming",),
    ),
    ModelClaim(
        id="SI2-3",
        says="self-inhibition silences translation: fewer than the four spikes of a collision",
        source=SOURCE,
        model="si-lgmd2",
        check="none",
        measure="spikes",
        bound=3.0,
        clips=("translating",),
        beside=("dark-looming",),
    ),
)
