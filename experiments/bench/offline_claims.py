"""What the paper reports of its off-line tests, as checks on the rows of clips.

Each judge takes the rows of one seed, of all models, and their thresholds. It never bends a bound: a claim that
misses it fails, and the verdict says by how much.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from experiments.bench.claims import Outcome

Rows = Sequence[Mapping[str, Any]]
DSNN, EARLIER, EMD = "dsnn", "dsn2017", "emd"
SIGNED = {
    "rightward": ("peak_hs", 1),
    "leftward": ("trough_hs", -1),
    "downward": ("peak_vs", 1),
    "upward": ("trough_vs", -1),
}
"""Direction -> the extreme that answers it, and its sign."""
HALF = (0.4, 0.6)
BLOCKED = ("dsnn-on-blocked", "dsnn-off-blocked")
SUM_TOLERANCE = 1e-3


def judge(claim: str, rows: Rows, thresholds: Mapping[str, float | None]) -> Outcome:
    """The verdict of one claim on the rows of one seed; ``thresholds`` are the models'."""
    needed = NEEDED[claim]
    missing = sorted(needed - {row["model"] for row in rows})
    if missing:
        return Outcome("untested", f"needs {' and '.join(missing)}")
    threshold = thresholds[DSNN]
    if threshold is None:
        return Outcome("untested", "this model does not spike")
    return JUDGES[claim](rows, threshold)


def _of(rows: Rows, model: str = DSNN, **fixed: Any) -> list[Mapping[str, Any]]:
    return [row for row in rows if row["model"] == model and all(row[k] == v for k, v in fixed.items())]


def _strongest(row: Mapping[str, Any], system: str) -> float:
    return float(max(row[f"peak_{system}"], -row[f"trough_{system}"]))


def _outcome(holds: bool, measured: str, effect: str, n: int) -> Outcome:
    return Outcome("holds" if holds else "fails", measured, effect, n)


def _object(row: Mapping[str, Any]) -> str:
    """Dark or light, against what it passes."""
    return "dark" if row["grey"] < row["background_mean"] else "light"


def _c1(rows: Rows, threshold: float) -> Outcome:
    chosen = [row for row in _of(rows) if row["motion"] in SIGNED]
    said, good = [], []
    for row in chosen:
        name, sign = SIGNED[row["motion"]]
        good.append(sign * row[name] > threshold)
        said.append(f"{row['clip']} {row[name]:+.3f}")
    measured = f"{', '.join(said)} (T = {threshold:g})"
    return _outcome(bool(good) and all(good), measured, f"{sum(good)} of {len(good)} clips", len(good))


def _c2(rows: Rows, threshold: float) -> Outcome:
    chosen = [row for row in _of(rows) if row["motion"] in SIGNED]
    worst = {row["clip"]: _strongest(row, "vs" if "hs" in SIGNED[row["motion"]][0] else "hs") for row in chosen}
    return _inside(worst, threshold, "the orthogonal system")


def _c3(rows: Rows, threshold: float) -> Outcome:
    chosen = [row for row in _of(rows) if row["motion"] in ("looming", "receding")]
    worst = {row["clip"]: max(_strongest(row, "hs"), _strongest(row, "vs")) for row in chosen}
    return _inside(worst, threshold, "HS and VS")


def _inside(worst: Mapping[str, float], threshold: float, what: str) -> Outcome:
    """Every one of the potentials inside +-T."""
    if not worst:
        return Outcome("untested", "no such clip was shown")
    measured = f"{what} up to {', '.join(f'{v:.3f} ({clip})' for clip, v in worst.items())} (T = {threshold:g})"
    good = [value <= threshold for value in worst.values()]
    return _outcome(all(good), measured, f"largest {max(worst.values()) / threshold:.0%} of T", len(good))


