"""Whether a model's response is vision: it is compared with what the model responds to controls of the same trials.

The measures, the tests and the verdicts were fixed before any model was judged by them.

- **Direction** (a model with ``hs`` or ``vs``): the mean of the channel over the whole trial, signed along the true
  motion. That is HS where the motion is horizontal, VS where it is vertical. Trials of approach and recession do not
  count. Four paired tests: the trial as it was is above ``absent`` and above ``frozen``, and ``mirrored`` and
  ``reversed`` are below ``absent``, so that the sign has turned.
- **Looming** (a model with ``looming``): the largest potential of the trial; only approaches count. Two paired tests:
  the approach is above its reverse and above ``absent``. A third, of the reverse above ``absent``, is for the verdict
  *wrong sign* alone.

Each is Wilcoxon's exact signed-rank test over trials, two-sided. P values are corrected by Holm's method over the tests
of a model. A test passes if the mean difference reaches the margin of claims (0.002 for potentials) and p is below 5 %.

- **sees**: all pass. It is not enough for vision of motion: a change of brightness that has the right sign passes too.
- **wrong sign**: the same with every sign against; of looming, the reverse is above the approach and above ``absent``.
- **not judged**: no trial has motion that a channel is for, nothing is random, or there are fewer than 8 pairs, which
  cannot reach 5 % after Holm.
- **blind**: anything else. The difference that would be found in 80 % of such runs stands beside it.

``shuffled`` is shown and not judged: frames in a drawn order flicker, and a model that responds to that may see well.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl

from experiments.declare.outcome import MARGIN
from experiments.judge.tests import LEVEL, Floats, holm, p_text, paired, written
from experiments.settings.models import CONTROLS, ConfiguredModel, parse_label

SHOWN = "shown"
"""The trial as it was, beside the names of controls."""
SEES, WRONG, UNJUDGED, BLIND = "sees", "wrong sign", "not judged", "blind"
LEAST_PAIRS, POWER = 8, 0.8
WAYS = {"rightward": ("hs", 1), "leftward": ("hs", -1), "downward": ("vs", 1), "upward": ("vs", -1)}
"""True motion -> the channel that is for it, and its sign."""
TESTS: Mapping[str, Sequence[tuple[str, str]]] = {
    "direction": ((SHOWN, "absent"), (SHOWN, "frozen"), ("absent", "mirrored"), ("absent", "reversed")),
    "looming": ((SHOWN, "reversed"), (SHOWN, "absent"), ("reversed", "absent")),
}
"""Kind of response -> pairs of which a model that sees has the first above the second."""
SIGNS: Mapping[str, Mapping[str, Sequence[int]]] = {
    SEES: {"direction": (1, 1, 1, 1), "looming": (1, 1, 0)},
    WRONG: {"direction": (-1, -1, -1, -1), "looming": (-1, 0, 1)},
}
"""Word -> kind of response -> the sign that each test needs; 0: any."""
MEANS = (SHOWN, *CONTROLS)
COLUMNS: dict[str, type] = {
    "model": str, "response": str, "word": str, "says": str, "n": int, **dict.fromkeys(MEANS, float), "p": float,
    "detectable": float,
}  # fmt: skip
"""Columns of ``controls.csv``: see `experiments.Run.controls`."""


def measured(
    frames: pl.DataFrame, ways: Mapping[int, str], models: Sequence[ConfiguredModel]
) -> dict[tuple[str, str], Floats]:
    """Measure each kind of response of each model to the trials and their controls.

    Parameters
    ----------
    frames
        ``frames.parquet`` with controls.
    ways
        Trial -> its true motion: a direction, ``looming``, or what no response is for.
    models
        The models.

    Returns
    -------
    dict
        Model and kind of response -> (n, 6): the measure of each trial that the kind is for, in the order of `MEANS`.
    """
    found = {}
    for model in models:
        own = {name: _means(frames, model.label, name) for name in MEANS}
        for kind, channels in (("direction", ("hs", "vs")), ("looming", ("looming",))):
            if not {*channels} & {*model.channels}:
                continue
            values = ([_measure(own[name].get(trial), way, kind, model) for name in MEANS]
                      for trial, way in ways.items())  # fmt: skip
            whole = [row for row in values if None not in row]
            found[model.label, kind] = np.array(whole, float).reshape(-1, len(MEANS))
    return found


def numbers(frames: pl.DataFrame, models: Sequence[ConfiguredModel]) -> list[dict[str, Any]]:
    """Return what models responded to footage and its controls, without a word: nobody knows what truly moved."""
    rows = []
    for model in models:
        own = {name: _means(frames, model.label, name) for name in MEANS}
        for channel in (channel for channel in ("hs", "vs", "looming") if channel in model.channels):
            means = {name: trials[0][channel] for name, trials in own.items() if 0 in trials}
            rows.append({**dict.fromkeys(COLUMNS), "model": model.label, "response": channel, "n": 1, **means})
    return rows


def _means(frames: pl.DataFrame, model: str, control: str) -> dict[int, dict[str, float]]:
    """Return trial -> mean HS and VS, and the largest looming potential, of a model before a control."""
    label = model if control == SHOWN else parse_label(model).controlled(control)
    table = frames.filter(model=label).group_by("trial").agg(pl.col("hs", "vs").mean(), pl.col("looming").max())
    return {row.pop("trial"): row for row in table.to_dicts()}


def _measure(means: Mapping[str, float] | None, way: str, kind: str, model: ConfiguredModel) -> float | None:
    """Return the measure of a trial; ``None`` where the kind of response is not for its motion, or it is missing."""
    channel, sign = ("looming", 1) if kind == way == "looming" else WAYS.get(way, ("", 0))
    wanted = channel in model.channels and (channel == "looming") == (kind == "looming")
    return sign * means[channel] if means is not None and wanted else None


def word_of(values: Floats, kind: str, *, random: bool = True) -> dict[str, Any]:
    """Return the columns of `COLUMNS` about a kind of response, from its measures as `measured` has them.

    ``random`` is whether anything differs between trials of a condition.
    """
    by_name, n = dict(zip(MEANS, values.T, strict=True)), len(values)
    row: dict[str, Any] = {"n": n, "p": None, "detectable": None}
    row |= {name: float(measured.mean()) if n else None for name, measured in by_name.items()}
    reasons = {"no trial has such motion and all controls": n == 0, "nothing is random": not random,
               f"needs {LEAST_PAIRS}": n < LEAST_PAIRS}  # fmt: skip
    if why := next((reason for reason, holds in reasons.items() if holds), ""):
        return {**row, "word": UNJUDGED, "says": f"{n} pairs: {why}"}
    pairs = [(by_name[first], by_name[second]) for first, second in TESTS[kind]]
    p_values = holm([paired(first, second).p for first, second in pairs])
    differences = [float((first - second).mean()) for first, second in pairs]
    found = [int(np.sign(difference)) if abs(difference) >= MARGIN["potential"] and p < LEVEL else 0
             for difference, p in zip(differences, p_values, strict=True)]  # fmt: skip
    whole = {word: zip(signs[kind], found, strict=True) for word, signs in SIGNS.items()}
    word = next((word for word, pairs in whole.items() if all(sign in (0, there) for sign, there in pairs)), BLIND)
    texts = [f"{first} - {second} {written(difference)} ({p_text(p, 0.0)})"
             for (first, second), difference, p in zip(TESTS[kind], differences, p_values, strict=True)]  # fmt: skip
    detectable = max(_detectable(first - second, len(pairs)) for first, second in pairs)
    power = f"; a difference of {written(detectable)} would be found in {POWER:.0%} of such runs"
    says = "; ".join(texts) + (power if word == BLIND else "")
    decisive = max(p for p, sign in zip(p_values, SIGNS.get(word, SIGNS[SEES])[kind], strict=True) if sign)
    return {**row, "p": decisive, "detectable": detectable, "word": word, "says": says}


def _detectable(differences: Floats, tests: int) -> float:
    """Return the mean difference that so many pairs show with a chance of `POWER` at Holm's strictest level."""
    from scipy import special  # not before: it takes its time to load

    reach = float(special.ndtri(1 - LEVEL / (2 * tests)) + special.ndtri(POWER))
    return max(reach * float(differences.std(ddof=1)) / math.sqrt(differences.size), MARGIN["potential"])
