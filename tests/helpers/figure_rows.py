"""Figures of the robot's trials and of clips, drawn from fixed rows, for the names of models."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from experiments.declare.conditions import CONDITION_COLUMNS
from experiments.draw import robot as robot_figure

FRAMES = 12


def strength(model: str) -> float:
    """How strongly a model answers: no two alike."""
    return 0.6 if model == "dsnn" else 0.15 + 0.35 * (sum(map(ord, model)) % 97) / 97


def threshold(model: str) -> float:
    return strength(model) / 4


# --- the robot --------------------------------------------------------------------------------------------------------


def robot_rows(models: Sequence[str], conditions: Sequence[Mapping[str, Any]], repeats: int = 3) -> list[Any]:
    """A row for each trial and model, every second leftward. ``lgmd1`` has looming alone; the EMD does not spike."""
    usual = dict.fromkeys(CONDITION_COLUMNS) | {
        "motion": "translation", "direction": "rightward", "speed_cm_s": 6.0, "distance_cm": 8.0,
        "acceleration_cm_s2": 100.0, "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0,
    }  # fmt: skip
    rows = []
    for trial, condition in enumerate(condition for condition in conditions for _ in range(repeats)):
        for model in models:
            size, spikes = strength(model) + 0.001 * trial, round(40 * strength(model)) + trial % 5
            low, high = (np.array([-size, 0.01]) if trial % 2 else np.array([-0.01, size])) * (model != "lgmd1")
            rows.append({
                **usual, **condition, "trial": trial, "model": model, "spikes": None if model == "emd" else spikes,
                "spikes_in_window": None if model == "emd" else spikes - 3, "seconds_in_view": 1.0 + 0.01 * trial,
                "rate_in_view_hz": None if model == "emd" else 20.0 * size, "peak_hs": high, "trough_hs": low,
                "peak_looming": size * (model == "lgmd1"), "mean_hs_near_axis": 0.8 * size,
            })  # fmt: skip
    return rows


def potential(model: str, trial: int, bearing: Any) -> Any:
    """A line over the bearing, its steepness the trial's own: between any two frames it is known exactly."""
    return strength(model) * (1.0 + 0.1 * (trial**2 % 7)) * (bearing - 3.0) / 30.0


def bearings(trial: int) -> np.ndarray:
    """Each trial has its own stretch, every second one from right to left."""
    return (np.linspace(-30.0, 30.0, FRAMES) + 0.77 * (trial % 5))[:: (-1) ** trial]


def robot_frames(rows: Sequence[Any]) -> pl.DataFrame:
    return pl.concat(
        pl.DataFrame({"trial": [row["trial"]] * FRAMES, "model": [row["model"]] * FRAMES,
                      "hs": line * (row["model"] != "lgmd1"), "looming": line * (row["model"] == "lgmd1"),
                      "time_s": np.arange(FRAMES) / 30.0, "stimulus_bearing_deg": bearings(row["trial"])})
        for row in rows for line in [potential(row["model"], row["trial"], bearings(row["trial"]))]
    )  # fmt: skip


SPEEDS = [{"speed_cm_s": speed} for speed in (2.0, 4.0, 6.0, 8.0, 10.0)]


def drawn_robot(kind: str, rows: Sequence[Any], varies: str = "speed_cm_s", table: Any = ()) -> Figure:
    models = dict.fromkeys(row["model"] for row in rows)
    limits = {model: None if model == "emd" else threshold(model) for model in models}
    return robot_figure.draw(kind, rows, robot_frames(rows), varies, limits, "speed, leaves arena", table)


# --- clips ------------------------------------------------------------------------------------------------------------


def clip_trials(models: Sequence[str], clips: Sequence[Mapping[str, Any]], repeats: int = 1) -> pl.DataFrame:
    """A row for each clip, seed and model; ``lgmd1`` has looming alone."""
    usual = {"object": "dark", "motion": "rightward", "speed": 60.0, "speed_unit": "px/s", "grey": 0.0, "fps": 30.0,
             "background_speed": 8.0, "polarity": None, "movers": None}  # fmt: skip
    return pl.DataFrame([
        {**usual, **clip, "trial": repeat * len(clips) + place, "repeat": repeat, "model": model,
         "clip": clip.get("clip", f"clip {place}"), "peak_looming": size, "peak_hs": size * (model != "lgmd1"),
         "trough_hs": -0.05 * (model != "lgmd1"), "peak_vs": 0.03 * (model != "lgmd1"),
         "trough_vs": -0.3 * size * (model != "lgmd1")}
        for repeat in range(repeats) for place, clip in enumerate(clips) for model in models
        for size in [strength(model) * (1 - 0.02 * (place % 7) + 0.1 * repeat**2)]
    ], infer_schema_length=None)  # fmt: skip


def clip_frames(trials: pl.DataFrame) -> pl.DataFrame:
    """The DSNN has HS and VS, ``lgmd1`` looming, the hybrid all three."""
    parts = []
    for trial, model in trials.select("trial", "model").iter_rows():
        hs, vs, looming = (strength(model) * np.sin(np.linspace(0.0, 3.0, FRAMES) + phase) / (1 + trial**2)
                           for phase in range(3))  # fmt: skip
        own = {"hs": hs * (model != "lgmd1"), "vs": vs * (model != "lgmd1"),
               "looming": looming * (model in ("lgmd1", "hybrid")), "target": 0.0 * hs}  # fmt: skip
        parts.append(pl.DataFrame({"trial": [trial] * FRAMES, "model": model, "frame": range(FRAMES), **own}))
    return pl.concat(parts)
