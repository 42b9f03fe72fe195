"""C24. An ensemble tells speeds better."""

from __future__ import annotations

from experiments.bench.clips import judging as clips
from experiments.bench.clips.claims import ClipClaim
from experiments.bench.clips.judging import CONTRAST_GRID, LEAST_GREYS, rows_with_object
from experiments.bench.robot.claims import RobotClaim
from experiments.bench.robot.judging import ACROSS, DSNN, Rows
from experiments.bench.robot.mechanism import peaks
from experiments.bench.robot.mechanism.variants import (
    CONNECTIONS,
    PER_CORRELATOR,
    ROBOT_SPEEDS,
    common_speeds,
    crossings,
    higher,
    means_text,
    outcome_of,
    paired_text,
)
from experiments.bench.stats.checks import Check, exceeds
from experiments.bench.stats.verdict import Outcome

FEWER = (CONNECTIONS[1], CONNECTIONS[2])
"""The DSNN with smaller ensembles, of one and of two connected cells."""
MEANS = {CONNECTIONS[n]: PER_CORRELATOR[n] for n in (1, 2)}
"""The same as means per correlator, beside the sums."""


def on_robot(rows: Rows, threshold: float) -> Outcome:
    """Judge the robot's part: every speed shown counts, not the paper's alone. Of a speed, the mean peak over trials.

    The peak passes T at a speed if its mean does.
    """
    curves = {n: crossings(rows, CONNECTIONS[n], "peak_hs") for n in (1, 2, 8)}
    if not set(ROBOT_SPEEDS) <= set(common_speeds(curves)):
        return Outcome.unjudged("needs rightward translations at 8 cm, 2, 4, 6 and 10 cm/s")
    means = {n: {speed: peaks.mean(curves[n][speed]) for speed in common_speeds(curves)} for n in curves}
    past = {n: sum(peak > threshold for peak in mean.values()) for n, mean in means.items()}
    checks = [
        higher(means[8][speed], "N_con = 8", means[n][speed], f"N_con = {n}", speed, "peak HS")
        for n in (1, 2)
        for speed in means[8]
    ]
    for n in (1, 2):
        text = f"N_con = 8 passes T = {threshold:g} at {past[8]} of {len(means[8])} speeds"
        asks = f"more than N_con = {n}: {past[n]}"
        checks.append(Check(text, float(past[8]), float(past[n]), unit="speeds", asks=asks))
    texts = "; ".join(f"N_con = {n}: {means_text(mean)}, past T at {past[n]}" for n, mean in means.items())
    effect = "; ".join(f"N_con = 8 against {n}: {paired_text(curves[8], curves[n])}" for n in (1, 2))
    return outcome_of(checks, curves, f"robot, rightward at 8 cm, mean peak HS: {texts}", effect)


def on_clips(rows: Rows, threshold: float) -> Outcome:
    """Judge the off-line part: every clip of the contrast grid."""
    grid = {
        model: {row["clip"]: float(row["peak_hs"]) for row in rows_with_object(rows, model)} for model in (DSNN, *FEWER)
    }
    checks = [
        exceeds(f"{clip}: peak HS {peak:.3f}", peak, grid[model][clip], f"of {model}", "potential", scale=threshold)
        for model in FEWER
        for clip, peak in grid[DSNN].items()
    ]
    above = {model: sum(peak > threshold for peak in of_model.values()) for model, of_model in grid.items()}
    for model in FEWER:
        text, asks = f"passes T in {above[DSNN]} clips", f"more than {above[model]} of {model}"
        checks.append(Check(text, float(above[DSNN]), float(above[model]), unit="clips", asks=asks))
    texts = "; ".join(
        f"{model} {min(of_it.values()):.3f} to {max(of_it.values()):.3f}, past T in {above[model]} of {len(of_it)}"
        for model, of_it in grid.items()
    )
    measured = f"off-line part, peak HS: {texts} (T = {threshold:g})"
    return clips.outcome_of(checks, measured, "", len(grid[DSNN]))


ROBOT = RobotClaim(
    id="C24",
    title="An ensemble tells speeds better",
    says=(
        "an ensemble improves the speed response: N_con = 8 gives a higher peak HS than N_con = 1 and 2 at "
        "every speed of the contrast grid and of the robot, and passes T at more of them"
    ),
    source=(
        "simu-clean-dth and its text; motion-models; the text on ensembles and dynamic delays; simu-sys-grayscale (c)"
    ),
    motions=ACROSS,
    reads=("peak_hs",),
    models=frozenset({DSNN, *FEWER}),
    equal_terms=MEANS,
    mechanism=(
        "ensembles",
        "count, time in view, firing rate and potential, 2 to 30 cm/s, beside variants of the DSNN",
    ),
    judge=on_robot,
)

CLIPS = ClipClaim(
    id="C24",
    title=ROBOT.title,
    says=ROBOT.says,
    source=ROBOT.source,
    models=frozenset({DSNN, *FEWER}),
    equal_terms=MEANS,
    conditions=CONTRAST_GRID,
    least_greys=LEAST_GREYS,
    mechanism=ROBOT.mechanism,
    judge=on_clips,
)
