"""Rivals on equal terms: the gain of a model that the DSNN is compared with, matched before the comparison.

At 30 frames a second FDSR leaves about 1/34 of a rise, so that the DSNN without it has products some 1,180 times as
large for any stimulus whatever. A comparison of potentials then compares gains. So each rival is shown a second time,
with one gain that is set by one rule: its peak HS in one named plain crossing equals the DSNN's in the same crossing.

The crossing is the clip ``dark rightward`` of the experiment ``clean``: a dark object on an even ground, where nothing
is random and no background shifts. No claim that compares with a rival is about it. The gain of a model with a sigmoid
is that ahead of the sigmoid, its scale K_sig, as what is behind it cannot pass 1. The gain of the EMD is that of its
output. Nothing else of a rival is changed, and its answer to the crossing is all that the gain is found from.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.bench.run.models import ConfiguredModel
    from experiments.bench.run.play import Source

CROSSING = ("clean", "dark rightward")
"""The named plain crossing: the experiment, and its clip."""
MATCHED: Mapping[str, str] = MappingProxyType({
    "dsn2017": "dsn2017:k_sig=33.22",
    "dsnn:fdsr=false": "dsnn:fdsr=false,k_sig=33.22",
    "dsnn:dog=false": "dsnn:dog=false,k_sig=0.3056",
    "emd": "emd:gain=0.7732",
})  # fmt: skip
"""Label of a rival -> the same with its gain matched, as `matched_gain` finds it, to four digits."""
WITHIN, TRIES = 1e-5, 50
"""Share of the DSNN's answer by which a matched one may differ, and steps in which that is reached."""


def crossing() -> Source:
    """Return the named plain crossing."""
    from experiments.clean import EXPERIMENT  # not before: it declares claims, and claims read this file

    return next(clip for clip in EXPERIMENT.clips if clip.name == CROSSING[1]).open(0)


def answer(model: ConfiguredModel, clip: Source) -> float:
    """Return a model's peak HS in a clip."""
    from experiments.bench.run.play import respond

    return float(respond(clip, [model]).series[0][1].hs.max())


def matched_gain(model: ConfiguredModel, target: float, clip: Source) -> float:
    """Find the gain at which a model's answer to a clip is another's.

    Parameters
    ----------
    model
        A model with a parameter ``k_sig``, or ``gain``. The value that it has is where the search begins, and decides
        nothing.
    target
        Peak HS that it is to have.
    clip
        The crossing.

    Returns
    -------
    float
        ``k_sig``, the scale of the sigmoid; or ``gain``, that of the output.

    Raises
    ------
    ValueError
        No gain gives that answer.
    """
    name, grows = ("k_sig", False) if hasattr(model.network, "k_sig") else ("gain", True)
    gain = float(getattr(model.network, name))
    for _ in range(TRIES):
        tried = dataclasses.replace(model, network=dataclasses.replace(model.network, **{name: gain}))
        ratio = answer(tried, clip) / target
        if abs(ratio - 1.0) < WITHIN:
            return gain
        if ratio <= 0.0:
            break
        gain *= 1.0 / ratio if grows else ratio
    raise ValueError(f"{model.label}: no {name} gives a peak HS of {target:g}")
