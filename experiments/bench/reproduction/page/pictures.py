"""Pictures of what the robot saw: camera frames out of the recordings of replicate 0."""

from __future__ import annotations

import base64
import warnings
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import rerun as rr

from experiments.bench.sources.robot import RobotTrial
from experiments.bench.store.files import read_parquet
from experiments.bench.store.pictures import Images
from experiments.bench.store.rows import recording_name
from experiments.bench.trials import Plan

SHARES = (0.1, 0.5, 0.9)
"""Shares of the time in which the stimulus is in view, at which frames are taken."""
MOST = 5
"""Conditions of one experiment that are shown."""
GAP_PX = 2
ENTITY = "/world/observer/camera/image"


@dataclass(frozen=True, slots=True)
class Strip:
    """Frames of one trial, side by side.

    Parameters
    ----------
    label
        The trial's condition, in words.
    picture
        A PNG as a data URI, `SHARES` frames in one row.
    width, height
        Of the picture, px.
    times
        When the frames were taken, in words.
    """

    label: str
    picture: str
    width: int
    height: int
    times: str


def strips(plan: Plan, folder: Path) -> list[Strip]:
    """Return a strip for each condition of an experiment, `MOST` of them at most, evenly chosen.

    Parameters
    ----------
    plan
        The experiment, with the camera that it was run with.
    folder
        Of its run. A condition without a readable recording has no strip.
    """
    first = [spec for spec in plan.specs() if spec.repeat == 0]
    chosen = sorted({round(place) for place in np.linspace(0, len(first) - 1, min(MOST, len(first)))})
    drawn_strips = [_strip(first[place], plan, folder) for place in chosen]
    return [strip for strip in drawn_strips if strip is not None]


def _strip(spec: RobotTrial, plan: Plan, folder: Path) -> Strip | None:
    camera = plan.settings.camera
    images = _video(folder / "recordings" / recording_name(spec.index), (camera.height, camera.width))
    seen = _seen(folder, spec.index, camera.hfov_deg / 2)
    if images is None or not seen or max(frame for frame, _ in seen) >= len(images):
        return None
    chosen = [seen[round(share * (len(seen) - 1))] for share in SHARES]
    gap = np.full((camera.height, GAP_PX), 255, np.uint8)
    parts: list[Images] = [part for frame, _ in chosen for part in (gap, images[frame])][1:]
    row = np.hstack(parts)
    png = cv2.imencode(".png", row)[1].tobytes()
    times = ", ".join(f"{time:.1f}" for _, time in chosen)
    return Strip(
        spec.condition.label(), f"data:image/png;base64,{base64.b64encode(png).decode()}", row.shape[1], row.shape[0],
        f"at {times} s",
    )  # fmt: skip


def _video(path: Path, shape: tuple[int, int]) -> Images | None:
    """The frames (T, R, C) that the camera took, R and C as in ``shape``; ``None`` where the recording has none."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a recording that was cut short
            chunks = list(rr.chunk.RrdReader(path).stream().filter(content=ENTITY, is_static=False).to_chunks())
    except (OSError, RuntimeError, ValueError):  # no file, or no whole one
        return None
    batches = [chunk.to_record_batch() for chunk in chunks]
    columns = [batch[name] for batch in batches for name in batch.schema.names if name.endswith(":buffer")]
    if not columns:
        return None
    flat = np.concatenate([column.flatten().flatten().to_numpy() for column in columns])
    return flat.reshape(-1, *shape) if flat.size % (shape[0] * shape[1]) == 0 else None


def _seen(folder: Path, trial: int, half_deg: float) -> list[tuple[int, float]]:
    """Number and time (s) of the frames of a trial in which the stimulus's middle is in view."""
    path = folder / "frames.parquet"
    if not path.is_file():
        return []
    table = read_parquet(path, ("trial", "model", "sim_time_s", "stimulus_bearing_deg"))
    trials, models = table["trial"].to_numpy(), np.asarray(table["model"])
    places = np.flatnonzero(trials == trial)
    places = places[models[places] == models[places[0]]] if places.size else places
    times, bearings = table["sim_time_s"].to_numpy()[places], table["stimulus_bearing_deg"].to_numpy()[places]
    return [(int(frame), float(times[frame])) for frame in np.flatnonzero(np.abs(bearings) <= half_deg)]


@dataclass(frozen=True, slots=True)
class Seen:
    """Pictures of one experiment: its name, the format of a frame in words, and strips of frames, or none."""

    name: str
    frame: str
    strips: tuple[Strip, ...]


def seen(plan: Plan, folder: Path) -> Seen:
    """Return the pictures of what the robot saw in an experiment; ``folder`` is that of its run."""
    camera = plan.settings.camera
    frame = (
        f"{camera.width}x{camera.height} grey pixels, {camera.hfov_deg:g} degrees wide, {camera.fps:g} frames a second"
    )
    return Seen(plan.experiment.name, frame, tuple(strips(plan, folder)))
