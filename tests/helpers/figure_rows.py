"""Figures of the robot's trials and of clips, drawn from fixed rows, for the names of models."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
import pyarrow as pa
from matplotlib.figure import Figure

from experiments.bench.report import clips as clips_figure
from experiments.bench.robot import figure as robot_figure
from experiments.bench.robot.mechanism import excitation_figure
from experiments.bench.robot.mechanism import figure as mechanism_figure
from experiments.bench.sources.clips import Figure as Drawing
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.stats.excitation import Course, Trial

SET = {"dsnn.n_con": {"dsnn": 6}}
OWN = "a-model_of.mine"
MODELS_SHOWN = {
    "one": ("dsnn",),
    "three": ("dsnn", "emd", "hybrid"),
    "own": ("dsnn", OWN),
}
"""Of a figure: as many models as there are kinds of trouble. `TWINS` answer alike."""
TWINS = ("dsnn", "hybrid", "dsnn-reference")
FRAMES = 12


def strength(model: str) -> float:
    """How strongly a model answers: no two alike but `TWINS`."""
    return 0.6 if model in TWINS else 0.15 + 0.35 * (sum(map(ord, model)) % 97) / 97


def threshold(model: str) -> float | None:
    """Each model's threshold; the EMD has none, and does not spike."""
    return None if model == "emd" else 0.2 if model == OWN else 0.16


def thresholds(models: Sequence[str]) -> dict[str, float | None]:
    return {model: threshold(model) for model in models}


def title(models: Sequence[str]) -> str:
    return robot_figure.title("speed", models, "leaves", 3, SET, False)


# --- the robot --------------------------------------------------------------------------------------------------------


def robot_rows(models: Sequence[str], conditions: Sequence[Mapping[str, Any]], repeats: int = 3) -> list[Any]:
    """A row for each trial and model."""
    usual = dict.fromkeys(CONDITION_COLUMNS) | {
        "motion": "translation", "direction": "rightward", "speed_cm_s": 6.0, "distance_cm": 8.0,
        "acceleration_cm_s2": 100.0, "observer_speed_cm_s": 0.0, "observer_turn_deg_s": 0.0,
    }  # fmt: skip
    return [
        {**usual, **condition, "trial": trial, "model": model, "spikes": round(40 * strength(model)) + trial % 5,
         "hs_spikes": 1, "looming_spikes": None}
        for trial, condition in enumerate(trial_condition for trial_condition in conditions for _ in range(repeats))
        for model in models
    ]  # fmt: skip


def wave(model: str, trial: int = 0, phase: float = 0.0) -> np.ndarray:
    return (1 - 0.05 * trial) * strength(model) * np.sin(np.linspace(0.0, 3.0, FRAMES) + phase)


def robot_frames(rows: Sequence[Any]) -> pa.Table:
    bearing, time_s = np.linspace(-30.0, 30.0, FRAMES), np.arange(FRAMES) / 30.0
    tables = []
    for row in rows:
        potential = wave(row["model"], row["trial"])
        index = {name: [row[name]] * FRAMES for name in ("trial", "model")}
        series = {"hs": potential, "looming": potential, "stimulus_bearing_deg": bearing, "sim_time_s": time_s}
        tables.append(pa.table({**index, **series}))
    return pa.concat_tables(tables)


SPEEDS = [{"speed_cm_s": speed} for speed in (2.0, 4.0, 6.0, 8.0, 10.0)]


def robot(models: Sequence[str]) -> Figure:
    rows = robot_rows(models, SPEEDS)
    return robot_figure.figure(rows, robot_frames(rows), "speed_cm_s", title(models), thresholds(models))


def robot_words(models: Sequence[str]) -> Figure:
    """Two ways of moving in two directions: words along the axis, lines for the directions."""
    kinds = [{"motion": motion, "direction": way} for motion in ("approach", "recession") for way in ("left", "right")]
    rows = robot_rows(models, kinds)
    return robot_figure.figure(rows, robot_frames(rows), "motion", title(models), thresholds(models))


