"""Where the files of a run have what the tests of truth need: the one place to change with entities and columns."""

from __future__ import annotations

import importlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import cv2
import mujoco
import numpy as np
import polars as pl
from mujoco.rendering.classic import gl_context
from rerun.chunk import RrdReader

TIMELINE = "time"
BUFFER, BLOB = "Image:buffer", "EncodedImage:blob"
OBSERVER, STIMULUS, EYE = "/world/observer", "/world/stimulus", "/world/observer/camera"
IMAGES, SPIKES = f"{EYE}/image", "/models/{model}/spikes/{channel}"


@dataclass(frozen=True)
class Recorded:
    """A recording, read by Rerun's public reader."""

    time_s: np.ndarray
    images: np.ndarray
    """(T, R, C), uint8."""
    columns: dict[str, dict[str, Any]]
    """Entity -> component -> its values, one for each row."""

    def poses(self, entity: str) -> tuple[np.ndarray, np.ndarray]:
        """Positions (T, 3) in cm and headings (T,) in radians, counter-clockwise."""
        columns = self.columns[entity]
        x, y, z, w = np.array([row[0] for row in columns["Transform3D:quaternion"]]).T
        assert np.allclose(x, 0, atol=1e-6) and np.allclose(y, 0, atol=1e-6), "a robot that stands upright"
        return np.array([row[0] for row in columns["Transform3D:translation"]]), 2 * np.arctan2(z, w)

    def pinhole(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The camera matrix (3, 3), and the eye's turn (3, 3) and place (3,) in the observer's frame."""
        columns = self.columns[EYE]
        lens, turn, place = (
            np.array(columns[name][0][0])
            for name in ("Pinhole:image_from_camera", "Transform3D:mat3x3", "Transform3D:translation")
        )
        return lens.reshape(3, 3).T, turn.reshape(3, 3).T, place  # Rerun's matrices are stored by column

    def marks(self, model: str, channel: str) -> dict[int, int]:
        """Frame -> the side of 0 on which its spikes are drawn."""
        columns = self.columns[SPIKES.format(model=model, channel=channel)]
        heights = [row[0] for row in columns["Scalars:scalars"] if row]
        return {int(f): int(np.sign(height)) for f, height in zip(columns["frame"], heights, strict=True) if height}


def recorded(path: Path) -> Recorded:
    """Read a recording, without layer maps."""
    columns: dict[str, dict[str, Any]] = {}
    for chunk in RrdReader(path).stream():
        if "/maps/" in chunk.entity_path:
            continue
        batch = chunk.to_record_batch()
        entity = columns.setdefault(chunk.entity_path, {})
        for name, values in zip(batch.schema.names, batch.columns, strict=True):
            if name == TIMELINE:
                entity[name] = values.to_numpy(zero_copy_only=False) / np.timedelta64(1, "s")
            elif name in (BUFFER, BLOB):
                entity[name] = [row.values.flatten().to_numpy() for row in values]
            else:
                entity[name] = values.to_pylist()
    pictures = columns[IMAGES]
    if BLOB in pictures:
        images = np.array([cv2.imdecode(blob, cv2.IMREAD_GRAYSCALE) for blob in pictures[BLOB]])
    else:
        size = pictures["Image:format"][0][0]
        images = np.array(pictures[BUFFER]).reshape(-1, size["height"], size["width"])
    return Recorded(pictures[TIMELINE], images, columns)


@dataclass(frozen=True)
class Trial:
    """A trial of a run: its row, its rows of frames, and its recording."""

    row: dict[str, Any]
    frames: dict[str, np.ndarray]
    recording: Recorded


def trials(folder: Path) -> list[Trial]:
    """Read a run of one model whose trials are all recorded."""
    frames = pl.read_parquet(folder / "frames.parquet")
    names = ("frame", "time_s", "hs", "vs", "hs_spikes", "vs_spikes", "stimulus_bearing_deg", "stimulus_x_cm",
             "stimulus_y_cm")  # fmt: skip
    found = []
    for row in pl.read_parquet(folder / "trials.parquet").to_dicts():
        own = frames.filter(trial=row["trial"])
        path = folder / "recordings" / f"trial-{row['trial']:04d}.rrd"
        series = {name: own[name].to_numpy() for name in names if name in own.columns}
        found.append(Trial(row, series, recorded(path)))
    return found


def picture(env: Any) -> np.ndarray:
    """Render what an env's eye sees at this moment by MuJoCo's own renderer: luma (R, C), uint8."""
    scene = env.unwrapped._sim
    # MuJoCo chooses its backend when it is imported, which here may be before colias_sim has named one.
    backend = importlib.import_module(f"mujoco.{os.environ['MUJOCO_GL']}")
    with patch.object(gl_context, "GLContext", backend.GLContext), mujoco.Renderer(scene.model, 72, 99) as renderer:
        renderer.update_scene(scene.data, camera="observer/eye")
        return cv2.cvtColor(renderer.render(), cv2.COLOR_RGB2GRAY)


def recount(trial: Trial) -> None:
    """Counts, peaks and marks of a trial of the DSNN are those of its frames, and spikes have the potential's sign."""
    row, frames = trial.row, trial.frames
    assert row["spikes"] == row["hs_spikes"]
    for channel in ("hs", "vs"):
        potential, spikes = frames[channel], frames[f"{channel}_spikes"]
        assert row[f"{channel}_spikes"] == np.abs(spikes).sum()
        np.testing.assert_allclose(
            [row[f"peak_{channel}"], row[f"trough_{channel}"]], [potential.max(), potential.min()], atol=1e-6
        )
        fired = np.flatnonzero(spikes)
        assert np.array_equal(np.sign(spikes[fired]), np.sign(potential[fired]))
        expected = {int(frame): int(np.sign(spikes[frame])) for frame in fired}
        assert trial.recording.marks("dsnn", channel) == expected, channel
