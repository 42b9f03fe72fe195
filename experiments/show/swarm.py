"""The recording of many robots: the plan with every way, what each sees, a raster of potentials, and collisions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import cv2
import numpy as np
import polars as pl
import rerun as rr

from colias_sim import SceneConfig
from colias_sim.envs.swarm import Swarm
from experiments.base import palette
from experiments.base.palette import rgb
from experiments.show import record
from experiments.show.record import Images, chunk, fixed

EVERY, SHOWN_FRAMES, ROW_PX = 3, 15, 8
"""Frames from one picture of an eye to the next; frames for which a collision is marked; rows of the raster a robot."""


def raster(potentials: Sequence[Sequence[float]]) -> Images:
    """Return potentials of robots as grey levels, a band a robot, the first uppermost: -1 is black, 1 white."""
    grey = np.clip(127.5 + 127.5 * np.array(potentials, np.float64), 0, 255).astype(np.uint8)
    return np.repeat(grey, ROW_PX, axis=0)


def write(steps: pl.DataFrame, swarm: Swarm, images: Mapping[str, Sequence[Images]], name: str) -> bytes:
    """Return the recording of a trial, as the bytes of an .rrd file.

    Parameters
    ----------
    steps
        Its rows of ``frames.parquet``, robot after robot.
    swarm
        The robots.
    images
        What each saw, every `EVERY` frames; empty of blind robots.
    name
        Its name for people.
    """
    robots = {robot: rows for (robot,), rows in steps.group_by("robot", maintain_order=True)}
    first = next(iter(robots.values()))
    time_s, frame = first["time_s"].to_numpy(), first["frame"].to_numpy()
    poses = {robot: rows.select("x_cm", "y_cm", "heading_deg").to_numpy() for robot, rows in robots.items()}
    met = [(at, pair) for at, pair in swarm.collisions if set(pair) <= robots.keys()]
    marks = [[np.mean([poses[one][at, :2] for one in pair], axis=0) for at, pair in met if 0 <= k - at < SHOWN_FRAMES]
             for k in range(len(frame))]  # fmt: skip
    points = np.array([(*place, 4.0) for places in marks for place in places]).reshape(-1, 3)
    at = slice(None, None, EVERY)
    more = [
        fixed("world/collisions", rr.Points3D.from_fields(colors=[rgb(palette.TRUE)], radii=[2.0])),
        chunk("world/collisions", record.times(time_s, frame),
              rr.Points3D.columns(positions=points).partition(list(map(len, marks)))),
    ]  # fmt: skip
    nose = rr.Arrows3D(origins=[[0, 0, 4.5]], vectors=[[4.5, 0, 0]], colors=[rgb(palette.TRUE)], radii=[0.4])
    more += [fixed(f"world/{robot}/heading", nose) for robot in robots]
    for robot, seen in images.items():
        more.append(fixed(f"eyes/{robot}", rr.EncodedImage.from_fields(media_type="image/jpeg")))
        when = record.times(time_s[at], frame[at])
        more.append(chunk(f"eyes/{robot}", when, rr.EncodedImage.columns(blob=record.jpegs(seen))))
    channel = "looming" if images and first["looming"].n_unique() > 1 else "hs"
    if images:
        png = cv2.imencode(".png", raster([rows[channel].fill_null(0.0).to_list() for rows in robots.values()]))[1]
        more.append(fixed("raster", rr.EncodedImage(contents=png.tobytes(), media_type="image/png")))
    content = record.Content(
        scene=SceneConfig(), robots=tuple((robot, swarm.options.body) for robot in robots), above=True,
        seers=tuple(images), raster=f"{channel} of {', '.join(robots)}: robots by time" if images else "",
    )  # fmt: skip
    told = {
        "env": "swarm",
        "collisions": len(met),
        "seconds": float(time_s[-1]),
    }  # with an env, the whole arena is shown
    held, moved = {"episode": record.properties(told)}, record.Frames(time_s, frame, poses=poses)
    return record.write(content, moved, name, None, held, more, record.note({"trial": name, **told}))
