"""A trial of a robot's log: the source of its frames, measured by their times, and its recording."""

import hashlib
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import polars as pl

from colias_sim import bearing
from colias_sim.config import CameraConfig
from dsnn.pictures import read_picture
from experiments.base.console import count
from experiments.base.errors import UsageError, as_usage_error
from experiments.declare.conditions import pose_of
from experiments.robot.logs import POSES, TIME, logged
from experiments.settings.models import ConfiguredModel
from experiments.settings.pictures import by_number
from experiments.show import record as rerun
from experiments.show.play import Sample, Showing, Trial
from experiments.show.trial_rows import FRAME_SCHEMA, away_cm, responses, windows
from experiments.store.recordings import Images
from experiments.store.tables import COLUMN, OBSERVER

Floats = npt.NDArray[np.float64]
UNKNOWN = ("phase", "achieved_speed_cm_s", "path_error_mm", "drift_mm", "drive", "darkest", "brightest", "closest_cm",
           "seconds_in_view")  # fmt: skip
"""Columns of ``trials.parquet`` of which a robot's log knows nothing; of the last two with a tracker it does."""
RATE_TOLERANCE = 0.001
"""Share by which a log's frame rate may differ from the camera's setting and still be taken for it."""
MOST_TICK = 0.95
"""Longest tick of a log's clock, as a share of a frame's time, for which the camera's setting may explain the times."""
PICTURES = (".pgm", ".png")
LEAST_FPS = 0.5
"""Slowest rate of a log's frames, 1/s: below, ``time_s`` is in another unit than seconds."""


@dataclass(frozen=True, slots=True)
class LogTrial(Trial):
    """A trial of a log, and the source of its frames.

    Parameters
    ----------
    rows
        Its rows.
    camera
        The robot's.
    frames
        The folder of the trials' frames, if there is one.
    origins
        Label of a model -> where its responses come from.
    unknown
        Label of a model that the log has -> the channels that it has and the log has not.
    """

    rows: pl.DataFrame
    camera: CameraConfig
    frames: Path | None
    origins: Mapping[str, str]
    unknown: Mapping[str, Sequence[str]]

    frame_columns: ClassVar[pl.Schema] = FRAME_SCHEMA

    @property
    def shown(self) -> pl.DataFrame:
        """A row per frame: those of the first model."""
        return self.rows.filter(pl.col("model") == self.rows["model"][0])

    @property
    def fps(self) -> float:
        """Frame rate, 1/s: that of the camera where the times go by it, else what they tell."""
        rate, _ = rate_and_steps(self.shown[TIME].to_numpy(), self.camera.fps)
        return self.camera.fps if abs(rate / self.camera.fps - 1.0) <= RATE_TOLERANCE else rate

    @property
    def shape(self) -> tuple[int, int]:
        """(R, C) of a frame."""
        return self.camera.height, self.camera.width

    @property
    def tracked(self) -> bool:
        """Whether a tracker has told the poses."""
        return POSES[0] in self.rows.columns

    def sources(self) -> Iterator[tuple[str, Any, Sequence[ConfiguredModel]]]:
        """Return the trial itself as the source; models that the log has respond what it says."""
        rows = self.rows.partition_by("model", as_dict=True)
        models = [logged(m, rows[(m.label,)]) if m.label in self.unknown else m for m in self.models]
        yield "", self, models

    def __iter__(self) -> Iterator[Sample]:
        """Yield the frames, blank ones where nobody kept them, with the poses that a tracker has told."""
        rows = self.shown.to_dicts()
        frames = np.zeros((len(rows), *self.shape), np.uint8)
        if self.frames is not None:
            frames = read_frames(trial_folder(self.frames, self.index), self.shape)
        for row, image in zip(rows, frames, strict=True):
            truth = {"robot": OBSERVER, "time_s": row[TIME], "stimulus_bearing_deg": None}
            truth |= {name: row.get(name) for name in POSES}
            if self.tracked:
                stimulus, observer = (pose_of(itemgetter(*names)(row)) for names in (POSES[:3], POSES[3:]))
                ahead = bearing(observer, stimulus, self.camera.forward_cm / 100)
                truth["stimulus_bearing_deg"] = math.degrees(ahead)
            yield Sample(row[TIME], image, truth)

    def columns(self, _truth: pl.DataFrame) -> dict[str, Any]:
        """Return the robot that sees, and the condition. A robot's trial has no seed."""
        return {"robot": OBSERVER, "seed": None, **self.condition.columns()}

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Return a model's responses in the whole trial, and with a tracker in parts of it.

        Parameters
        ----------
        model
            The model.
        frames
            A row per frame: time, poses, responses.
        """
        parts = windows(self.condition, self.camera, frames) if self.tracked else {}
        measured = {**dict.fromkeys(UNKNOWN), **responses(model, frames, parts, self.fps)}
        if self.tracked:
            measured["closest_cm"] = float(away_cm(frames, self.camera.forward_cm).min())
            measured["seconds_in_view"] = float(parts["in_view"].sum()) / self.fps
        lost = {f"{end}_{channel}" for channel in self.unknown.get(model.label, ()) for end in ("peak", "trough")}
        return {**measured, **dict.fromkeys(lost & measured.keys()), COLUMN: self.origins[model.label]}


def rate_and_steps(time_s: Floats, nominal: float) -> tuple[float, Floats]:
    """Find the rate of a camera by the times of its frames, and how many frames it went from each time to the next.

    A clock that ticks rounds the times, so single differences tell no rate: only the whole stretch does. Where the
    ticks are nearly as long as a frame, several rates explain the times. Then the rate with the fewest lost frames
    counts, and the nominal one before others.

    Parameters
    ----------
    time_s
        Times in s that grow, (T,).
    nominal
        The rate that the camera should have, 1/s.

    Returns
    -------
    rate : float
        Frames per second.
    steps : ndarray
        (T - 1,) whole numbers: 1, or more where frames are lost. After a time that came late the next is 0.
    """
    waits = np.diff(time_s)
    if not waits.size:
        return nominal, waits
    period = waits[waits < 1.8 * np.median(waits)].mean()  # without waits for lost frames
    for _ in range(3):
        steps = np.rint(waits / period)
        period = waits.sum() / steps.sum()
    # Frames at the nominal rate have phases in its period that spread by less than a tick.
    tick = nominal * float(np.gcd.reduce(np.rint(1e6 * waits).astype(np.int64))) / 1e6
    phases = np.sort(time_s * nominal % 1.0)
    free = np.diff(phases, append=phases[0] + 1.0)
    spread, first = 1.0 - free.max(), phases[(free.argmax() + 1) % len(phases)]
    of_nominal = np.diff(np.rint(time_s * nominal - first - spread / 2))
    explained = spread < tick - 1e-6 and tick < MOST_TICK and of_nominal.sum() <= steps.sum()
    return (nominal, of_nominal) if explained else (float(1.0 / period), steps)


def trial_folder(folder: Path, trial: int) -> Path:
    """Return the folder of a trial's frames."""
    return folder / f"trial-{trial:04d}"


