"""C29. Count peaks in one window too."""

from __future__ import annotations

from dataclasses import replace

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import (
    ACROSS,
    Rows,
    by_level,
    mean_text,
    means,
    means_text,
    more_spikes,
    outcome_of,
)
from experiments.bench.stats.checks import Check
from experiments.bench.stats.tests import contrast
from experiments.bench.stats.verdict import Outcome

COLUMNS = ("spikes_in_window", "spikes_in_inner_window", "mean_hs_near_axis")
"""The two windows that it is judged by, and the potential, which stands beside."""


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge C15 without the time in view, at the paper's speeds alone.

    The fastest crossing is the paper's, at 10 cm/s. Its length is read both ways: from the first edge in view to the
    last edge out, and from centre in to centre out. The claim holds if it does in both windows, so that what happens
    at the edge of the view decides nothing. The potential stands beside.
    """
    fixed = {"motion": "translation", "distance_cm": 8.0, "direction": "rightward"}
    groups, inner, potential = (by_level(rows, "speed_cm_s", column, **fixed) for column in COLUMNS)
    if not {2.0, 4.0, 6.0, 10.0} <= groups.keys():
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    parts, effects = [], []
    checks: list[Check] = []
    for name, counts in (("edge to edge", groups), ("centre to centre", inner)):
        mean = means(counts)
        steps = [more_spikes(mean, more, less, "cm/s") for more, less in ((4.0, 2.0), (6.0, 4.0), (6.0, 10.0))]
        checks += [replace(check, says=f"window from {name}: {check.says}") for check in steps]
        parts.append(f"window from {name}: {means_text(counts, 'cm/s')}")
        effects.append(f"{name}, 10 against 6 cm/s: {contrast(counts[10.0], counts[6.0])}")
    why = ", ".join(f"{speed:g} cm/s: {mean_text(values, 2)}" for speed, values in potential.items())
    measured = f"rightward at 8 cm, {'; '.join(parts)}; mean HS near the axis at {why}"
    named = {speed: groups[speed] for speed in (2.0, 4.0, 6.0, 10.0)}
    return outcome_of(checks, named, measured, "; ".join(effects))


CLAIM = RobotClaim(
    id="C29",
    title="Count peaks in one window too",
    eye="It fails by the default eye too: in one time window the count rises to 10 cm/s.",
    says=(
        "read with one time window for all speeds (the paper: 'a nearly identical translating time window'), "
        "centred on the axis and as long as the fastest crossing: spikes rise 2 < 4 < 6 cm/s and are fewer at "
        "10 than at 6"
    ),
    source="robot-sys-trans and its text",
    motions=ACROSS,
    reads=COLUMNS,
    cause=(
        "There is about one spike a frame above T, so in one window for all speeds fast and slow crossings count alike."
    ),
    tried=(
        "With K_sp = 1 a frame has one spike over most of the range above T. In one window for all speeds the "
        "count is then the number of frames above T, which the potential passes throughout at 6 and at 10 cm/s "
        "alike. In the longer window there are fewer at 10, as the stimulus is hardly in view at its ends; in "
        "the shorter one there are not. The potential itself is higher at 10."
    ),
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=judge,
)
