"""The claims about the robot with the model of its eye, and with its wheels; not those of speeds beyond these."""

from collections.abc import Sequence
from typing import Any

from experiments import Axis, Level, Study
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.study import Tables

EYE = Axis("eye", (Level("default"), Level("ov7670", ("camera.preset=ov7670",))))
WHEELS = Axis("wheels", (Level("pose feedback"), Level("open loop", ("robot.preset=colias4",))))


def driven(counts: Counts) -> Tables:
    """Say how the stimulus moved at each point: mean errors of its speed, and of its largest distance from the path."""
    rows: list[dict[str, Any]] = []
    for point, model in counts.plan.judged:
        every = (row for replicate in counts.replicates(point, model) for row in replicate.rows)
        trials = list({row["trial"]: row for row in every}.values())  # some are seen by several models
        speed = [abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1.0) for row in trials]
        path = [row["path_error_mm"] for row in trials]
        rows.append({**dict(point.values), "trials": len(trials), "speed error": _mean(speed),
                     "path error (mm)": _mean(path)})  # fmt: skip
    return {"How the stimulus moved": rows}


def _mean(values: Sequence[float]) -> float:
    return sum(values) / max(len(values), 1)


STUDY = Study(
    name="fidelity",
    summary="the claims about the robot with the default camera or its own, with pose feedback or its wheels open loop",
    claims=("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20", "C21", "C29", "C31"),
    axes=(EYE, WHEELS),
    models=(),  # those that each claim is about
    tables=driven,
)
