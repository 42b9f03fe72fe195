"""The claims about the robot with the model of its eye, and with its wheels; not those of speeds beyond these."""

from typing import Any

from experiments import Axis, Level, Study

EYE = Axis("eye", (Level("default"), Level("ov7670", ("camera.preset=ov7670",))))
WHEELS = Axis("wheels", (Level("pose feedback"), Level("open loop", ("robot.preset=colias4",))))


def driven(result: Any) -> dict[str, list[dict[str, Any]]]:
    """Return how the stimulus moved at each point: mean errors of its speed, and of its distance from the path."""
    rows = []
    for point, model in result.plan.judged:
        every = [row for replicate in result.replicates(point, model) for row in replicate.rows]
        trials = list({row["trial"]: row for row in every}.values())  # some are shown to several models
        speed = sum(abs(row["achieved_speed_cm_s"] / row["speed_cm_s"] - 1.0) for row in trials)
        path, number = sum(row["path_error_mm"] for row in trials), max(len(trials), 1)
        rows.append({**dict(point), "trials": len(trials), "speed error": speed / number,
                     "path error (mm)": path / number})  # fmt: skip
    return {"How the stimulus moved": rows}


STUDY = Study(
    name="fidelity",
    summary="the claims about the robot with the default camera or its own, with pose feedback or its wheels open loop",
    claims=("C13", "C14", "C15", "C16", "C17", "C18", "C19", "C20", "C21", "C29", "C31"),
    axes=(EYE, WHEELS),
    models=(),  # those that each claim is about
    tables=driven,
)
