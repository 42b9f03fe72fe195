"""Studies of the claims about clips: the background's speed, other models' constants, the network's own."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from experiments import Check, Study
from experiments.declare.claim import Claim
from experiments.judge.judge import Rows
from experiments.kinds.registry import claims_on, find_claim
from experiments.paper.claims.clips import ASSUMED, answer, rises, rows_of, with_model
from experiments.paper.clips import FASTER, VARIANTS_2017, VARIANTS_EMD
from experiments.paper.studies.robot import DEFAULTS, NETWORK, READINGS

SPEED = {"C6": (120.0,)}
"""The object's speed in a claim's own clips, px/s, where its words name none; the experiments show other speeds too."""

# C5 to C11 along the speed of the background. The paper's -8 px/s is 0.27 px a frame at 30 frames per second: a
# background that hardly moves. Each claim is judged at every speed, one at a time, in the direction its words name.
BEHIND = "background (px/s)"
FPS = 30.0
RIVALS = ("emd-normalised", "three-arm", "three-arm-4q", "t4t5")
"""Models that see the clips beside those of the experiment, `dsnn`, `dsn2017` and `emd`."""


def c7_rises(clips: Rows, threshold: float) -> list[Check]:
    """Judge whether peak HS rises with the object's speed, at one speed of the background."""
    return rises(rows_of(clips), threshold, "grey")


C7_RISES = replace(
    find_claim("C7", "clips"), id="C7-rises", title="Peak rises with speed",
    says="peak HS rises with the object's speed", judge=c7_rises,
)  # fmt: skip
"""C7 compares speeds of the background too, which one speed cannot answer."""


def at_speed(claim: Claim, point: Mapping[str, str]) -> Claim:
    """Return one of the paper's claims asked at one speed of the background."""
    speed = float(point[BEHIND])
    conditions: dict[str, tuple[Any, ...]] = {
        **claim.conditions,
        "background_speed": (speed if claim.id == "C5" else -speed,),  # in the words of the others it shifts leftward
        **({"speed": SPEED[claim.id]} if claim.id in SPEED else {}),
        **({"grey": (0.0, 255.0)} if claim.id in ("C6", C7_RISES.id) else {}),
        **({"object": ("present",)} if claim.id == C7_RISES.id else {}),
    }
    return replace(claim, conditions=conditions)


def answered(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return in how many crossings the strongest of HS and VS is rightward, by model and the background's px a frame.

    The object moves rightward and the background leftward, in every replicate before another scene.
    """
    found: dict[str, dict[str, list[bool]]] = {}
    for row in result.rows(*result.judged[0]).iter_rows(named=True):
        if row["motion"] == "rightward" and row["object"] != "absent":
            column = f"{abs(row['background_speed']) / FPS:.2g}"
            found.setdefault(row["model"], {}).setdefault(column, []).append(answer(row) == "rightward")
    rows = [
        {"model": model, **{column: f"{sum(hits)}/{len(hits)}" for column, hits in columns.items()}}
        for model, columns in found.items()
    ]
    return {"Crossings answered rightward": rows}


BACKGROUND = Study(
    name="background",
    summary="C5 to C11 of the DSNN before a background that shifts at 0.07 to 10 px a frame; all models of direction",
    claims=tuple(C7_RISES if number == 7 else find_claim(f"C{number}", "clips") for number in range(5, 12)),
    experiments=("background",),
    axes={BEHIND: {f"{speed:g}": () for speed in FASTER}},
    models=("dsnn", *RIVALS),
    repeats=None,
    replicates=1,
)

# Claims that compare the DSNN with another model, along that model's constants, which are not known: a claim is judged
# once for each variant of the other model, on the same clips.


def compares_with(claim: str) -> str:
    """Return the label of the model of unknown constants that a claim compares the DSNN with; empty if none."""
    paper = claims_on("clips").get(claim)
    return next((model for model in ASSUMED if paper and model in paper.models), "")


ALONG = "constants of "


def along(name: str, summary: str, claims: Sequence[str], other: str, variants: Sequence[str]) -> Study:
    """Return the study ``name`` of claims along the constants of the model ``other``.

    The experiment of the same name shows its ``variants``, labels as ``dsn2017:k_sig=10``.
    """
    levels = [label.partition(":")[2].replace(",", ", ") for label in variants]
    asked = []
    for claim in (find_claim(claim, "clips") for claim in claims):
        conditions = {**claim.conditions, **({"speed": SPEED[claim.id]} if claim.id in SPEED else {})}
        asked.append(replace(claim.settled(), conditions=conditions))
    return Study(name, summary, tuple(asked), experiments=(name,), axes={f"{ALONG}{other}": dict.fromkeys(levels, ())},
                 repeats=None, replicates=1)  # fmt: skip


def with_constants(claim: Claim, point: Mapping[str, str]) -> Claim:
    """Return a claim about a model with the constants of a point, in the place of that with those assumed."""
    ((axis, level),) = point.items()
    other = axis.removeprefix(ALONG)
    return with_model(claim, other, f"{other}:{level.replace(', ', ',')}")


CONSTANTS_2017 = along(
    "constants-2017", "C5, C6 and C7 with the model of 2017 at sigmoid scales over five decades", ("C5", "C6", "C7"),
    "dsn2017", VARIANTS_2017,
)  # fmt: skip
CONSTANTS_EMD = along(
    "constants-emd", "C11 and C26 with the EMD at 24 choices of spacing, delay and high-pass", ("C11", "C26"), "emd",
    VARIANTS_EMD,
)  # fmt: skip

SPIKING = ("k_sp", "t_sp")
"""`K_sp` changes counts of spikes alone, which no claim about clips reads."""
MOVES = {
    **{name: text for name, text in NETWORK.items() if text.partition("=")[0] not in SPIKING},
    "T_sp = 0.2": "t_sp=0.2",  # the default of off-line tests is the other end of the paper's range
    **READINGS,
}
SENSITIVITY = Study(
    name="sensitivity-clips",
    summary="C1 to C11, C22 to C24 and C26 to C28 on clips, with one thing of the network moved at a time",
    claims=tuple(f"C{number}" for number in (*range(1, 12), 22, 23, 24, 26, 27, 28)),
    experiments=("clean", "blocked", "clutter-depth", "clutter-translation", "clutter-speed", "clutter-contrast",
                 "street", "edges", "apparent", "background-alone"),
    axes={"moved": {DEFAULTS: (), **{name: (f"dsnn.{text}",) for name, text in MOVES.items()}}},
    replicates=1,
)  # fmt: skip
"""The models that the claims compare the DSNN with stay as they are; the DSNN with a blocked pathway, and its other
variants, move with it."""
