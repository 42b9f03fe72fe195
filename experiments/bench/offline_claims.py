"""What the paper reports of its off-line tests, as checks on the rows of clips.

A claim is judged on the clips that its words are about, at one seed. It never bends a bound: a claim that misses it
fails, and the verdict says by how much.

A claim's least number is every combination of `CONDITIONS`, each once: the same clip gives the same answer, so a
repeat adds nothing. Where a background is random, a seed is one photograph's one part, as the paper shows one; how
many seeds agree is reported beside the verdict.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import product
from typing import Any

from experiments.bench import offline_judges as judges
from experiments.bench.checks import Outcome, is_number, unreadable
from experiments.bench.offline_judges import BLOCKED, DSNN, EARLIER, EMD, Rows
from experiments.bench.offline_judges import SIGNED as SIGNED

POTENTIALS = ("peak_hs", "trough_hs", "peak_vs", "trough_vs")
SHADES = ("dark", "light")
LEAST_GREYS = 5

EVERY = ()
"""Of a column of `CONDITIONS`: each level that is there."""

_BACKGROUNDS, _CONTRAST_SPEEDS = (-2.0, -4.0, -6.0, -8.0, -10.0), (40.0, 60.0, 80.0, 100.0, 120.0)
_CROSSING: Mapping[str, tuple[Any, ...]] = {"motion": ("rightward",)}
CONDITIONS: Mapping[str, Mapping[str, tuple[Any, ...]]] = {
    "C1": {"motion": tuple(SIGNED), "shade": SHADES},
    "C2": {"motion": tuple(SIGNED), "shade": SHADES},
    "C3": {"motion": ("looming", "receding"), "shade": SHADES},
    "C4": {"motion": tuple(SIGNED)},
    "C5": {"motion": ("looming", "receding"), "background_speed": (8.0,)},
    "C6": {**_CROSSING, "background_speed": (-8.0,)},
    "C7": {**_CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": _BACKGROUNDS, "grey": EVERY},
    "C8": {**_CROSSING, "speed": (40.0, 80.0, 120.0), "background_speed": _BACKGROUNDS, "shade": SHADES},
    "C9": {**_CROSSING, "background_speed": (-8.0,), "speed": _CONTRAST_SPEEDS, "grey": EVERY},
    "C10": {**_CROSSING, "background_speed": (-8.0,), "speed": _CONTRAST_SPEEDS, "grey": EVERY},
    "C11": {**_CROSSING, "background_speed": (-8.0,), "speed": _CONTRAST_SPEEDS, "grey": EVERY},
}
"""Claim -> the values of clips that its words name, or the paper's text on its figure; other clips do not count.

``shade`` is dark or light, against what the object passes.
"""

OF_EVERY_CLIP = frozenset({"C1", "C2", "C3", "C4", "C5", "C6", "C8"})
"""Claims about every single clip: one that breaks them refutes them, whichever others are missing."""

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
    "C1": judges.c1, "C2": judges.c2, "C3": judges.c3, "C4": judges.c4, "C5": judges.c5, "C6": judges.c6,
    "C7": judges.c7, "C8": judges.c8, "C9": judges.c9, "C10": judges.c10, "C11": judges.c11,
}  # fmt: skip


def judge(claim: str, rows: Rows, thresholds: Mapping[str, float | None]) -> Outcome:
    """The verdict of one claim on the rows of one seed; ``thresholds`` are the models'."""
    needed = NEEDED[claim]
    missing = sorted(needed - {row["model"] for row in rows})
    if missing:
        return Outcome("untested", f"needs {' and '.join(missing)}")
    threshold = thresholds[DSNN]
    if threshold is None:
        return Outcome("untested", "this model does not spike")
    own = [row for row in rows if row["model"] in needed and _is_about(claim, row)]
    without = _unanswered(own, needed) or unreadable(own, POTENTIALS)
    if without:
        return Outcome("untested", f"of the clips {without}", n=len(own))
    lacking = _lacking(claim, own)
    if lacking and not (own and claim in OF_EVERY_CLIP):
        return Outcome("untested", lacking)
    found = JUDGES[claim](own, threshold)
    return found.untested(lacking) if lacking and found.verdict == "holds" else found


def _is_about(claim: str, row: Mapping[str, Any]) -> bool:
    """Whether a claim's words are about what a row was shown."""
    if row["object"] == "absent":
        return claim == "C11" and row["background_speed"] in CONDITIONS[claim]["background_speed"]
    return all(_value(row, name) in values for name, values in CONDITIONS[claim].items() if values != EVERY)


def _value(row: Mapping[str, Any], name: str) -> Any:
    """A column's value, or of ``shade`` what the object is against its ground; ``None`` if neither, or unknown."""
    if name != "shade":
        return row[name]
    if not (is_number(row["grey"]) and is_number(row["background_mean"])) or row["grey"] == row["background_mean"]:
        return None
    return SHADES[row["grey"] > row["background_mean"]]


def _unanswered(rows: Rows, models: frozenset[str]) -> str:
    """Clips to which a model has no row, as it failed there, in words; empty if none."""
    clips = list(dict.fromkeys(row["clip"] for row in rows))
    there = {(row["model"], row["clip"]) for row in rows}
    lost = {model: [clip for clip in clips if (model, clip) not in there] for model in sorted(models)}
    return "; ".join(f"{', '.join(names)} has no answer of {model}" for model, names in lost.items() if names)


def _lacking(claim: str, rows: Rows) -> str:
    """What the claim's words name and no clip shows, in words; empty if all is there."""
    present = [row for row in rows if row["object"] != "absent"]
    wanted = {
        name: values or tuple(sorted({row[name] for row in present if row[name] is not None}))
        for name, values in CONDITIONS[claim].items()
    }
    there = {tuple(_value(row, name) for name in wanted) for row in present}
    names = [" ".join(map(_said, wanted, combination)) for combination in product(*wanted.values())
             if combination not in there]  # fmt: skip
    if names or not present:
        more = f" and {len(names) - 1} more" if len(names) > 1 else ""
        return f"needs clips of {names[0] if names else 'an object'}{more}"
    if claim in ("C9", "C10") and len(wanted["grey"]) < LEAST_GREYS:
        return f"needs at least {LEAST_GREYS} grey levels (has {len(wanted['grey'])})"
    if claim == "C11" and len(present) == len(rows):
        return "needs clips of the background alone"
    return ""


def _said(name: str, value: Any) -> str:
    unit = {"speed": "at {:g} px/s", "background_speed": "before {:g} px/s", "grey": "of grey {:g}"}.get(name)
    return unit.format(value) if unit else str(value)
