"""Measure a camera from folders of its frames, and say what was found as settings of the simulated eye."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from colias_sim.calibrate import (
    CalibrationError,
    edge_columns,
    edge_rows,
    exposure_loop,
    fixed_pattern,
    lean,
    noise_levels,
    photon_transfer,
    row_time_us,
    unsteadiness,
)
from experiments.bench.measured.frames import read_frame
from experiments.bench.run.errors import UsageError
from experiments.bench.store.pictures import Images

ENDINGS = (".pgm", ".png")
LONGEST = 255
"""Characters of a file's name."""
OTHERS = (".bmp", ".gif", ".jpeg", ".jpg", ".ppm", ".tif", ".tiff", ".webp")
"""Endings of pictures that are not taken, and not left out in silence."""
KINDS: Mapping[str, str] = {
    "still": "a still scene of many greys under constant light",
    "flat": "an evenly lit sheet that fills the view",
    "edge": "first the empty scene, then a dark upright object that crosses the view",
    "loop": "a still scene after the light has changed, until the picture rests",
}
"""Kinds of what a folder shows, by the beginning of its name: ``still``, ``still-dim``, ``loop01`` and so on."""
STEADY = ("still", "flat")
"""Kind of folder of a scene that does not change."""
LEAST_SHARE = 0.03
"""Share of the temporal variance, from which what is no noise is told: it makes the noise 1.5 % too large."""


@dataclass(frozen=True, slots=True)
class Found:
    """Something that was measured.

    Parameters
    ----------
    what
        In words.
    value
        With its unit.
    settings
        ``camera.NAME=VALUE`` texts that ``--set`` takes; empty where the simulated eye has no such setting, and where
        the value is not certain.
    note
        What is doubtful about it, and what to do; empty where nothing is.
    """

    what: str
    value: str
    settings: tuple[str, ...] = ()
    note: str = ""


def measure(folder: Path, fps: float, gain: float) -> list[Found]:
    """Measure whatever the folders in ``folder`` show.

    Parameters
    ----------
    folder
        It has folders of pictures (`ENDINGS`, in the order of their names), called by what they show (`KINDS`).
    fps
        Frames per second.
    gain
        The camera's gain, as ``camera.gain`` has it: noise before it is what the settings hold.

    Raises
    ------
    UsageError
        There is nothing to measure, or frames do not show what their folder's name says, in one line.
    """
    if not folder.is_dir():
        raise UsageError(f"{folder}: no such folder")
    inside = sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith("."))
    places = {kind: [path for path in inside if path.name.startswith(kind)] for kind in KINDS}
    left = [path.name for path in inside if not path.name.startswith(tuple(KINDS))]
    if not any(places.values()):
        legal = "; ".join(f"{kind}*: {meaning}" for kind, meaning in KINDS.items())
        others = f"; there are {', '.join(left)}" if left else ""
        raise UsageError(f"{folder}: no folder of frames in it ({legal}){others}")
    findings: list[Found] = []
    for kind, paths in places.items():
        sequences = {place: _stack(place) for place in paths}
        if not paths:
            continue
        try:
            findings += _MEASURES[kind](list(sequences.values()), fps, gain)
        except CalibrationError as error:
            raise UsageError(f"{', '.join(map(str, paths))}: {error}") from None
        if kind in STEADY:
            findings += [finding for place, frames in sequences.items() for finding in _unsteady(place, frames)]
    if left:
        legal = ", ".join(f"{kind}*" for kind in KINDS)
        findings.append(Found("left out", ", ".join(left), note=f"{folder}: not measured, as called by none of {legal}:"
                           f" {', '.join(left)}"))  # fmt: skip
    return findings


def _unsteady(place: Path, frames: Images) -> Iterator[Found]:
    """Say of frames that should be of a still scene that they are not."""
    share = unsteadiness(frames)
    if share < LEAST_SHARE:
        return
    means = frames.mean((1, 2), dtype=np.float64)
    text = f"{share:.0%} of the variance; the mean grey is {means.min():.1f} to {means.max():.1f}"
    note = f"{place}: its greys drift or flicker: {share:.0%} of their variance over time is no noise"
    yield Found(f"change of {place.name}", text, note=f"{note}; take it again of a still scene under constant light")


