"""The claims of the papers behind three-arm-4q."""

from __future__ import annotations

from experiments.bench.reproduction.models.claims import ModelClaim
from experiments.claims.of_models.three_arm import QUADRANTS, SOURCE

CLAIMS = (
    ModelClaim(
        id="ARM3-4",
        says=(
            "with all four quadrants too translation is answered by the right system with the right sign, in every clip"
        ),
        source=SOURCE,
        model="three-arm-4q",
        check="way",
        measure="way",
        bound=1.0,
        clips=("translating",),
    ),
    ModelClaim(
        id="ARM3-5",
        says="reverse phi is answered against its displacement, by the right system, in every clip",
        source=QUADRANTS,
        model="three-arm-4q",
        check="reversed",
        measure="way",
        bound=1.0,
        clips=("reverse-phi",),
    ),
)
