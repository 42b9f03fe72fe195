"""C5 to C11 along the speed of the background: up to which speed each holds, and what breaks it.

Beside them, in how many crossings each direction model answers the object, and not the background.

The paper's -8 px/s is 0.27 px a frame at 30 frames per second: a background that hardly moves. Each claim is judged
here by its own judge at every speed, one at a time, in the direction that its words name.
"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from experiments import Axis, Check, Level, Study
from experiments.background import SPEEDS
from experiments.bench.sources.clip_claims import DSNN, ClipClaim, find, levels, rises
from experiments.bench.stats.claim import Claim
from experiments.bench.stats.count import count_of

if TYPE_CHECKING:
    import polars as pl

NAME = "background (px/s)"
BACKGROUND = Axis(NAME, tuple(Level(f"{speed:g}") for speed in SPEEDS), title=NAME)
GREYS = (0.0, 255.0)
"""Of the objects of C6 and C7: a dark and a light one."""
RIGHTWARD = ("C5",)
"""The claims before a background that shifts rightward; in the words of the others it shifts leftward."""
BESIDE = ("emd-normalised", "three-arm", "three-arm-4q", "t4t5")
"""Models that see the clips beside those of the experiment, `dsnn`, `dsn2017` and `emd`."""
OBJECT_SPEED = {"C6": 120.0}
FPS = 30.0


def c7_rises(clips: "pl.DataFrame", threshold: float) -> list[Check]:
    """Judge whether peak HS rises with the object's speed, at one speed of the background."""
    shown = clips.filter(model=DSNN)
    greys = levels(shown, "grey")
    return [check for grey in greys for check in rises(shown.filter(grey=grey), threshold, f"grey {grey:g}")]


C7_RISES = replace(
    find("C7"),
    id="C7-rises",
    title="Peak rises with speed",
    says="peak HS rises with the object's speed",
    judge=c7_rises,
)
"""C7 compares speeds of the background too, which one speed cannot answer."""


def at_speed(claim: Claim, point: Mapping[str, str]) -> ClipClaim:
    """Return one of the paper's claims asked at one speed of the background."""
    assert isinstance(claim, ClipClaim)
    speed = float(point[NAME])
    shift = speed if claim.id in RIGHTWARD else -speed
    conditions: dict[str, tuple[Any, ...]] = {**claim.conditions, "background_speed": (shift,)}
    if claim.id in OBJECT_SPEED:
        conditions["speed"] = (OBJECT_SPEED[claim.id],)
    if claim.id in ("C6", C7_RISES.id):
        conditions["grey"] = GREYS
    if claim.id == C7_RISES.id:
        conditions["object"] = ("present",)
    return replace(claim, conditions=conditions)


def tables(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return where each claim breaks, and in how many crossings each model responds to the object."""
    return {"Where each claim breaks": breaks(result), "Crossings answered rightward": answered(result)}


def answered(result: Any) -> list[dict[str, Any]]:
    """Return in how many crossings the strongest of HS and VS is rightward, by model and the background's px a frame.

    The object moves rightward and the background leftward, in every replicate before another scene.
    """
    from experiments.bench.sources.clip_claims import answer

    point, model = result.plan.judged[0]
    found: dict[str, dict[str, list[bool]]] = {}
    for row in (row for replicate in result.replicates(point, model) for row in replicate.rows):
        if row["motion"] == "rightward" and row["object"] != "absent":
            column = f"{abs(row['background_speed']) / FPS:.2g}"
            found.setdefault(row["model"], {}).setdefault(column, []).append(answer(row) == "rightward")
    return [
        {"model": name, **{column: f"{sum(hits)}/{len(hits)}" for column, hits in columns.items()}}
        for name, columns in found.items()
    ]


def breaks(result: Any) -> list[dict[str, Any]]:
    """Return for each claim at which speeds it holds, in px a frame, and what decided at the lowest where it fails."""
    rows = []
    for (claim,), table in result.counts.group_by("claim", maintain_order=True):
        found = {row[NAME] / FPS: (count_of(row), row["decided"]) for row in table.iter_rows(named=True)}
        halves = {speed: counted.half or counted for speed, (counted, _) in found.items()}
        failing = [speed for speed, (counted, _) in found.items() if counted.fails]
        half = any(counted.half for counted, _ in found.values())
        rows.append({
            "claim": f"{claim}, the DSNN's half" if half else claim,
            "holds at (px a frame)": _listed(speed for speed, part in halves.items() if part.holds == part.replicates),
            "fails at": _listed(failing),
            "not judged at": _listed(speed for speed, part in halves.items() if not part.judged),
            "breaks first": f"{min(failing):.2g} px a frame: {found[min(failing)][1]}" if failing else "",
        })  # fmt: skip
    return rows


def _listed(speeds: Iterable[float]) -> str:
    return ", ".join(f"{speed:.2g}" for speed in sorted(speeds)) or "-"


STUDY = Study(
    name="background",
    summary="C5 to C11 of the DSNN before a background that shifts at 0.07 to 10 px a frame; all models of direction",
    claims=tuple(C7_RISES if number == 7 else find(f"C{number}") for number in range(5, 12)),
    experiments=("background",),
    models=("dsnn", *BESIDE),
    axes=(BACKGROUND,),
    repeats=None,
    replicates=1,
    as_run=True,
    claim_at=at_speed,
    tables=tables,
)