def _c4(rows: Rows, threshold: float) -> Outcome:
    said, good = [], []
    for whole in _of(rows):
        peaks = [row[SIGNED[whole["motion"]][0]] for m in BLOCKED for row in _of(rows, m, clip=whole["clip"])]
        intact = whole[SIGNED[whole["motion"]][0]]
        shares = [peak / intact for peak in peaks]
        rest = abs(sum(peaks) - intact)
        good.append(len(shares) == 2 and all(HALF[0] <= share <= HALF[1] for share in shares) and rest < SUM_TOLERANCE)
        said.append(f"{whole['clip']}: ON blocked {shares[0]:.0%}, OFF blocked {shares[1]:.0%}, sum off by {rest:.1e}")
    return _outcome(bool(good) and all(good), "; ".join(said), f"{sum(good)} of {len(good)} clips", len(good))


def _c5(rows: Rows, threshold: float) -> Outcome:
    worst = {row["clip"]: max(_strongest(row, "hs"), _strongest(row, "vs")) for row in _of(rows)}
    earlier = [max(_strongest(row, "hs"), _strongest(row, "vs")) for row in _of(rows, EARLIER)]
    inside = _inside(worst, threshold, "HS and VS")
    holds = inside.verdict == "holds" and min(earlier) > threshold
    return _outcome(holds, f"{inside.measured}; {EARLIER} {min(earlier):.2f} or more", inside.effect, len(worst))


def _c6(rows: Rows, threshold: float) -> Outcome:
    hs = {row["clip"]: row["peak_hs"] for row in _of(rows)}
    vs = {row["clip"]: _strongest(row, "vs") for row in _of(rows)}
    earlier = [_strongest(row, "vs") for row in _of(rows, EARLIER)]
    good = [hs[clip] > threshold and vs[clip] <= threshold for clip in hs]
    said = ", ".join(f"{clip}: HS {hs[clip]:.3f}, VS up to {vs[clip]:.3f}" for clip in hs)
    measured = f"{said}; {EARLIER} VS {min(earlier):.2f} or more (T = {threshold:g})"
    return _outcome(all(good) and min(earlier) > threshold, measured, f"{sum(good)} of {len(good)} clips", len(good))


def _levels(rows: Rows, name: str) -> list[float]:
    return sorted({row[name] for row in rows if row[name] is not None})


def _c7(rows: Rows, threshold: float) -> Outcome:
    """The spread over background speeds is the largest peak less the smallest, meaned over objects and speeds."""
    own = _of(rows)
    rising, least, spreads = [], [], {}
    for grey in _levels(own, "grey"):
        for behind in _levels(own, "background_speed"):
            peaks = [_of(own, grey=grey, background_speed=behind, speed=s)[0]["peak_hs"] for s in _levels(own, "speed")]
            rising.append(all(a < b for a, b in pairwise(peaks)))
            least.append(min(np.diff(peaks)))
    for model in (DSNN, EARLIER):
        chosen = _of(rows, model)
        spreads[model] = float(
            np.mean(
                [
                    np.ptp([row["peak_hs"] for row in _of(chosen, model, grey=grey, speed=speed)])
                    for grey in _levels(chosen, "grey")
                    for speed in _levels(chosen, "speed")
                ]
            )
        )
    measured = (
        f"peak HS rises with speed in {sum(rising)} of {len(rising)} series, by {min(least):+.3f} or more a step; "
        f"over background speeds it varies by {spreads[DSNN]:.4f}, {EARLIER}'s by {spreads[EARLIER]:.4f}"
    )
    means = [np.mean([row["peak_hs"] for row in _of(own, speed=speed)]) for speed in _levels(own, "speed")]
    effect = f"mean peaks {', '.join(f'{mean:.3f}' for mean in means)}"
    return _outcome(all(rising) and spreads[DSNN] < spreads[EARLIER], measured, effect, len(own))


def _c8(rows: Rows, threshold: float) -> Outcome:
    own = _of(rows)
    worst = max(own, key=lambda row: row["peak_vs"])
    measured = f"peak VS up to {worst['peak_vs']:.3f} ({worst['clip']}) in {len(own)} clips (T = {threshold:g})"
    return _outcome(worst["peak_vs"] < threshold, measured, f"{worst['peak_vs'] / threshold:.0%} of T", len(own))


