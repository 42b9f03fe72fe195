"""Parts that judges of clips share: a model's rows, its potentials against T, and models whose constants are not known.

A judge takes the rows of one seed's clips that its claim's words are about, of all the models that it names, and the
threshold of the DSNN.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

from experiments.bench.stats.checks import Check, decide, exceeds
from experiments.bench.stats.verdict import Outcome

Row = Mapping[str, Any]
Rows = Sequence[Row]
DSNN, EARLIER, EMD = "dsnn", "dsn2017", "emd"
BLOCKED = ("dsnn-on-blocked", "dsnn-off-blocked")
SIGNED = {
    "rightward": ("peak_hs", 1),
    "leftward": ("trough_hs", -1),
    "downward": ("peak_vs", 1),
    "upward": ("trough_vs", -1),
}
"""Direction -> the extreme that answers it, and its sign."""
SHADES = ("dark", "light")
EVERY = ()
"""Of a column of a claim's conditions: each level that is there."""
BACKGROUNDS, CONTRAST_SPEEDS = (-2.0, -4.0, -6.0, -8.0, -10.0), (40.0, 60.0, 80.0, 100.0, 120.0)
"""Speeds of the paper's backgrounds, and of the objects of its contrast grid, px/s."""
CROSSING: Mapping[str, tuple[Any, ...]] = {"motion": ("rightward",)}
CONTRAST_GRID: Mapping[str, tuple[Any, ...]] = {
    **CROSSING,
    "background_speed": (-8.0,),
    "speed": CONTRAST_SPEEDS,
    "grey": EVERY,
}
"""Conditions of the claims about the paper's grid of greys and speeds."""
LEAST_GREYS = 5
"""Grey levels that the claims about contrast need."""
MOST_OF_DRIVEN, LEAST_OF_OTHER = 0.05, 0.95
"""Of the answer to one edge, what C22 lets either blocked pathway leave: that which it drives, and the other."""

_UNREAD = "are neither in the paper nor in any public text or code that could be searched"
ASSUMED: Mapping[str, str] = {
    "dsn2017": f"the constants of the model of 2017 (Fu and Yue 2017, IJCNN) {_UNREAD}; it is taken to be the DSNN "
    "without FDSR, with the DSNN's constants",
    "emd": f"the constants of Iida's EMD (Iida and Lambrinos 2000; Iida 2003) {_UNREAD}; a high-pass of 250 ms, a "
    "delay of 50 ms and neighbouring pixels are assumed",
}
"""Model -> what is not known of it, and what is assumed.

The paper compares the DSNN with its forerunner of 2017 and with the elementary motion detectors of Iida. It gives the
constants of neither. What is assumed of them decides how such a claim comes out, so that it can neither be refuted nor
borne out by them.
"""


def rows_of(rows: Rows, model: str = DSNN, **fixed: Any) -> list[Row]:
    """Return those of a model whose columns have the ``fixed`` values."""
    return [row for row in rows if row["model"] == model and all(row[k] == v for k, v in fixed.items())]


def rows_with_object(rows: Rows, model: str = DSNN) -> list[Row]:
    """Return those of a model with an object."""
    return rows_of(rows, model, object="present")


def levels(rows: Rows, name: str) -> list[float]:
    """Return the values of a column, each once, from the lowest up."""
    return sorted({row[name] for row in rows if row[name] is not None})


def strongest(row: Row, system: str) -> float:
    """Return the largest absolute potential of ``hs`` or ``vs`` in a clip."""
    return float(max(row[f"peak_{system}"], -row[f"trough_{system}"]))


def strongest_of_both(rows: Iterable[Row]) -> dict[str, float]:
    """Return clip -> the largest absolute potential of both systems."""
    return {row["clip"]: max(strongest(row, "hs"), strongest(row, "vs")) for row in rows}


def stays_inside(text: str, value: float, threshold: float) -> Check:
    """Return the check that a potential stays inside +-T."""
    return Check(text, value, threshold, "at most", scale=threshold, asks=f"to stay inside T = {threshold:g}")


def all_inside(worst: Mapping[str, float], threshold: float, what: str) -> list[Check]:
    """Return the checks that every one of the potentials stays inside +-T."""
    return [stays_inside(f"{clip}: {what} up to {value:.3f}", value, threshold) for clip, value in worst.items()]


def all_pass(reached: Mapping[str, float], threshold: float, what: str) -> list[Check]:
    """Return the checks that every one of the potentials passes T."""
    return [
        Check(f"{clip}: {what} {value:.3f}", value, threshold, scale=threshold, asks=f"to pass T = {threshold:g}")
        for clip, value in reached.items()
    ]


def outcome_inside(worst: Mapping[str, float], threshold: float, what: str) -> Outcome:
    """Return the outcome of a claim that asks of every clip to stay inside +-T."""
    checks = all_inside(worst, threshold, what)
    return outcome_of(checks, up_to(worst, threshold, what), largest(worst, threshold), len(worst))


def up_to(worst: Mapping[str, float], threshold: float, what: str) -> str:
    """Return how large the potentials are, in words."""
    return f"{what} up to {', '.join(f'{v:.3f} ({clip})' for clip, v in worst.items())} (T = {threshold:g})"


def largest(worst: Mapping[str, float], threshold: float) -> str:
    """Return the largest potential as a share of T, in words."""
    return f"largest {max(worst.values()) / threshold:.0%} of T"


def peaks_by_speed(rows: Rows) -> dict[float, float]:
    """Return speed -> peak HS."""
    return {row["speed"]: float(row["peak_hs"]) for row in sorted(rows, key=lambda row: row["speed"])}


def rises(rows: Rows, threshold: float, what: str) -> list[Check]:
    """Return the checks of more peak HS at each speed than at the next lower one."""
    peaks = peaks_by_speed(rows)
    return [
        exceeds(f"{what}: peak HS {peaks[fast]:.3f} at {fast:g} px/s", peaks[fast], peaks[slow], f"at {slow:g}",
                "potential", scale=threshold)
        for slow, fast in pairwise(peaks)
    ]  # fmt: skip


def outcome_of(checks: Sequence[Check], measured: str, effect: str, n: int) -> Outcome:
    """Return the outcome of the checks, with what was measured, an effect, and of how many clips."""
    return Outcome.of(checks, measured, effect, n, n)


def compared(
    of_dsnn: Sequence[Check], of_other: Sequence[Check], model: str, measured: str, effect: str, n: int
) -> Outcome:
    """Return the outcome of a claim that says one thing of the DSNN and another of a model of unknown constants.

    Parameters
    ----------
    of_dsnn
        What the claim asks of the DSNN, one check or more.
    of_other
        What it asks of the other model, or of the two held against each other, one check or more.
    model
        The label of the other model, one of `ASSUMED`.
    measured, effect, n
        As of an `Outcome`.

    Returns
    -------
    Outcome
        ``fails`` where the DSNN's half does, whatever the other model does. Otherwise it cannot be judged, whichever
        way the other half comes out with the constants assumed; `Outcome.settled` is the outcome with them.
    """
    checks = (*of_dsnn, *of_other)
    alone, decided = decide(of_dsnn)
    if not alone:
        return replace(outcome_of(of_dsnn, measured, effect, n), checks=checks)
    rest, by = decide(of_other)
    why = (
        f"the DSNN's half holds: {decided}; the rest hangs on constants of {model} that are not known, and with those "
        f"assumed {'holds' if rest else 'fails'}: {by}"
    )
    return Outcome("unknown constants", measured, effect, n, why, n, checks=checks)
