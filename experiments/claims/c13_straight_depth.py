"""C13. Straight motion in depth: silent."""

from __future__ import annotations

from dataclasses import replace

from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import DEPTH, Rows, mean_text, outcome_of, paper_trials
from experiments.bench.stats.checks import Check
from experiments.bench.stats.tests import proportion_interval
from experiments.bench.stats.verdict import Outcome


def judge(rows: Rows, threshold: float) -> Outcome:
    """Judge motion along the optical axis, at any speed: every such trial of a replicate, of all its experiments.

    Of motions without a spike, the higher potential decides.
    """
    kinds = {kind: paper_trials(rows, motion=kind, angle_deg=0.0) for kind in DEPTH}
    tested = {kind: trials for kind, trials in kinds.items() if trials}
    if not tested:
        return Outcome.unjudged("needs straight approach and recession")
    parts = []
    checks: list[tuple[float, Check]] = []
    for kind, trials in tested.items():
        firing = sum(row["spikes"] > 0 for row in trials)
        peak = max(max(row["peak_hs"], -row["trough_hs"]) for row in trials)
        share = "[{:.0%}, {:.0%}]".format(*proportion_interval(firing, len(trials)))
        parts.append(f"{kind}: spikes in {firing} of {len(trials)} trials {share}, |HS| up to {peak:.2f}")
        text = f"{kind}: spikes in {firing} of {len(trials)} trials"
        checks.append((peak, Check(text, float(firing), 0.0, "at most", unit="trials", asks="0")))
    spikes = {kind: [row["spikes"] for row in trials] for kind, trials in tested.items()}
    counts = [count for of_kind in spikes.values() for count in of_kind]
    measured = f"{'; '.join(parts)} (T = {threshold:g})"
    highest_first = [check for _, check in sorted(checks, key=lambda pair: -pair[0])]
    outcome = outcome_of(highest_first, spikes, measured, f"{mean_text(counts, lowest=0.0)} spikes a trial")
    outcome = replace(outcome, broken=sum(count > 0 for count in counts))
    if outcome.verdict == "holds" and len(tested) < len(kinds):
        return outcome.withheld("the other motion was not run")
    return outcome


CLAIM = RobotClaim(
    id="C13",
    title="Straight motion in depth: silent",
    eye="Open loop, nothing corrects the start pose: a straight approach ends beside the camera, and fires.",
    says="straight approach and recession: no spikes",
    source="robot-general-tests",
    motions=DEPTH,
    reads=("spikes", "peak_hs", "trough_hs"),
    of_every_trial=True,
    pools=("general", "angular-approach", "angular-recession"),
    silent_passes=True,
    cause=(
        "w_i = 0.9 leaves a tenth of symmetric motion; when a recession starts sharply, that passes T in single trials."
    ),
    tried=(
        "The claim asks for no spike in any trial, and now and then a single straight recession fires as the "
        "stimulus sets off 5 cm before the lens. The paper leaves open how sharply it starts: at 100 cm/s2 the "
        "start is a flash of motion and straight recession fires in every run, from 20 cm/s2 up in single "
        "trials; 17 cm/s2 is the default. What fires is what w_i = 0.9, the paper's own, leaves of symmetric "
        "motion: a tenth of the excitation, always rightward. With w_i = 1, and without errors of the start "
        "pose, HS stays well inside the threshold; camera noise makes no difference."
    ),
    mechanism=(
        "recession-mechanism",
        "excitation and inhibition over time, and what w_i = 0.9 leaves of symmetric motion",
    ),
    judge=judge,
)