def _shown(rows: Rows, model: str = DSNN) -> list[Mapping[str, Any]]:
    return _of(rows, model, object="present")


def _c9(rows: Rows, threshold: float) -> Outcome:
    own = _shown(rows)
    said, good = [], []
    for grey in _levels(own, "grey"):
        peaks = [row["peak_hs"] for speed in _levels(own, "speed") for row in _of(own, grey=grey, speed=speed)]
        good.append(all(a < b for a, b in pairwise(peaks)))
        said.append(f"{grey:g}: {', '.join(f'{peak:.3f}' for peak in peaks)}")
    effect = f"{sum(good)} of {len(good)} greys rise throughout"
    return _outcome(bool(good) and all(good), f"peak HS by speed, of grey {'; '.join(said)}", effect, len(own))


def _c10(rows: Rows, threshold: float) -> Outcome:
    own = _shown(rows)
    greys = _levels(own, "grey")
    mean = {grey: float(np.mean([row["peak_hs"] for row in _of(own, grey=grey)])) for grey in greys}
    ground = float(np.mean([row["background_mean"] for row in own]))
    nearest = min(greys, key=lambda grey: abs(grey - ground))
    peaks, middle = [mean[grey] for grey in greys], greys.index(nearest)
    falls = all(a > b for a, b in pairwise(peaks[: middle + 1]))
    rises = all(a < b for a, b in pairwise(peaks[middle:]))
    measured = (
        f"mean peak HS {', '.join(f'{mean[grey]:.3f} at grey {grey:g}' for grey in greys)}; "
        f"the background's mean is {ground:.0f}, nearest {nearest:g}"
    )
    lowest = min(mean, key=lambda grey: mean[grey])
    return _outcome(falls and rises, measured, f"lowest at grey {lowest:g}", len(own))


def _c11(rows: Rows, threshold: float) -> Outcome:
    """A model separates translations from background where its weakest answer to one beats every background's.

    Answers are the largest abs(HS) of a clip; of the background-only clips, of all there are.
    """
    said, separates = [], {}
    for model, speeds in ((EMD, (40.0, 60.0)), (DSNN, None)):
        behind = [_strongest(row, "hs") for row in _of(rows, model, object="absent")]
        moved = [_strongest(row, "hs") for row in _shown(rows, model) if speeds is None or row["speed"] in speeds]
        if not behind or not moved:
            return Outcome("untested", "needs clips of the background alone")
        separates[model] = min(moved) > max(behind)
        above = float(np.mean([value > max(behind) for value in moved]))
        said.append(
            f"{model}: {min(moved):.3f} to {max(moved):.3f} with an object, up to {max(behind):.3f} without "
            f"({above:.0%} above)"
        )
    measured = f"|HS| of {said[0]} at 40 and 60 px/s; of {said[1]} at all speeds"
    return _outcome(separates[DSNN] and not separates[EMD], measured, "", len(_shown(rows)))


NEEDED: Mapping[str, frozenset[str]] = {
    "C1": frozenset({DSNN}),
    "C2": frozenset({DSNN}),
    "C3": frozenset({DSNN}),
    "C4": frozenset({DSNN, *BLOCKED}),
    "C5": frozenset({DSNN, EARLIER}),
    "C6": frozenset({DSNN, EARLIER}),
    "C7": frozenset({DSNN, EARLIER}),
    "C8": frozenset({DSNN}),
    "C9": frozenset({DSNN}),
    "C10": frozenset({DSNN}),
    "C11": frozenset({DSNN, EMD}),
}
"""Claim -> the models it takes."""

JUDGES: Mapping[str, Callable[[Rows, float], Outcome]] = {
    "C1": _c1, "C2": _c2, "C3": _c3, "C4": _c4, "C5": _c5, "C6": _c6, "C7": _c7, "C8": _c8, "C9": _c9, "C10": _c10,
    "C11": _c11,
}  # fmt: skip
