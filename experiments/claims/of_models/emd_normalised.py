"""The claims of the paper behind emd-normalised."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Drews and others 2020, Current Biology 30:209"

CLAIMS = (
    ModelClaim(
        id="EMDN-1",
        says=(
            "translation in the four directions is answered by the right system with the right sign, dark and "
            "light alike, in every clip"
        ),
        source=SOURCE,
        model="emd-normalised",
        check="way",
        measure="way",
        bound=1.0,
        clips=("translating",),
    ),
    ModelClaim(
        id="EMDN-2",
        says=(
            "local contrast is compressed: a grating of a quarter of the contrast gives at least half of the "
            "potential, where a correlator without normalisation gives a sixteenth"
        ),
        source=SOURCE,
        model="emd-normalised",
        check="ratio",
        measure="way",
        bound=0.5,
        clips=("faint-gratings",),
        against=("gratings",),
    ),
    ModelClaim(
        id="EMDN-3",
        says=(
            "one velocity is told alike whatever the scene: among natural scenes that pan at one speed the weakest "
            "answer is at least half of the strongest"
        ),
        source=SOURCE,
        model="emd-normalised",
        check="ratio",
        measure="way",
        bound=0.5,
        clips=("panning-scenes",),
        against=("panning-scenes",),
    ),
    ModelClaim(
        id="EMDN-4",
        says="a trained network with this normalisation estimates the velocity of natural scenes as well as a fly",
        source=SOURCE,
        model="emd-normalised",
        check="not shown",
        why="the paper's panoramas and the weights of its trained network are not here",
    ),
)
