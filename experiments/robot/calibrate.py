"""Measure a camera from folders of its frames: settings of the simulated eye, and what is doubtful about them."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from colias_sim import calibrate
from experiments.base.errors import UsageError, as_usage_error
from experiments.robot.log_trial import read_frames
from experiments.store.recordings import Images

Measured = tuple[dict[str, object], list[str]]
"""Parameters of the camera, as ``--set camera.NAME=VALUE`` takes them, and what is doubtful."""
LEAST_SHARE = 0.03
"""Share of the variance over time from which a scene was not still."""


def measure(folder: Path, fps: float, gain: float) -> Measured:
    """Measure what the folders in a folder show.

    Parameters
    ----------
    folder
        Its folders hold pictures (``.pgm``, ``.png``, in the order of their numbers) and are named by what they show:
        ``still*`` a still scene of many greys under constant light, ``edge*`` first the empty scene and then a dark
        upright object that crosses the view, ``loop*`` a still scene after the light has changed, until the picture
        rests.
    fps
        Frames per second of ``edge*``.
    gain
        The camera's gain, as ``camera.gain`` has it: noise before it is what the settings hold.

    Returns
    -------
    dict
        Parameter of the camera -> value.
    list of str
        What is doubtful about it.

    Raises
    ------
    UsageError
        There is nothing to measure, or frames do not show what their folder's name says.
    """
    settings: dict[str, object] = {}
    notes: list[str] = []
    kinds = {"still": lambda films: _noise(films, gain), "edge": lambda films: _row_time(films, fps), "loop": _exposure}
    for kind, measured in kinds.items():
        films = [read_frames(path) for path in sorted(folder.glob(f"{kind}*"))]
        with as_usage_error(f"{folder}, {kind}*: "):
            found, doubts = measured(films) if films else ({}, [])
        settings |= found
        notes += [f"{kind}*: {doubt}" for doubt in doubts]
    if not settings and not notes:
        raise UsageError(f"{folder} must have folders of frames called still*, edge* or loop*")
    return settings, notes


def _noise(films: Sequence[Images], gain: float) -> Measured:
    shot_noise, read_noise = calibrate.photon_transfer([calibrate.noise_levels(frames) for frames in films], gain)
    share = max(map(calibrate.unsteadiness, films))
    doubt = f"greys drift or flicker, {share:.0%} of their variance: light is corrected, but not what moves"
    values = {"shot_noise": f"{shot_noise:.3f}", "read_noise": f"{read_noise:.3f}"}
    return {"gain": f"{gain:g}", **values}, [doubt] if share >= LEAST_SHARE else []


def _row_time(films: Sequence[Images], fps: float) -> Measured:
    pairs = [pair for frames in films for pair in leaning(frames, fps)]
    if not pairs:
        raise calibrate.CalibrationError("no two frames one after the other show the object whole")
    leans, speeds = zip(*pairs, strict=True)
    measured = calibrate.row_time_us(leans, speeds)
    doubt = f"measured {measured:.0f} us a row: rows that are read from the top down cannot lean so; 0 is taken"
    return {"row_time_us": f"{max(measured, 0.0):.0f}"}, [doubt] if measured < 0.0 else []


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
            rows = calibrate.edge_rows(frame, empty)
            placed[number] = rows, calibrate.edge_columns(frame, empty, rows)
        except calibrate.CalibrationError:
            continue
    for one, other in pairwise(sorted(placed)):
        (rows, columns), (own_rows, own_columns) = placed[one], placed[other]
        both = np.intersect1d(rows, own_rows)
        if other == one + 1 and len(both) >= len(own_rows) // 2:
            moved = own_columns[np.isin(own_rows, both)] - columns[np.isin(rows, both)]
            yield calibrate.lean(own_columns, own_rows), float(moved.mean()) * fps


def _exposure(films: Sequence[Images]) -> Measured:
    step, steps, certain = calibrate.exposure_loop(films)
    if not certain:
        return {}, [f"the exposure's step is uncertain (folders: {len(films)}); take more, from brighter and darker"]
    settings: dict[str, object] = {"auto_exposure": "true", "ae_step": f"{step:.4f}", "ae_steps": steps}
    low, high = calibrate.control_zone(films, step)
    if low is not None and high is not None:
        target, zone = (sum(low) + sum(high)) / 4, (sum(high) - sum(low)) / 4
        settings |= {"ae_target": f"{target:.1f}", "ae_zone": f"{zone:.1f}"}
    return settings, []
