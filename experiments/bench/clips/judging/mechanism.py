"""The judges of the claims about mechanisms: edges, apparent motion, ensembles, speed, removal of background.

They take what those of `experiments.bench.clips.judging.paper` take.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from experiments.bench.clips.judging.assumed import compared
from experiments.bench.clips.judging.paper import (
    BLOCKED,
    DSNN,
    EMD,
    Rows,
    levels,
    outcome,
    rises,
    rows_of,
    shown,
    strongest,
)
from experiments.bench.judging.verdict import Check, Outcome

FEWER = ("dsnn:n_con=1", "dsnn:n_con=2")
"""The DSNN with smaller ensembles, of one and of two connected cells, as ``--model`` names them."""
WITHOUT = ("dsnn:dog=false", "dsnn:fdsr=false")
"""The DSNN without the lamina's difference of Gaussians, and without the adaptation after it."""
SAME, OPPOSITE = ("on-on", "off-off"), ("on-off", "off-on")
"""Two steps of one sign, and of opposite signs."""
MOST_OF_DRIVEN, LEAST_OF_OTHER = 0.05, 0.95
MOST_OF_OPPOSITE = 0.1
LEAST_FACTOR = 2.0
_DRIVEN = {"on": "dsnn-on-blocked", "off": "dsnn-off-blocked"}
"""An edge's polarity -> the model in which the pathway that it drives is blocked."""


def c22(rows: Rows, threshold: float) -> Outcome:
    """One edge in view: what each blocked pathway leaves of the largest |HS|.

    An OFF edge is the leading one of a dark object and the trailing one of a light object, an ON edge the reverse.
    """
    said, checks = [], []
    for whole in rows_of(rows):
        clip, intact = whole["clip"], strongest(whole, "hs")
        driven = _DRIVEN[whole["polarity"]]
        (other,) = (model for model in BLOCKED if model != driven)
        shares = [strongest(rows_of(rows, model, clip=clip)[0], "hs") / intact if intact else float("nan")
                  for model in (driven, other)]  # fmt: skip
        bounds = f"under {MOST_OF_DRIVEN:.0%}", f"over {LEAST_OF_OTHER:.0%}"
        slacks = MOST_OF_DRIVEN - shares[0], shares[1] - LEAST_OF_OTHER
        for model, share, bound, slack in zip((driven, other), shares, bounds, slacks, strict=True):
            checks.append(Check(f"{clip}: {model} leaves {share:.1%} of |HS| {intact:.3f} (needs {bound})", slack))
        said.append(f"{clip}: |HS| {intact:.3f}, {driven} {shares[0]:.1%}, {other} {shares[1]:.1%}")
    good = sum(all(check.passes for check in checks[i : i + 2]) for i in range(0, len(checks), 2))
    return outcome(checks, "; ".join(said), f"{good} of {len(said)} edges", len(said))


def c23(rows: Rows, threshold: float) -> Outcome:
    """Steps of one sign: the strongest HS has the direction's sign. Of opposite signs: |HS| is under a share of it.

    That share is of the weaker of both answers to steps of one sign, in the same direction with the same delay. How
    much of HS tells the direction is said too: half the difference of its strongest values in both directions.
    """
    own = rows_of(rows)
    counts = {len(_of_pair(own, motion, pair)) for motion in ("rightward", "leftward") for pair in (*SAME, *OPPOSITE)}
    if len(counts) > 1:
        return Outcome("untested", "needs as many clips of every pair of steps in both directions")
    checks, worst = [], ""
    highest = 0.0
    for motion, sign in (("rightward", 1.0), ("leftward", -1.0)):
        answers = {pair: [_signed(row) for row in _of_pair(own, motion, pair)] for pair in (*SAME, *OPPOSITE)}
        for pair in SAME:
            for hs in answers[pair]:
                needs = f"{motion} {pair}: strongest HS {hs:+.3f} (needs the sign of {sign:+g})"
                checks.append(Check(needs, sign * hs / threshold))
        for pair in OPPOSITE:
            for index, hs in enumerate(answers[pair]):
                least = min(abs(answers[each][index]) for each in SAME)
                share = abs(hs) / least if least else float("nan")
                needs = f"{motion} {pair}: |HS| {abs(hs):.3f}, {share:.0%} of {least:.3f} for one sign"
                checks.append(Check(f"{needs} (needs under {MOST_OF_OPPOSITE:.0%})", MOST_OF_OPPOSITE - share))
                if not worst or share > highest:
                    highest, worst = share, f"{motion} {pair}"
    means = {pair: _directional(own, pair) for pair in (*SAME, *OPPOSITE)}
    told = ", ".join(f"{pair} {mean:+.4f}" for pair, mean in means.items())
    one_sign = ", ".join(f"{row['clip']} {_signed(row):+.3f}" for pair in SAME for row in rows_of(own, polarity=pair))
    measured = (
        f"strongest HS of one sign: {one_sign}; of opposite signs |HS| up to {highest:.0%} of it ({worst}); "
        f"of this the direction makes (half of rightward less leftward): {told}"
    )
    least = min(abs(means[pair]) for pair in SAME)
    part = f"{max(abs(means[pair]) for pair in OPPOSITE) / least:.1%}" if least else "no share"
    return outcome(checks, measured, f"opposite signs: {part} of the part that tells direction", len(own))


