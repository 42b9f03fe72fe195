"""Figures of trials that are made up, condition by condition."""

from __future__ import annotations

import pyarrow as pa

from experiments.bench.robot.figure import figure


def drawn(conditions, varies="speed_cm_s", repeats=3, models=("dsnn",), **thresholds):
    rows = [
        {"trial": i, "motion": "translation", "direction": direction, "speed_cm_s": speed, "distance_cm": distance,
         "angle_deg": None, "far_cm": None, "shell_grey": None, "wall_contrast": None, "acceleration_cm_s2": 100.0,
         "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0, "model": model,
         "spikes": i, "hs_spikes": i, "looming_spikes": None}
        for i, (direction, speed, distance) in enumerate(conditions * repeats)
        for model in models
    ]  # fmt: skip
    frames = pa.table(
        {
            "trial": [row["trial"] for row in rows for _ in range(4)],
            "model": [row["model"] for row in rows for _ in range(4)],
            "hs": [0.1] * 4 * len(rows),
            "stimulus_bearing_deg": [20.0, 5.0, -5.0, -20.0] * len(rows),
        }
    )
    return figure(rows, frames, varies, "title", dict.fromkeys(models, 0.2) | thresholds)
