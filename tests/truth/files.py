"""Where the files of a run have what the tests of truth need: the one place to change with entities and columns."""

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

from tests.helpers.recordings import columns

OBSERVER, STIMULUS, EYE = "/world/observer", "/world/stimulus", "/world/observer/camera"
IMAGES = f"{EYE}/image"


@dataclass(frozen=True)
class Recorded:
    """A recording, read by Rerun's public reader."""

    time_s: np.ndarray
    images: np.ndarray
    """(T, R, C), uint8."""
    columns: dict[str, dict[str, Any]]
    """Entity -> column -> its values, one for each row."""

    def poses(self, entity: str) -> tuple[np.ndarray, np.ndarray]:
        """Positions (T, 3) in cm and headings (T,) in radians, counter-clockwise."""
        columns = self.columns[entity]
        x, y, z, w = np.array([row[0] for row in columns["quaternion"]]).T
        assert np.allclose(x, 0, atol=1e-6) and np.allclose(y, 0, atol=1e-6), "a robot that stands upright"
        return np.array([row[0] for row in columns["translation"]]), 2 * np.arctan2(z, w)

    def pinhole(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The camera matrix (3, 3), and the eye's turn (3, 3) and place (3,) in the observer's frame."""
        columns = self.columns[EYE]
        lens, turn, place = (np.array(columns[name][0][0]) for name in ("image_from_camera", "mat3x3", "translation"))
        return lens.reshape(3, 3).T, turn.reshape(3, 3).T, place  # Rerun's matrices are stored by column


def recorded(path: Path) -> Recorded:
    """Read a recording."""
    held = columns(path)
    pictures = held[IMAGES]
    if "blob" in pictures:
        files = (np.array(blob[0], np.uint8) for blob in pictures["blob"])
        images = np.array([cv2.imdecode(file, cv2.IMREAD_GRAYSCALE) for file in files])
    else:
        size = pictures["format"][0][0]
        images = np.array(pictures["buffer"], np.uint8).reshape(-1, size["height"], size["width"])
    return Recorded(np.array(pictures["time"]) / 1e9, images, held)


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
    """Counts and peaks of a trial of the DSNN are those of its frames, and spikes have the potential's sign."""
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
