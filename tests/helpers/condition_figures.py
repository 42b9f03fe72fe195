"""Figures of trials that are made up, condition by condition."""

from __future__ import annotations

import pyarrow as pa

from experiments.bench.robot.figure import figure


def drawn(
    conditions, varies="speed_cm_s", repeats=3, models=("dsnn",), looming=(), strong=(), **thresholds
):  # fmt: skip
    """The figure of trials; models of ``looming`` answer by it alone, the potentials of ``strong`` ones go up to 3."""
    rows = [
        {"trial": i, "motion": "translation", "direction": direction, "speed_cm_s": speed, "distance_cm": distance,
         "angle_deg": None, "far_cm": None, "shell_grey": None, "wall_contrast": None, "acceleration_cm_s2": 100.0,
         "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0, "model": model,
         "spikes": i, "hs_spikes": None if model in looming else i, "looming_spikes": i if model in looming else None,
         "peak_looming": 0.6 * (model in looming), "peak_hs": 0.1 * (model not in looming), "trough_hs": 0.0}
        for i, (direction, speed, distance) in enumerate(conditions * repeats)
        for model in models
    ]  # fmt: skip
    frames = pa.table(
        {
            "trial": [row["trial"] for row in rows for _ in range(4)],
            "model": [row["model"] for row in rows for _ in range(4)],
            "hs": [3.0 if row["model"] in strong else 0.1 for row in rows for _ in range(4)],
            "looming": [0.6] * 4 * len(rows),
            "stimulus_bearing_deg": [-20.0, -5.0, 5.0, 20.0] * len(rows),
        }
    )
    return figure(rows, frames, varies, "title", dict.fromkeys(models, 0.2) | thresholds)