def pictures_in(folder: Path) -> list[Path]:
    """Return the pictures of a folder in the order of their numbers, 2 before 10; empty where there are none."""
    return sorted((path for path in folder.glob("*") if path.suffix.lower() in PICTURES), key=by_number)


def read_frames(folder: Path, shape: tuple[int, int] | None = None) -> Images:
    """Read pictures as a camera measured them, (T, R, C); `UsageError` for one of another size or kind."""
    with as_usage_error():
        frames = [read_picture(path, raw=True) for path in pictures_in(folder)]
    sizes = {frame.shape for frame in frames}
    if len(sizes) != 1 or shape not in (None, *sizes):
        rows, columns = shape or ("R", "C")
        raise UsageError(f"{folder} must have pictures ({', '.join(PICTURES)}) of {columns}x{rows} px, all of one size")
    return np.stack(frames)


def record(trial: LogTrial, showings: Sequence[Showing], rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a log's trial, as the bytes of an .rrd file: frames where there are some, responses."""
    (showing,) = showings
    truth, shown = showing.truth(), showing.series()
    images = {"": np.stack([sample.image for sample in showing.samples])} if trial.frames else {}
    by_model = {model.label: series for model, series in shown}
    frames = rerun.Frames(truth["time_s"].to_numpy(), np.arange(truth.height), by_model, images)
    content = rerun.Content(tuple(rerun.RecordedModel.of(model) for model, _ in shown), tuple(images))
    origin = rows[0][COLUMN]
    values = {"experiment": trial.experiment, "trial": trial.index, COLUMN: origin, **trial.condition.columns()}
    digest = hashlib.blake2s(trial.rows.write_csv().encode(), digest_size=6).hexdigest()
    return rerun.write(
        content, frames, f"{trial.index:04d} {trial.label()}, {origin}",
        f"{trial.experiment}-measured-{trial.index:04d}-{digest}", {"trial": rerun.properties(values)},
    )  # fmt: skip


def lacking(trial: LogTrial) -> tuple[int, str]:
    """Return how many frames a log lacks inside a trial, by their times, and a note about them; empty of none."""
    times = trial.shown[TIME].to_numpy()
    lost = rate_and_steps(times, trial.camera.fps)[1] - 1  # -1 where a late time stamp is made up for
    if (number := round(float(lost.sum()))) <= 0:
        return 0, ""
    return number, (f"trial {trial.index} lacks {count(number, 'frame')} at {trial.fps:.3g} frames/s, the first after"
                    f" {times[(lost > 0).argmax()]:.2f} s: spikes of these frames are not counted")  # fmt: skip
