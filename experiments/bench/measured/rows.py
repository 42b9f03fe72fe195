"""The tables of a measured run: those of simulated trials, and where each row comes from.

What a robot cannot know is null: the speed that the stimulus reached, the error of its path, and without a tracker all
that needs to be told where the stimulus was.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import polars as pl

from colias_sim.config import CameraConfig
from dsnn import ResponseSeries
from experiments.bench.measured.log import CHANNELS, POSES, LoggedTrial
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.play import spike_counts
from experiments.bench.sources.measures import away_cm, responses, windows
from experiments.bench.sources.rows import FRAME_SCHEMA, TRIAL_SCHEMA
from experiments.bench.store.origin import COLUMN
from experiments.bench.store.rows import OBSERVER

MEASURED_SCHEMA = TRIAL_SCHEMA | pl.Schema({COLUMN: str})
RATE_TOLERANCE = 0.001
"""Share by which a log's frame rate may differ from the camera's setting and still be taken for it."""


@dataclasses.dataclass(frozen=True, slots=True)
class Given:
    """Answers of one model to a trial.

    Parameters
    ----------
    chosen
        The model, under the label of its rows.
    series
        Its answers; a channel that is not known is 0 there.
    unknown
        Channels that the model declares, and the log does not tell.
    provenance
        Where the answers come from.
    """

    chosen: ConfiguredModel
    series: ResponseSeries
    unknown: tuple[str, ...]
    provenance: str

    @property
    def model(self) -> str:
        """The model's label."""
        return self.chosen.label

    @property
    def channels(self) -> tuple[str, ...]:
        """The channels whose answers are known."""
        return tuple(channel for channel in self.chosen.channels if channel not in self.unknown)

    @property
    def thresholds(self) -> Mapping[str, float | None]:
        """Each known channel's spiking threshold."""
        return {channel: self.chosen.thresholds[channel] for channel in self.channels}


def given(model: ConfiguredModel, logged: Mapping[str, npt.NDArray[Any]], frames: int, provenance: str) -> Given:
    """Take the columns of a log as a model's answers.

    Parameters
    ----------
    model
        The model.
    logged
        Column -> its values, (T,).
    frames
        T.
    provenance
        Where the answers come from.
    """
    declared = {name for channel in model.channels for name in (channel, CHANNELS[channel])}
    columns: dict[str, Any] = {
        field.name: logged[field.name]
        if field.name in logged and field.name in declared
        else np.zeros(frames, np.int64 if field.name in CHANNELS.values() else np.float64)
        for field in dataclasses.fields(ResponseSeries)
    }
    unknown = tuple(channel for channel in model.channels if channel not in logged)
    return Given(model, ResponseSeries(**columns), unknown, provenance)


def rate_hz(time_s: npt.NDArray[np.float64], nominal: float) -> float:
    """Return the frame rate of a trial: ``nominal`` where its times go by that, else what they tell."""
    if len(time_s) < 2:
        return nominal
    rate = 1.0 / float(np.median(np.diff(time_s)))
    return nominal if abs(rate / nominal - 1.0) <= RATE_TOLERANCE else rate


def trial_row(
    experiment: str, repeat: int, trial: LoggedTrial, given: Given, camera: CameraConfig
) -> dict[str, Any]:  # fmt: skip
    """Return the row of a trial as one model answered it, of `MEASURED_SCHEMA`."""
    rate, camera_cm = rate_hz(trial.time_s, camera.fps), camera.forward_cm
    frames = pl.DataFrame({**dataclasses.asdict(given.series), "sim_time_s": trial.time_s, **(trial.poses or {})})
    parts = {} if trial.poses is None else windows(trial.condition, camera, frames)
    row = {
        **dict.fromkeys(TRIAL_SCHEMA), "experiment": experiment, "trial": trial.index, "repeat": repeat,
        "seed": trial.seed, "model": given.model, "robot": OBSERVER, **trial.condition.columns(),
        **spike_counts(given.chosen, given.series), **responses(given.chosen, frames, parts, rate),
        "frames": len(trial.time_s), COLUMN: given.provenance,
    }  # fmt: skip
    del row["code"]  # the folder writes it
    if parts:
        row["closest_cm"] = float(away_cm(frames, camera_cm).min())
        row["seconds_in_view"] = float(parts["in_view"].sum()) / rate
    for channel in given.unknown:
        for name in (f"peak_{channel}", f"trough_{channel}", CHANNELS[channel]):
            if name in row:
                row[name] = None
    return row


def frame_table(trial: LoggedTrial, given: Given) -> pl.DataFrame:
    """Return the frames of a trial as one model answered them, of the schema of simulated frames."""
    columns: dict[str, Any] = {
        "trial": trial.index, "model": given.model, "frame": range(len(trial.time_s)), "robot": OBSERVER,
        "sim_time_s": trial.time_s,
    }  # fmt: skip
    columns |= {field.name: getattr(given.series, field.name) for field in dataclasses.fields(ResponseSeries)}
    for channel in given.unknown:
        columns |= {name: None for name in (channel, CHANNELS[channel]) if name}
    columns |= {name: None if trial.poses is None else trial.poses[name] for name in POSES}
    return pl.DataFrame(columns).select(FRAME_SCHEMA.names()).cast(FRAME_SCHEMA)
