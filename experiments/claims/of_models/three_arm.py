"""The claims of the papers behind three-arm."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Haag, Arenz, Serbe, Gabbiani and Borst 2016, eLife 5:e17421; Haag, Mishra and Borst 2017, eLife 6:e29044"
QUADRANTS = "Eichner, Joesch, Schnell, Reiff and Borst 2011, Neuron 70:1155"

CLAIMS = (
    ModelClaim(
        id="ARM3-1",
        says=(
            "all four directions are told in both pathways: translation is answered by the right system with the "
            "right sign, dark and light alike, in every clip"
        ),
        source=SOURCE,
        model="three-arm",
        check="way",
        measure="way",
        bound=1.0,
        clips=("translating",),
    ),
    ModelClaim(
        id="ARM3-2",
        says=(
            "opposite motions cancel: looming at the centre leaves at most a tenth of the answer to translation"
            " in HS and VS"
        ),
        source=SOURCE,
        model="three-arm",
        check="share",
        measure="way",
        bound=0.1,
        clips=(
            "dark-looming",
            "light-looming",
        ),
        against=("translating",),
    ),
    ModelClaim(
        id="ARM3-3",
        says="a cell is enhanced along its preferred direction and suppressed along its null direction",
        source=SOURCE,
        model="three-arm",
        check="not shown",
        why="a single cell's answer to pairs of flashes is not in HS and VS",
    ),
)
