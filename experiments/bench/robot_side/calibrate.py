"""Measure a camera from folders of its frames, and say what was found as settings of the simulated eye."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import polars as pl

from colias_sim.calibrate import (
    CalibrationError,
    edge_columns,
    edge_rows,
    exposure_loop,
    lean,
    noise_levels,
    photon_transfer,
    row_time_us,
    unsteadiness,
)
from experiments.bench.run.errors import UsageError
from experiments.bench.run.recordings import Images
from experiments.bench.sources.log import PICTURES, in_order, read_frames

MEASURED = pl.Schema([("measured", pl.String()), ("value", pl.String()), ("settings", pl.List(pl.String()))])
"""``settings`` are ``camera.NAME=VALUE`` texts that ``--set`` takes; empty where the value is not certain."""
LEAST_SHARE = 0.03
"""Share of the variance over time from which a scene was not still: it makes the noise 1.5 % too large."""


def measure(folder: Path, fps: float, gain: float) -> tuple[pl.DataFrame, list[str]]:
    """Measure what the folders in a folder show.

    Parameters
    ----------
    folder
        Its folders hold pictures (`PICTURES`, in the order of their numbers) and are named by what they show:
        ``still*`` a still scene of many greys under constant light, ``edge*`` first the empty scene and then a dark
        upright object that crosses the view, ``loop*`` a still scene after the light has changed, until the picture
        rests.
    fps
        Frames per second of ``edge*``.
    gain
        The camera's gain, as ``camera.gain`` has it: noise before it is what the settings hold.

    Returns
    -------
    polars.DataFrame
        What was measured, of `MEASURED`.
    list of str
        What is doubtful about it.

    Raises
    ------
    UsageError
        There is nothing to measure, or frames do not show what their folder's name says.
    """
    rows: list[tuple[str, str, list[str]]] = []
    notes: list[str] = []
    for kind in ("still", "edge", "loop"):
        places = sorted(path for path in folder.glob(f"{kind}*") if path.is_dir())
        if not places:
            continue
        try:
            sequences = [_frames(place) for place in places]
            if kind == "still":
                rows += _noise(sequences, gain)
                notes += _changes(places, sequences)
            elif kind == "edge":
                rows += _row_time(sequences, fps)
            else:
                found, doubts = _exposure(sequences)
                rows, notes = rows + found, notes + doubts
        except CalibrationError as error:
            raise UsageError(f"{', '.join(map(str, places))}: {error}") from None
    if not rows:
        raise UsageError(f"{folder} must have folders of frames called still*, edge* or loop*")
    return pl.DataFrame(rows, MEASURED, orient="row"), notes


def _frames(place: Path) -> Images:
    """Return the pictures of a folder, (T, R, C), in the order of the numbers in their names."""
    files = sorted((path for path in place.iterdir() if path.suffix.lower() in PICTURES), key=in_order)
    if not files:
        raise UsageError(f"{place} must have pictures ({', '.join(PICTURES)}), got none")
    return read_frames(files)


def _noise(sequences: Sequence[Images], gain: float) -> list[tuple[str, str, list[str]]]:
    levels = [noise_levels(frames) for frames in sequences]
    line = photon_transfer(levels)
    mean, variance = (np.concatenate([getattr(level, name) for level in levels]) for name in ("mean", "variance"))
    order = np.argsort(mean)[np.unique(np.linspace(0, len(mean) - 1, 5).astype(int))]
    text = ", ".join(f"{np.sqrt(max(variance[i], 0.0)):.2f} at {mean[i]:.0f}" for i in order)
    shot, read = line.shot_noise(gain), line.read_noise(gain)
    return [
        ("noise by grey level, sd", text, []),
        ("photon noise at white, sd", f"{shot:.3f}", [f"camera.shot_noise={shot:.3f}"]),
        ("read noise, sd", f"{read:.3f}", [f"camera.read_noise={read:.3f}"]),
    ]


def _changes(places: Sequence[Path], sequences: Sequence[Images]) -> Iterator[str]:
    """Say of frames that should be of a still scene that they are not."""
    for place, frames in zip(places, sequences, strict=True):
        if (share := unsteadiness(frames)) >= LEAST_SHARE:
            problem = f"its greys drift or flicker, which is {share:.0%} of their variance: the noise is too large"
            yield f"{place}: {problem}; take it again under constant light"


def _row_time(sequences: Sequence[Images], fps: float) -> list[tuple[str, str, list[str]]]:
    pairs = [pair for frames in sequences for pair in leaning(frames, fps)]
    if not pairs:
        raise CalibrationError("no two frames one after the other show the object whole")
    leans, speeds = zip(*pairs, strict=True)
    row = row_time_us(leans, speeds)
    text = f"{row:.0f} us, by {len(leans)} frames at {min(speeds):.0f} to {max(speeds):.0f} px/s"
    return [("time from row to row", text, [f"camera.row_time_us={max(row, 0.0):.0f}"])]


def leaning(frames: Images, fps: float) -> Iterator[tuple[float, float]]:
    """Yield the lean of a moving object's left edge, px a row, and its speed, px/s, of each frame that shows both.

    Parameters
    ----------
    frames
        (T, R, C): the first is the scene without the object.
    fps
        Frames per second.
    """
    empty, placed = frames[0].astype(np.float64), {}
    for number, frame in enumerate(frames[1:], start=1):
        try:
            rows = edge_rows(frame, empty)
            placed[number] = rows, edge_columns(frame, empty, rows)
        except CalibrationError:
            continue
    for one, other in pairwise(sorted(placed)):
        (rows, columns), (own_rows, own_columns) = placed[one], placed[other]
        both = np.intersect1d(rows, own_rows)
        if other == one + 1 and len(both) >= len(own_rows) // 2:
            moved = own_columns[np.isin(own_rows, both)] - columns[np.isin(rows, both)]
            yield lean(own_columns, own_rows), float(moved.mean()) * fps


def _exposure(sequences: Sequence[Images]) -> tuple[list[tuple[str, str, list[str]]], list[str]]:
    loop = exposure_loop(sequences)
    step = f"{loop.step:.4f} of it, up to {loop.steps} a frame"
    ends = {"lower": loop.low, "upper": loop.high}
    zone = "; ".join(f"{name} end {end[0]:.1f} to {end[1]:.1f}" for name, end in ends.items() if end)
    names = "step of the exposure", "control zone (dead band), mean grey"
    if not loop.certain:
        note = f"the exposure's step is not certain by {len(sequences)} folders loop*, and the zone depends on it; take"
        rows = [(name, f"not certain: {text}", list[str]()) for name, text in zip(names, (step, zone), strict=True)]
        return rows, [f"{note} more from other lights, brighter and darker"]
    settings: list[str] = []
    if loop.target is not None and loop.zone is not None:
        zone += f": {loop.target:.1f} +- {loop.zone:.1f}"
        settings = [f"camera.ae_target={loop.target:.1f}", f"camera.ae_zone={loop.zone:.1f}"]
    exposure = ["camera.auto_exposure=true", f"camera.ae_step={loop.step:.4f}", f"camera.ae_steps={loop.steps}"]
    return [(names[0], step, exposure), (names[1], zone, settings)], []
