"""Parts that judges of clips share: a model's clips, its potentials against T, and models whose constants are unknown.

A judge takes a table of the clips that its claim is about, at one seed: a row for each clip and model, with the columns
of ``trials.parquet``. It takes the spiking threshold T of the DSNN too, and returns its checks.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from experiments.bench.stats.checks import Check, Needs, decide, exceeds
from experiments.bench.stats.verdict import Outcome

if TYPE_CHECKING:
    import polars as pl

Row = Mapping[str, Any]
DSNN, EARLIER, EMD = "dsnn", "dsn2017", "emd"
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
MATCHED: Mapping[str, str] = MappingProxyType({
    "dsn2017": "dsn2017:k_sig=33.22",
    "dsnn:fdsr=false": "dsnn:fdsr=false,k_sig=33.22",
    "dsnn:dog=false": "dsnn:dog=false,k_sig=0.3056",
    "emd": "emd:gain=0.7732",
})  # fmt: skip
"""Label of a model that the DSNN is compared with -> the same on equal terms.

At 30 frames a second FDSR leaves about 1/34 of a rise, so that the DSNN without it has products some 1,180 times as
large for any stimulus whatever, and a comparison of potentials compares gains. So each rival is judged a second time
with one gain, set by one rule, to four digits: its peak HS in the clip ``dark rightward`` of the experiment ``clean``
equals the DSNN's. There nothing is random and no background shifts, and no claim that compares with a rival is about
it. The gain of a model with a sigmoid is that ahead of the sigmoid, its scale K_sig, as what is behind it cannot pass
1; that of the EMD is the gain of its output. Nothing else of a rival is changed.
"""


def rows_of(clips: pl.DataFrame, model: str = DSNN, **fixed: Any) -> list[dict[str, Any]]:
    """Return the rows of a model in which columns have the ``fixed`` values, in the table's order."""
    return clips.filter(model=model, **fixed).rows(named=True)


def levels(clips: pl.DataFrame, name: str) -> list[float]:
    """Return the values of a column, each once, from the lowest up."""
    return clips[name].drop_nulls().unique().sort().to_list()


def strongest(row: Row, system: str) -> float:
    """Return the largest absolute potential of ``hs`` or ``vs`` in a clip."""
    return float(max(row[f"peak_{system}"], -row[f"trough_{system}"]))


def passes(row: Row, name: str, sign: float, threshold: float) -> Check:
    """Return the check that a clip's potential goes past T to the side of ``sign``."""
    side: Needs = "above" if sign > 0 else "below"
    return Check(f"{row['clip']}: {name} {row[name]:+.3f}", row[name], sign * threshold, side, scale=threshold)


def inside(row: Row, what: str, value: float, threshold: float) -> Check:
    """Return the check that a potential of a clip stays inside +-T."""
    return Check(f"{row['clip']}: {what} up to {value:.3f}", value, threshold, "at most", scale=threshold)


def rises(clips: pl.DataFrame, threshold: float, what: str) -> list[Check]:
    """Return the checks of more peak HS at each speed than at the next lower one."""
    return [
        exceeds(f"{what}: peak HS {more:.3f} at {fast:g} px/s", more, less, f"at {slow:g}", "potential",
                scale=threshold)
        for (slow, less), (fast, more) in pairwise(clips.sort("speed").select("speed", "peak_hs").rows())
    ]  # fmt: skip


def compared(of_dsnn: Sequence[Check], of_other: Sequence[Check], model: str) -> Outcome:
    """Return the outcome of a claim that says one thing of the DSNN and another of a model of unknown constants.

    Parameters
    ----------
    of_dsnn
        What the claim asks of the DSNN, one check or more.
    of_other
        What it asks of the other model, or of the two held against each other, one check or more.
    model
        The label of the other model, one of `ASSUMED`.

    Returns
    -------
    Outcome
        ``fails`` where the DSNN's half does, whatever the other model does. Otherwise it cannot be judged, whichever
        way the other half comes out with the constants assumed; `Outcome.settled` is the outcome with them.
    """
    whole = Outcome.of([*of_dsnn, *of_other])
    alone, decided = decide(of_dsnn)
    if not alone:
        return Outcome("fails", whole.measured, decided=decided, checks=whole.checks)
    rest, by = decide(of_other)
    why = (
        f"the DSNN's half holds: {decided}; the rest hangs on constants of {model} that are not known, and with those "
        f"assumed {'holds' if rest else 'fails'}: {by}"
    )
    return Outcome("unknown constants", whole.measured, decided=why, checks=whole.checks)
