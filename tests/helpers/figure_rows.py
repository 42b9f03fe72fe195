"""Figures of the robot's trials and of clips, drawn from fixed rows, for the names of models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from experiments.bench.report import robot as robot_figure
from experiments.bench.sources.conditions import CONDITION_COLUMNS

FRAMES = 12


def strength(model: str) -> float:
    """How strongly a model answers: no two alike."""
    return 0.6 if model == "dsnn" else 0.15 + 0.35 * (sum(map(ord, model)) % 97) / 97


# --- the robot --------------------------------------------------------------------------------------------------------


def robot_rows(models: Sequence[str], conditions: Sequence[Mapping[str, Any]], repeats: int = 3) -> list[Any]:
    """A row for each trial and model. ``lgmd1`` has looming alone; the EMD does not spike."""
    usual = dict.fromkeys(CONDITION_COLUMNS) | {
        "motion": "translation", "direction": "rightward", "speed_cm_s": 6.0, "distance_cm": 8.0,
        "acceleration_cm_s2": 100.0, "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0,
    }  # fmt: skip
    rows = []
    for trial, condition in enumerate(condition for condition in conditions for _ in range(repeats)):
        for model in models:
            size, spikes = strength(model) + 0.001 * trial, round(40 * strength(model)) + trial % 5
            rows.append({
                **usual, **condition, "trial": trial, "model": model, "spikes": None if model == "emd" else spikes,
                "spikes_in_window": None if model == "emd" else spikes - 3, "seconds_in_view": 1.0 + 0.01 * trial,
                "rate_in_view_hz": None if model == "emd" else 20.0 * size, "peak_hs": size * (model != "lgmd1"),
                "trough_hs": -0.01, "peak_looming": size * (model == "lgmd1"), "mean_hs_near_axis": 0.8 * size,
            })  # fmt: skip
    return rows


def wave(model: str, trial: int = 0, phase: float = 0.0) -> np.ndarray:
    return (1 - 0.05 * trial) * strength(model) * np.sin(np.linspace(0.0, 3.0, FRAMES) + phase)


def robot_frames(rows: Sequence[Any]) -> pl.DataFrame:
    bearing, time_s = np.linspace(-30.0, 30.0, FRAMES), np.arange(FRAMES) / 30.0
    return pl.concat(
        pl.DataFrame({"trial": [row["trial"]] * FRAMES, "model": [row["model"]] * FRAMES,
                      "hs": wave(row["model"], row["trial"]) * (row["model"] != "lgmd1"),
                      "looming": np.full(FRAMES, 0.6 * (row["model"] == "lgmd1")), "sim_time_s": time_s,
                      "stimulus_bearing_deg": bearing})
        for row in rows
    )  # fmt: skip


SPEEDS = [{"speed_cm_s": speed} for speed in (2.0, 4.0, 6.0, 8.0, 10.0)]


def drawn_robot(kind: str, rows: Sequence[Any], varies: str = "speed_cm_s", table: Any = ()) -> Figure:
    limits = {row["model"]: None if row["model"] == "emd" else 0.16 for row in rows}
    return robot_figure.draw(kind, rows, robot_frames(rows), varies, limits, "speed, leaves arena", table)


# --- clips ------------------------------------------------------------------------------------------------------------


def clip_trials(models: Sequence[str], clips: Sequence[Mapping[str, Any]], repeats: int = 1) -> pl.DataFrame:
    usual = {"object": "dark", "motion": "rightward", "speed": 60.0, "speed_unit": "px/s", "grey": 0.0, "fps": 30.0,
             "background_speed": 8.0, "polarity": None, "movers": None, "peak_looming": 0.5}  # fmt: skip
    return pl.DataFrame([
        {**usual, **clip, "trial": repeat * len(clips) + place, "repeat": repeat, "model": model,
         "clip": clip.get("clip", f"clip {place}"), "peak_hs": strength(model) * (1 - 0.02 * place + 0.1 * repeat),
         "trough_hs": -0.05, "peak_vs": 0.1, "trough_vs": -0.05}
        for repeat in range(repeats) for place, clip in enumerate(clips) for model in models
    ], infer_schema_length=None)  # fmt: skip


def clip_frames(trials: pl.DataFrame) -> pl.DataFrame:
    return pl.concat(
        pl.DataFrame({"trial": [trial] * FRAMES, "model": [model] * FRAMES, "frame": range(FRAMES),
                      "hs": wave(model, trial), "vs": 0.5 * wave(model, phase=1.0), "looming": np.full(FRAMES, 0.5)})
        for trial, model in trials.select("trial", "model").iter_rows()
    )  # fmt: skip
