"""What the paper reports of the robot, as checks on a run's trials.

The claims' words are those of ``claims.toml`` beside this file. A judge never bends a bound: a claim that misses
it fails, and the verdict says by how much. A new claim is its words there, a judge in `JUDGES`, and its lines in
`MOTIONS`, `READS` and `LEAST`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from experiments.bench import robot_judges as judges
from experiments.bench.checks import Outcome as Outcome
from experiments.bench.checks import is_number, unreadable
from experiments.bench.paper import claim_texts
from experiments.bench.robot_judges import Rows

SPEED_TOLERANCE, PATH_TOLERANCE_MM = 0.02, 1.0


@dataclass(frozen=True, slots=True)
class Verdict:
    """A claim's answer: ``measured`` says the numbers, ``effect`` the test and its effect size.

    ``decided`` has the number that decided and its bound: of a claim that fails the worst that misses its bound, of
    one that holds the nearest to it. Empty where the claim is untested.
    """

    id: str
    model: str
    says: str
    source: str
    verdict: Literal["holds", "fails", "untested"]
    measured: str
    effect: str
    n: int
    decided: str = ""


def judge(claim: str, rows: Rows, threshold: float | None, model: str = "dsnn") -> Verdict:
    """The verdict of one claim on one model's trials; ``threshold`` is that model's spiking threshold, if any."""
    says, source = claim_texts()[claim]
    found = _outcome(claim, rows, threshold)
    return Verdict(
        claim, model, says, source, found.verdict, found.measured, found.effect, found.n, found.decided
    )  # fmt: skip


def _outcome(claim: str, rows: Rows, threshold: float | None) -> Outcome:
    if claim not in JUDGES:
        return Outcome("untested", "no judge for this claim yet")
    if threshold is None:
        return Outcome("untested", "this model does not spike")
    own = [row for row in rows if row["motion"] in MOTIONS[claim]]
    without = unreadable(own, READS[claim])
    if without:
        return Outcome("untested", f"of the trials {without}", n=len(own))
    found, least = JUDGES[claim](rows, threshold), LEAST[claim]
    if found.verdict == "untested":
        return found
    wrong = flaws(own)
    if wrong:
        return found.untested(wrong)
    refuted = found.verdict == "fails" and claim in OF_EVERY_TRIAL
    if found.each < least and not refuted:
        return found.untested(f"needs at least {least} trials of each condition (has {found.each})")
    return found


def flaws(rows: Rows) -> str:
    """What makes trials something other than what their conditions say, in words; empty if nothing does."""
    found = []
    for name, what in (("achieved_speed_cm_s", "speed"), ("path_error_mm", "path")):
        lost = sum(not is_number(row[name]) for row in rows)
        if lost:
            found.append(f"{lost} of {len(rows)} trials have no measured {what}")
    speeds = [row for row in rows if is_number(row["achieved_speed_cm_s"])]
    off = [abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1) for row in speeds]
    astray = [row["path_error_mm"] for row in rows if is_number(row["path_error_mm"])]
    if any(error > SPEED_TOLERANCE for error in off):
        count = sum(error > SPEED_TOLERANCE for error in off)
        found.append(f"{count} of {len(rows)} trials were off the commanded speed, by up to {max(off):.0%}")
    if any(error > PATH_TOLERANCE_MM for error in astray):
        count = sum(error > PATH_TOLERANCE_MM for error in astray)
        found.append(f"{count} of {len(rows)} trials left their path, by up to {max(astray):.1f} mm")
    return "; ".join(found)


_DEPTH, _ACROSS = ("approach", "recession"), ("translation",)
MOTIONS: Mapping[str, tuple[str, ...]] = {
    "C13": _DEPTH, "C14": _ACROSS, "C15": _ACROSS, "C16": _ACROSS,
    "C17": _DEPTH[:1], "C18": _DEPTH[:1], "C19": _DEPTH[1:], "C20": _DEPTH[1:], "C21": _DEPTH[:1],
}  # fmt: skip
"""Claim -> the motions it is judged on: flaws of other trials do not touch it."""

READS: Mapping[str, tuple[str, ...]] = {
    "C13": ("spikes", "peak_hs", "trough_hs"), "C14": ("peak_hs", "trough_hs"),
    **dict.fromkeys(("C15", "C16", "C17", "C18", "C19", "C20", "C21"), ("spikes",)),
}  # fmt: skip
"""Claim -> the columns it is judged by."""

OF_EVERY_TRIAL = frozenset({"C13", "C14"})
"""Claims about every single trial: one that breaks them refutes them, however few there are."""

LEAST: Mapping[str, int] = {claim: 5 if claim in OF_EVERY_TRIAL else 4 for claim in MOTIONS}
"""Claim -> trials of each condition, below which it is untested.

A claim about every trial takes 5: if half of all trials broke it, five in a row would keep it once in 32 times. A
claim that means of conditions differ takes 4: four against four are the fewest of which a two-sided rank test can
come to p < 0.05 (2 of 70 arrangements).
"""

JUDGES: Mapping[str, Callable[[Rows, float], Outcome]] = {
    "C13": judges.no_spikes_in_depth,
    "C14": judges.direction_by_sign,
    "C15": judges.peak_speed,
    "C16": judges.fewer_from_afar,
    "C17": lambda rows, _: judges.fewest_ahead(rows, "approach"),
    "C18": lambda rows, _: judges.more_on_one_side(rows, "approach", -1.0, "from the left against from the right"),
    "C19": lambda rows, _: judges.fewest_ahead(rows, "recession"),
    "C20": lambda rows, _: judges.more_on_one_side(rows, "recession", 1.0, "to the right against to the left"),
    "C21": lambda rows, _: judges.most_ahead(rows),
}

LOOMING_CLAIMS = frozenset({"C21"})
"""Those about looming detectors; the others are about models of direction."""


def concerns(claim: str, channels: Sequence[str]) -> bool:
    """Whether a claim is about models that answer by ``channels``."""
    return (claim in LOOMING_CLAIMS) != ("hs" in channels)
