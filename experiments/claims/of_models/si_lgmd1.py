"""The claims of the paper behind si-lgmd1."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = (
    "Modeling self-inhibition in neural networks for collision perception against translating motion, with its "
    "public firmware"
)

CLAIMS = (
    ModelClaim(
        id="SI1-1",
        says=(
            "dark and light looming alike mean a collision: at least the four spikes that its rule asks for, at"
            " every l/v"
        ),
        source=SOURCE,
        model="si-lgmd1",
        check="each",
        measure="spikes",
        bound=4.0,
        clips=(
            "dark-looming",
            "light-looming",
        ),
    ),
    ModelClaim(
        id="SI1-2",
        says="self-inhibition silences translation: fewer than the four spikes of a collision",
        source=SOURCE,
        model="si-lgmd1",
        check="none",
        measure="spikes",
        bound=3.0,
        clips=("translating",),
        beside=("dark-looming",),
    ),
    ModelClaim(
        id="SI1-3",
        says="without self-inhibition translation is answered at least twice as strongly",
        source=SOURCE,
        model="si-lgmd1",
        check="more",
        measure="peak",
        bound=2.0,
        clips=("translating",),
        than="si-lgmd1:beta_3=0",
    ),
    ModelClaim(
        id="SI1-4",
        says="on the robot it escapes in 93.7 % of encounters, the fly's LPLC2 in 96.1 %",
        source=SOURCE,
        model="si-lgmd1",
        check="not shown",
        why="needs over a thousand encounters a model to tell 96.1 from 93.7 %",
    ),
)