def _of_pair(rows: Rows, motion: str, pair: str) -> list[Mapping[str, Any]]:
    return rows_of(rows, motion=motion, polarity=pair)


def _signed(row: Mapping[str, Any]) -> float:
    """The HS of largest size, with its sign."""
    return float(row["peak_hs"] if row["peak_hs"] >= -row["trough_hs"] else row["trough_hs"])


def _directional(rows: Rows, pair: str) -> float:
    """Half of what the strongest HS to the right is above that to the left, meaned over what else differs."""
    ways = [[_signed(row) for row in _of_pair(rows, motion, pair)] for motion in ("rightward", "leftward")]
    return sum(ways[0]) / len(ways[0]) / 2 - sum(ways[1]) / len(ways[1]) / 2


def c24_clips(rows: Rows, threshold: float) -> Outcome:
    """The off-line part: every clip of the contrast grid. The robot's speeds are judged with its trials."""
    grid = {model: {row["clip"]: float(row["peak_hs"]) for row in shown(rows, model)} for model in (DSNN, *FEWER)}
    checks = [
        Check(f"{clip}: peak HS {peak:.3f} (needs more than {grid[model][clip]:.3f} of {model})",
              (peak - grid[model][clip]) / threshold)
        for model in FEWER
        for clip, peak in grid[DSNN].items()
    ]  # fmt: skip
    above = {model: sum(peak > threshold for peak in peaks.values()) for model, peaks in grid.items()}
    for model in FEWER:
        needs = f"passes T in {above[DSNN]} clips (needs more than {above[model]} of {model})"
        checks.append(Check(needs, float(above[DSNN] - above[model])))
    said = "; ".join(
        f"{model} {min(peaks.values()):.3f} to {max(peaks.values()):.3f}, past T in {above[model]} of {len(peaks)}"
        for model, peaks in grid.items()
    )
    return outcome(checks, f"off-line part, peak HS: {said} (T = {threshold:g})", "", len(grid[DSNN]))


def c26(rows: Rows, threshold: float) -> Outcome:
    """At every step of speed, or not at every one.

    The DSNN's peaks are of HS, as in C9; the EMD's of |HS|, as in C11: the background drives its HS the other way.
    """
    greys = levels(shown(rows), "grey")
    peaks: dict[str, Rows] = {
        DSNN: shown(rows),
        EMD: [{**row, "peak_hs": strongest(row, "hs")} for row in shown(rows, EMD)],
    }
    checks: dict[str, list[Check]] = {DSNN: [], EMD: []}
    rising, said = {}, []
    for model, own in peaks.items():
        of = ", of |HS|" if model == EMD else ""
        series = {
            grey: rises(rows_of(own, model, grey=grey), threshold, f"{model}, grey {grey:g}{of}") for grey in greys
        }
        rising[model] = [grey for grey, steps in series.items() if all(step.passes for step in steps)]
        for grey, steps in series.items():
            if model == DSNN or grey in (greys[0], greys[-1]):
                checks[model] += steps
            else:
                least = min(step.slack for step in steps)
                needs = f"{model}, grey {grey:g}: least step of the peak with speed {least * threshold:+.4f}"
                checks[model].append(Check(f"{needs} (needs 0 or less)", -least, strict=False))
        ranges = ", ".join(f"{grey:g}: {_span(rows_of(own, model, grey=grey))}" for grey in greys)
        throughout = ", ".join(f"{grey:g}" for grey in rising[model]) or "none"
        said.append(
            f"{model}'s peak rises at every step of speed for greys {throughout} (from slowest to fastest {ranges})"
        )
    effect = f"{len(rising[DSNN])} and {len(rising[EMD])} of {len(greys)} greys"
    return compared(checks[DSNN], checks[EMD], EMD, "; ".join(said), effect, len(shown(rows)))


def _span(rows: Rows) -> str:
    """The peaks at the lowest speed and at the highest."""
    slow, *_, fast = sorted(rows, key=lambda row: row["speed"])
    return f"{slow['peak_hs']:.3f} to {fast['peak_hs']:.3f}"


def c27(rows: Rows, threshold: float) -> Outcome:
    """Each of |HS| and |VS|, without the one and without the other, in every clip of the background alone."""
    checks: list[Check] = []
    factors: dict[tuple[str, str], list[float]] = {(model, system): [] for model in WITHOUT for system in ("hs", "vs")}
    for whole in rows_of(rows):
        clip = whole["clip"]
        for (model, system), found in factors.items():
            kept, left = strongest(whole, system), strongest(rows_of(rows, model, clip=clip)[0], system)
            found.append(left / kept if kept else float("nan"))
            said = f"{clip}: |{system.upper()}| {left:.4f} of {model}, {found[-1]:.2f} times {kept:.4f}"
            checks.append(
                Check(f"{said} (needs {LEAST_FACTOR:g} times or more)", found[-1] - LEAST_FACTOR, strict=False)
            )
    measured = "; ".join(
        f"{model}: |{system.upper()}| {min(found):.3g} to {max(found):.3g} times"
        for (model, system), found in factors.items()
    )
    least = min(min(found) for found in factors.values())
    return outcome(checks, measured, f"at least {least:.3g} times", len(rows_of(rows)))
