"""Claims that compare the DSNN with a model whose own constants are not known.

The paper compares the DSNN with its forerunner of 2017 and with the elementary motion detectors of Iida. It gives the
constants of neither. What is assumed of them decides how such a claim comes out, so that it cannot be refuted by them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from experiments.bench.judging.checks import Check, decide
from experiments.bench.judging.verdict import Outcome

_UNREAD = "are neither in the paper nor in any public text or code that could be searched"
ASSUMED: Mapping[str, str] = {
    "dsn2017": f"the constants of the model of 2017 (Fu and Yue 2017, IJCNN) {_UNREAD}; it is taken to be the DSNN "
    "without FDSR, with the DSNN's constants",
    "emd": f"the constants of Iida's EMD (Iida and Lambrinos 2000; Iida 2003) {_UNREAD}; a high-pass of 250 ms, a "
    "delay of 50 ms and neighbouring pixels are assumed",
}
"""Model -> what is not known of it, and what is assumed."""
WITH_THOSE = ", and with those assumed fails: "


def compared(
    own: Sequence[Check], other: Sequence[Check], model: str, measured: str, effect: str, n: int
) -> Outcome:  # fmt: skip
    """Return what a claim comes to that says one thing of the DSNN and another of a model of unknown constants.

    Parameters
    ----------
    own
        What the claim asks of the DSNN, one check or more.
    other
        What it asks of the other model, or of the two held against each other, one check or more.
    model
        The label of the other model, one of `ASSUMED`.
    measured, effect, n
        As of an `Outcome`.

    Returns
    -------
    Outcome
        ``fails`` where the DSNN's part does, whatever the other model does; ``untestable`` where the other part alone
        does, as it may hold with that model's own constants; otherwise ``holds``, with the constants assumed.
    """
    holds, decided = decide([*own, *other])
    alone, refuted = decide(own)
    if holds or not alone:
        return Outcome("holds" if holds else "fails", measured, effect, n, decided if holds else refuted, n)
    why = f"the DSNN's part holds; the rest needs constants of {model} that are not known"
    return Outcome("untestable", f"{why}{WITH_THOSE}{decided}; measured: {measured}", effect, n, each=n)


def deciding(found: Outcome) -> str:
    """Return the number that decides with the constants given, of a claim that is untestable too."""
    reason = found.measured.partition("; measured:")[0]
    return found.decided or reason.partition(WITH_THOSE)[2] or reason
