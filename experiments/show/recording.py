"""Recordings of trials with the robot."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np

from colias_sim.simulation import TRIAL_ROBOTS
from dsnn import ResponseSeries
from dsnn.model import MAP_SCALES
from experiments.base import palette
from experiments.base.palette import Colour
from experiments.show import record as rerun
from experiments.show.course import obstacles
from experiments.show.play import Showing
from experiments.show.record import Content, Frames, RecordedModel
from experiments.show.robot import RobotTrial, scene_of
from scenes import ARENAS

MAP_FULL = {"p": 40.0, "la": 40.0, "f_on": 1.0, "f_off": 1.0}
"""Layer -> the value, in its own unit, that has the full colour."""


def record(trial: RobotTrial, showings: Sequence[Showing], rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a finished trial with these rows, as the bytes of an .rrd file."""
    by_label = {model.label: (model, series) for showing in showings for model, series in showing.series()}
    arena = trial.settings.scene.arena
    properties = {
        "experiment": trial.experiment,
        "arena": arena if arena in ARENAS else None,  # no path of a user's own file
        "trial": trial.index,
        "repeat": trial.repeat,
        "seed": trial.seed,
        **trial.condition.columns(),
        **{f"{row['model']}_spikes": row["spikes"] for row in rows},
        **{name: rows[0][name] for name in ("achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive")},
    }
    shown = {row["model"]: by_label[row["model"]] for row in rows}
    seen = frames(showings, {label: series for label, (_, series) in shown.items()})
    values = {"condition": trial.label(), **{f"{row['model']} spikes": row["spikes"] for row in rows}}
    about = rerun.note(values, f"colias video RUN --trial {trial.index} --out trial.mp4", "colias run --again RUN")
    # Equal for equal trials alone: the viewer merges recordings of one identity.
    digest = hashlib.blake2s(repr(trial).encode(), digest_size=6).hexdigest()
    return rerun.write(
        content(trial, seen, (RecordedModel.of(model) for model, _ in shown.values())), seen, title(trial),
        f"{trial.experiment}-{trial.index:04d}-{digest}", {"trial": rerun.properties(properties)}, about=about,
    )  # fmt: skip


def title(spec: RobotTrial) -> str:
    """Return the name of a trial's recording."""
    return f"{spec.index:04d} {spec.label()}, repeat {spec.repeat}"


def content(spec: RobotTrial, seen: Frames, models: Iterable[RecordedModel]) -> Content:
    """Return what the recording of a trial has."""
    scene = scene_of(spec.condition, spec.settings)
    exposure = [
        (_exposure(eye), (f"exposure time{f' of {eye}' if eye else ''} (ms)",), "exposure time of each row (ms)")
        for eye in seen.images
        if _exposure(eye) in seen.plots
    ]
    return Content(
        models=tuple(models), eyes=tuple(seen.images), camera=spec.settings.camera, scene=scene,
        robots=tuple(TRIAL_ROBOTS.items()), obstacles=rerun.outlines(obstacles(scene.arena)), plots=tuple(exposure),
        maps=tuple((name, map_colours(name)) for name in seen.maps),
        surfaces=next(iter(seen.truth.values()))[0].geoms if seen.truth else (),
    )  # fmt: skip


def frames(showings: Sequence[Showing], responses: dict[str, ResponseSeries]) -> Frames:
    """Stack a trial's frames of each eye, the first model's layer maps, poses and responses.

    The exposure is recorded of an eye with a rolling shutter, or an exposure that changes.
    """
    truth, samples = showings[0].truth(), {showing.eye: showing.samples for showing in showings}
    runners = (runner for showing in showings for runner in showing.runners if not runner.trouble)
    layers = next((runner.pictures for runner in runners if runner.pictures), [])
    poses = {
        robot: np.column_stack([truth[f"{robot}_{name}"] for name in ("x_cm", "y_cm", "heading_deg")])
        for robot in TRIAL_ROBOTS
    }
    exposure = {eye: np.array([sample.truth["exposure_ms"] for sample in of_eye]) for eye, of_eye in samples.items()}
    return Frames(
        truth["time_s"].to_numpy(), np.arange(truth.height), responses,
        {eye: np.stack([sample.image for sample in of_eye]) for eye, of_eye in samples.items()}, poses,
        dict(zip(MAP_SCALES, np.stack(layers, axis=1), strict=True)) if layers else {},
        {_exposure(eye): values for eye, values in exposure.items()
         if samples[eye][0].truth["row_time_us"] or np.ptp(values) > 0},
        {label: taken for showing in showings for label, taken in showing.taken().items()},
        {eye: truths for eye, of_eye in samples.items()
         if (truths := [sample.pixels for sample in of_eye if sample.pixels is not None])},
        {eye: [sample.events for sample in of_eye] for eye, of_eye in samples.items()},
    )  # fmt: skip


def _exposure(eye: str) -> str:
    """Return the entity of an eye's exposure."""
    return f"{rerun.camera_entity(eye)}/exposure"


@lru_cache
def map_colours(name: str) -> tuple[Colour, ...]:
    """Return the colours of a layer's 256 values: what became brighter, what became darker, else dark."""
    gain, zero = MAP_SCALES[name]
    clipped = max(zero, 0.0)  # the values below are noise
    strength = [(value - clipped) / (gain * MAP_FULL[name]) for value in range(256)]
    if name == "f_off":
        strength = [-share for share in strength]
    still, darker, brighter = map(palette.rgb, (palette.STILL, palette.DARKER, palette.BRIGHTER))
    return tuple(palette.mixed(still, brighter if share > 0 else darker, min(abs(share), 1.0)) for share in strength)