def mechanism(models: Sequence[str]) -> Figure:
    rows = [
        {**row, "spikes_in_window": row["spikes"] - 3, "seconds_in_view": 12.0 / row["speed_cm_s"],
         "rate_in_view_hz": 20.0 * strength(row["model"]), "peak_hs": strength(row["model"]),
         "mean_hs_near_axis": 0.8 * strength(row["model"]) + 0.001 * row["trial"]}
        for row in robot_rows(models, SPEEDS)
    ]  # fmt: skip
    return mechanism_figure.figure(rows, "speed_cm_s", title(models), threshold(models[0]))


def excitation(models: Sequence[str]) -> Figure:
    """Seven conditions: three rows of them. It is about one network, whatever else is shown."""
    time_s, rise = np.arange(FRAMES) / 30.0, np.hanning(FRAMES)
    spikes = (rise > 0.8).astype(np.int64)
    trials = tuple(Trial(i, time_s, rise, 0.9 * rise, 0.5 * rise, spikes, 0.1 * rise, 0 * spikes) for i in range(3))
    courses = [
        Course({"motion": "approach", "direction": "straight" if angle == 0 else "rightward", "angle_deg": angle,
                "distance_cm": 8.0, "speed_cm_s": 6.0}, trials, 0.7)
        for angle in (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)
    ]  # fmt: skip
    return excitation_figure.figure(courses, title(["dsnn"]), 0.16)


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


def drawn_clips(drawing: Drawing, models: Sequence[str], clips: Sequence[Mapping[str, Any]]) -> Figure:
    trials = clip_trials(models, clips)
    heading = clips_figure.title("clean", 0, SET)
    return clips_figure.draw(drawing, trials, clip_frames(trials), thresholds(models), heading)


def traces(models: Sequence[str]) -> Figure:
    names = ("dark rightward", "light leftward", "looming at the paper's speed", "receding", "dark upward")
    return drawn_clips(Drawing("traces"), models, [{"clip": name} for name in names])


def peaks(models: Sequence[str]) -> Figure:
    clips = [{"speed": speed, "grey": grey, "background_speed": behind} for speed in (20.0, 60.0, 120.0)
             for grey in (0.0, 100.0) for behind in (4.0, 8.0)]  # fmt: skip
    return drawn_clips(Drawing("peaks", along="speed", lines="background_speed", panels="grey"), models, clips)


def contrast(models: Sequence[str]) -> Figure:
    clips = [{"speed": speed, "grey": grey} for speed in (20.0, 60.0, 120.0) for grey in (0.0, 100.0)]
    return drawn_clips(Drawing("contrast"), models, clips)


BACKGROUNDS = (2.0, 8.0, 30.0, 300.0)


def background(models: Sequence[str]) -> Figure:
    clips = [{"object": "absent", "background_speed": speed} for speed in BACKGROUNDS]
    clips += [{"motion": "looming", "background_speed": speed} for speed in BACKGROUNDS]
    clips += [{"speed": object_speed, "grey": grey, "background_speed": speed}
              for object_speed in (40.0, 120.0) for grey in (0.0, 100.0) for speed in BACKGROUNDS]  # fmt: skip
    return drawn_clips(Drawing("background"), models, clips)


def ranges(models: Sequence[str]) -> Figure:
    return drawn_clips(Drawing("ranges"), models, [{"speed": 20.0}, {"speed": 60.0}, {"object": "absent"}])


def edges(models: Sequence[str]) -> Figure:
    """Both directions at two speeds, as the experiment has."""
    clips = [{"polarity": polarity, "motion": motion, "speed": speed} for polarity in ("off", "on")
             for motion in ("rightward", "leftward") for speed in (60.0, 120.0)]  # fmt: skip
    return drawn_clips(Drawing("edges"), models, clips)