def _stack(place: Path) -> Images:
    """Return the pictures of a folder, (T, R, C), in the order of the numbers in their names: 2 before 10."""
    pictures = [path for path in place.iterdir() if path.suffix.lower() in (*ENDINGS, *OTHERS)]
    files = sorted(pictures, key=lambda path: re.sub("[0-9]+", lambda number: number[0].zfill(LONGEST), path.name))
    odd = next((path for path in files if path.suffix.lower() in OTHERS), None)
    if odd is not None:
        raise UsageError(f"{odd}: legal are pictures that keep every grey level: {', '.join(ENDINGS)}")
    if not files:
        raise UsageError(f"{place}: no pictures in it ({', '.join(ENDINGS)})")
    frames = [read_frame(path) for path in files]
    for path, frame in zip(files, frames, strict=True):
        if frame.shape != frames[0].shape:
            raise UsageError(f"{path}: {frame.shape[1]}x{frame.shape[0]} px, the first has another size")
    return np.stack(frames)


def _noise(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    levels = [noise_levels(frames) for frames in sequences]
    line = photon_transfer(levels)
    mean, variance = (np.concatenate([getattr(level, name) for level in levels]) for name in ("mean", "variance"))
    order = np.argsort(mean)[np.unique(np.linspace(0, len(mean) - 1, 5).astype(int))]
    text = ", ".join(f"{np.sqrt(max(variance[i], 0.0)):.2f} at {mean[i]:.0f}" for i in order)
    shot, read = line.shot_noise(gain), line.read_noise(gain)
    return [
        Found("noise by grey level, sd", text),
        Found("photon noise at white, sd", f"{shot:.3f}", (f"camera.shot_noise={shot:.3f}",)),
        Found("read noise, sd", f"{read:.3f}", (f"camera.read_noise={read:.3f}",)),
    ]


def _pattern(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    text = ", ".join(f"{fixed_pattern(frames):.2f} at {frames.mean():.0f}" for frames in sequences)
    return [Found("fixed pattern, sd in grey levels", f"{text} (the simulated eye has none)")]


def _rows(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    leans, speeds = [], []
    for frames in sequences:
        for slope, speed in leaning(frames, fps):
            leans.append(slope)
            speeds.append(speed)
    if not leans:
        raise CalibrationError("no two frames one after the other show the object whole")
    row = row_time_us(leans, speeds)
    text = f"{row:.0f} us, by {len(leans)} frames at {min(speeds):.0f} to {max(speeds):.0f} px/s"
    return [Found("time from row to row", text, (f"camera.row_time_us={max(row, 0.0):.0f}",))]


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
        if other != one + 1:
            continue
        (rows, columns), (own_rows, columns_of_one) = placed[one], placed[other]
        both = np.intersect1d(rows, own_rows)
        if len(both) < len(own_rows) // 2:
            continue
        moved = columns_of_one[np.isin(own_rows, both)] - columns[np.isin(rows, both)]
        yield lean(columns_of_one, own_rows), float(moved.mean()) * fps


def _loop(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    loop = exposure_loop(sequences)
    step = f"{loop.step:.4f} of it, up to {loop.steps} a frame"
    ends = {"lower": loop.low, "upper": loop.high}
    zone = "; ".join(f"{name} end {end[0]:.1f} to {end[1]:.1f}" for name, end in ends.items() if end)
    if not loop.certain:
        note = f"the exposure's step is not certain, by {len(sequences)} folders loop*, and the zone goes by it"
        more = "; take more, from other lights far from the zone, brighter and darker"
        return [
            Found("step of the exposure", f"not certain: {step}", note=f"{note}{more}"),
            Found("control zone (dead band), mean grey", f"not certain: {zone}"),
        ]
    settings: tuple[str, ...] = ()
    if loop.target is not None and loop.zone is not None and loop.low is not None and loop.high is not None:
        off = (loop.low[1] - loop.low[0] + loop.high[1] - loop.high[0]) / 4.0
        zone += f": {loop.target:.1f} +- {loop.zone:.1f}, each within {off:.1f}"
        settings = (f"camera.ae_target={loop.target:.1f}", f"camera.ae_zone={loop.zone:.1f}")
    else:
        zone += " (the other end takes sequences that come to rest from the other side)"
    exposure = ("camera.auto_exposure=true", f"camera.ae_step={loop.step:.4f}", f"camera.ae_steps={loop.steps}")
    return [
        Found("step of the exposure", step, exposure), Found("control zone (dead band), mean grey", zone, settings)
    ]  # fmt: skip


_MEASURES = {"still": _noise, "flat": _pattern, "edge": _rows, "loop": _loop}
