"""Summary of trials whose stimulus was driven open loop: the speeds that it reached, and how far it drifted.

Nothing corrects such a stimulus. So the tolerances that other trials are held to do not apply to it
(`experiments.bench.sources.robot_claims.flaws`), and what it did is reported instead.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from colias_sim.config import RobotConfig
from experiments.bench.sources.robot_claims import PATH_TOLERANCE_MM, SPEED_TOLERANCE
from experiments.bench.stats.checks import is_number

Rows = Sequence[Mapping[str, Any]]


def in_short(rows: Rows) -> str:
    """Say in a few words how the stimulus drove, for a verdict; empty where no trial was driven open loop."""
    chosen = [row for row in rows if row.get("drive") == "open"]
    speeds = [row for row in chosen if is_number(row["achieved_speed_cm_s"])]
    if not chosen:
        return ""
    off = max((abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1) for row in speeds), default=0.0)
    drift = max(abs(row["drift_mm"]) for row in chosen)
    return f"stimulus driven open loop: speed off by up to {off:.1%}, drift up to {drift:.1f} mm"


def why(robot: RobotConfig, slowest_cm_s: float) -> str:
    """Say why no trial is left out for its speed or path.

    Parameters
    ----------
    robot
        The robot's settings.
    slowest_cm_s
        The slowest commanded speed of the stimulus.
    """
    text = (
        f"open loop: nothing corrects the stimulus, so no trial is left out for a speed {SPEED_TOLERANCE:.0%} off "
        f"or a path {PATH_TOLERANCE_MM:g} mm off"
    )
    step = robot.power_step_cm_s
    if not step:
        return text
    share = step / slowest_cm_s
    return f"{text}; one step of power is {step:g} cm/s, {share:.1%} at {slowest_cm_s:g} cm/s"
