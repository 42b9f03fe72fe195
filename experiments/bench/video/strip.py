"""A strip of pictures for papers: moments side by side, and below them the traces with a line at each moment."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
from PIL import Image

from experiments.bench.engine.errors import UsageError
from experiments.bench.store.places import replacing
from experiments.bench.video.drawing import Drawer
from experiments.bench.video.layout import LEFT, Layout, Panel, ground, moves_on, trace_panels
from experiments.bench.video.make import SIZES_PX, aspects, caption_of, pictures_at
from experiments.bench.video.reading import Reel
from experiments.bench.video.still import Still

MOMENTS = range(1, 13)
WIDTH_PX = 1800
MARK = (120, 120, 120)


def make_strip(
    reel: Reel, out: Path, count: int, size: tuple[int, int] | None = None, caption: str | None = None
) -> None:  # fmt: skip
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
        Width and height in pixels; by default `WIDTH_PX` and what the panels then need.
    caption
        The text at the top; by default the recording's name.

    Raises
    ------
    UsageError
        For a number of moments or a size that is not legal.
    """
    if count not in MOMENTS:
        raise UsageError(f"--frames {count}: legal is {MOMENTS[0]} .. {MOMENTS[-1]}")
    width = size[0] if size else WIDTH_PX
    scale = width / WIDTH_PX * 1.4
    times = np.linspace(reel.time_s[0], reel.time_s[-1], count)
    eyes, plans, bottom = _panels(reel, aspects(reel), count, width, scale)
    height = size[1] if size else round(bottom + 330 * scale if reel.traces else bottom + 10 * scale)
    if not all(length in SIZES_PX for length in (width, height)) or height < bottom + (
        160 * scale if reel.traces else 0
    ):
        least = round(bottom + 170 * scale)
        raise UsageError(f"--size {width}x{height}: the panels of {count} moments need {width}x{least} px, up to 3840")
    box = LEFT * scale, bottom + 36 * scale, width - 30 * scale, height - 50 * scale
    traces = trace_panels(reel, box, scale)
    traces = {kind: _whole(panel, reel) for kind, panel in traces.items()}
    still = Still(width, height, scale)
    still.caption(caption_of(reel, caption))
    for row in eyes:
        for panel, time_s in zip(row, times, strict=True):
            still.empty(panel, f"{time_s:.2f} s")
    for panel, time_s in zip(plans, times, strict=False):
        still.plan(panel, "" if eyes else f"{time_s:.2f} s", reel.obstacles)
    for key in traces:
        still.traces(reel, key, traces, faint=False)
    picture = still.picture()
    drawer = Drawer(reel, Layout(width, height, (), None, {}, moves_on(reel), scale), picture)
    for eye, row in zip(reel.eyes, eyes, strict=True):
        for panel, frame, time_s in zip(row, pictures_at(reel, eye, times.tolist()), times, strict=True):
            if frame is not None:
                drawer.picture(picture, panel, frame, float(time_s))
    for panel, time_s in zip(plans, times, strict=False):
        drawer.plan(picture, panel, float(time_s))
    for panel in traces.values():
        for time_s in times:
            (start, end) = np.rint(panel.pixels(np.array([time_s, time_s]), np.array(panel.y))).astype(int).tolist()
            cv2.line(picture, start, end, MARK, max(round(scale), 1))
    with replacing(out) as partial:
        Image.fromarray(picture).save(partial, format="PNG")


def _panels(
    reel: Reel, shapes: list[float], count: int, width: int, scale: float
) -> tuple[list[list[Panel]], list[Panel], float]:
    """Return a row of panels for each eye, one of plans, and where they end."""
    pad, gap, top = 14.0 * scale, 8.0 * scale, 62.0 * scale
    across = (width - 2 * pad - gap * (count - 1)) / count
    rows = []
    for shape in shapes:
        high = round(across / shape)
        rows.append([Panel(round(pad + k * (across + gap)), round(top), round(across), high) for k in range(count)])
        top += high + 28 * scale
    if not reel.tracks:
        return rows, [], top - 28 * scale
    x, y = ground(reel)
    top -= 16 * scale if rows else 0
    plans = [Panel(round(pad + k * (across + gap)), round(top), round(across), round(across), x, y)
             for k in range(count)]  # fmt: skip
    return rows, plans, top + across


def _whole(panel: Panel, reel: Reel) -> Panel:
    """Make the panel with all of the recording's time."""
    times = float(reel.time_s[0]), float(reel.time_s[-1]) + 1e-6
    return Panel(panel.left, panel.top, panel.width, panel.height, times, panel.y)
