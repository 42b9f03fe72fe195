"""The claims of the paper behind t4t5."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim

SOURCE = "Liu and Fu 2025, arXiv 2504.04477, its T4 and T5 cells"

CLAIMS = (
    ModelClaim(
        id="T4T5-1",
        says=(
            "translation in the four directions is answered by the right system with the right sign, dark and "
            "light alike, in every clip"
        ),
        source=SOURCE,
        model="t4t5",
        check="way",
        measure="way",
        bound=1.0,
        clips=("translating",),
    ),
    ModelClaim(
        id="T4T5-2",
        says=(
            "opposite motions cancel: looming at the centre leaves at most a tenth of the answer to translation"
            " in HS and VS"
        ),
        source=SOURCE,
        model="t4t5",
        check="share",
        measure="way",
        bound=0.1,
        clips=(
            "dark-looming",
            "light-looming",
        ),
        against=("translating",),
    ),
)
