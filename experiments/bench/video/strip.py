"""A strip of pictures for papers: moments side by side, and below them the traces with a line at each moment."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from experiments.bench.run.errors import UsageError
from experiments.bench.store.places import replacing
from experiments.bench.video.drawing import Drawer
from experiments.bench.video.layout import LEFT, Layout, Panel, ground, lane_panels, lanes_of, seeing
from experiments.bench.video.make import SIZES_PX, aspects, caption_of, latest_at
from experiments.bench.video.outside import ASPECT, outside
from experiments.bench.video.pictures import changes, pictures
from experiments.bench.video.reading import Reel
from experiments.bench.video.still import Still, eye_title

MOMENTS = range(1, 13)
WIDTH_PX = 1800
MARK = (120, 120, 120)
PAD, GAP, TITLED = 20.0, 10.0, 44.0
"""Margin, and room between pictures beside and below each other, at full width."""


def make_strip(reel: Reel, out: Path, count: int, size: tuple[int, int] | None, caption: str | None) -> None:
    """Write a strip as a PNG file.

    Parameters
    ----------
    reel
        The recording.
    out
        The file.
    count
        How many moments, evenly spaced from the first frame to the last.
    size
        Width and height in pixels; ``None``: `WIDTH_PX` and what the panels then need.
    caption
        The text at the top; ``None``: the recording's name.

    Raises
    ------
    UsageError
        For a number of moments or a size that is not legal.
    """
    if count not in MOMENTS:
        raise UsageError(f"--frames {count}: legal is {MOMENTS[0]} .. {MOMENTS[-1]}")
    width = size[0] if size else WIDTH_PX
    scale = width / WIDTH_PX
    times: list[float] = np.linspace(reel.time_s[0], reel.time_s[-1], count).tolist()
    across = (width - 2 * PAD * scale - GAP * scale * (count - 1)) / count
    view = outside(reel, round(across / ASPECT))
    robots = [ASPECT if view is not None else 1.0] if reel.tracks else []
    shapes = aspects(reel)
    rows, bottom = _rows([*robots, *shapes, *shapes[:1]], count, across, scale)
    lanes = len(lanes_of(reel))
    height = size[1] if size else round(bottom + (110 + 200 * min(lanes, 3)) * scale if lanes else bottom + PAD * scale)
    if not all(length in SIZES_PX for length in (width, height)) or height < bottom + (210 * scale if lanes else 0):
        least = round(bottom + 220 * scale)
        raise UsageError(f"--size {width}x{height}: the panels of {count} moments need {width}x{least} px, up to 3840")
    box = LEFT * scale, bottom + 44 * scale, width - 30 * scale, height - 66 * scale
    panels = lane_panels(reel, box, scale, moving=False)
    still = Still(width, height, scale)
    still.caption(caption_of(reel, caption))
    for panel, time_s in zip(rows[0] if rows else [], times, strict=False):
        still.empty(panel, f"{time_s:.2f} s")
    titles = [*(eye_title(eye) for eye in reel.eyes), ""][0 if robots else 1 :]
    for row, title in zip(rows[1:], titles, strict=True):
        for panel in row:
            still.empty(panel, title if panel == row[0] else "")
    if shapes:
        whole_row = rows[-1][-1].left + across - rows[-1][0].left
        still.change(rows[-1][0], whole_row, seeing(reel) if len(panels) > 1 else "")
    plans = rows[0] if reel.tracks and view is None else []
    if plans:
        x, y = ground(reel)
        plans = [replace(panel, x=x, y=y) for panel in plans]
        for panel in plans:
            still.plan(panel, "", reel.obstacles)
    for model in panels:
        still.lane(reel, model, panels, faint=False)
    picture = still.picture()
    drawer = Drawer(reel, Layout(width, height, (), None, None, None, {}, False, scale), picture, view)
    if view is not None:
        for panel, time_s in zip(rows[0], times, strict=True):
            drawer.outside(picture, panel, time_s)
    for panel, time_s in zip(plans, times, strict=False):
        drawer.plan(picture, panel, time_s)
    seen = rows[len(robots) :]
    for eye, row in zip(reel.eyes, seen[: len(reel.eyes)], strict=True):
        for panel, frame, time_s in zip(row, latest_at(pictures(reel.path, eye), times), times, strict=True):
            if frame is not None:
                drawer.picture(picture, panel, frame, time_s)
    if seen:
        changed = latest_at(changes(pictures(reel.path, reel.eyes[0])), times)
        for panel, change, time_s in zip(seen[-1], changed, times, strict=True):
            if change is not None:
                drawer.change(picture, panel, change, time_s)
    for panel in panels.values():
        for time_s in times:
            (start, end) = np.rint(panel.pixels(np.array([time_s, time_s]), np.array(panel.y))).astype(int).tolist()
            cv2.line(picture, start, end, MARK, max(round(scale), 1))
    with replacing(out) as partial:
        Image.fromarray(picture).save(partial, format="PNG")


def _rows(shapes: list[float], count: int, across: float, scale: float) -> tuple[list[list[Panel]], float]:
    """Return a row of panels for each kind of picture, whose shapes are width over height, and where they end."""
    top, rows = 96.0 * scale, []
    for shape in shapes:
        high = round(across / shape)
        lefts = [round(PAD * scale + k * (across + GAP * scale)) for k in range(count)]
        rows.append([Panel(left, round(top), round(across), high) for left in lefts])
        top += high + TITLED * scale
    return rows, top - (TITLED * scale if shapes else 40 * scale)
