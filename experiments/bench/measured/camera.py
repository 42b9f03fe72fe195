"""Measure a camera from folders of its frames, and say what was found as settings of the simulated eye."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt

from colias_sim.metrology import (
    MetrologyError,
    edge_columns,
    edge_rows,
    exposure_loop,
    fixed_pattern,
    lean,
    noise_levels,
    photon_transfer,
    row_time_us,
)
from experiments.bench.core.errors import UsageError
from experiments.bench.core.store.pictures import read_picture

Images = npt.NDArray[np.uint8]
ENDINGS = (".pgm", ".png")
KINDS: Mapping[str, str] = {
    "still": "a still scene of many greys under constant light",
    "flat": "an evenly lit sheet that fills the view",
    "edge": "first the empty scene, then a dark upright object that crosses the view",
    "loop": "a still scene after the light has changed, until the picture rests",
}
"""What a folder shows, by the beginning of its name: ``still``, ``still-dim``, ``loop-01`` and so on."""


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
        ``camera.NAME=VALUE`` texts that ``--set`` takes; empty where the simulated eye has no such setting.
    """

    what: str
    value: str
    settings: tuple[str, ...] = ()


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
    taken = {kind: _sequences(folder, kind) for kind in KINDS}
    if not any(taken.values()):
        legal = "; ".join(f"{kind}*: {said}" for kind, said in KINDS.items())
        raise UsageError(f"{folder}: no folder of frames in it ({legal})")
    found: list[Found] = []
    for kind, own in taken.items():
        if own:
            try:
                found += _MEASURES[kind](list(own.values()), fps, gain)
            except MetrologyError as error:
                raise UsageError(f"{', '.join(map(str, own))}: {error}") from None
    return found


def _sequences(folder: Path, kind: str) -> dict[Path, Images]:
    places = sorted(path for path in folder.iterdir() if path.is_dir() and path.name.partition("-")[0] == kind)
    return {place: _stack(place) for place in places}


def _stack(place: Path) -> Images:
    """The pictures of a folder, (T, R, C)."""
    files = sorted(path for path in place.iterdir() if path.suffix in ENDINGS)
    if not files:
        raise UsageError(f"{place}: no pictures in it ({', '.join(ENDINGS)})")
    frames = [read_picture(path) for path in files]
    for path, frame in zip(files, frames, strict=True):
        if frame.shape != frames[0].shape:
            raise UsageError(f"{path}: {frame.shape[1]}x{frame.shape[0]} px, the first has another size")
    return np.stack(frames)


def _noise(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    levels = [noise_levels(frames) for frames in sequences]
    line = photon_transfer(levels)
    mean, variance = (np.concatenate([getattr(own, name) for own in levels]) for name in ("mean", "variance"))
    order = np.argsort(mean)[np.unique(np.linspace(0, len(mean) - 1, 5).astype(int))]
    said = ", ".join(f"{np.sqrt(max(variance[i], 0.0)):.2f} at {mean[i]:.0f}" for i in order)
    shot, read = line.shot_noise(gain), line.read_noise(gain)
    return [
        Found("noise by grey level, sd", said),
        Found("photon noise at white, sd", f"{shot:.3f}", (f"camera.shot_noise={shot:.3f}",)),
        Found("read noise, sd", f"{read:.3f}", (f"camera.read_noise={read:.3f}",)),
    ]


def _pattern(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    said = ", ".join(f"{fixed_pattern(frames):.2f} at {frames.mean():.0f}" for frames in sequences)
    return [Found("fixed pattern, sd in grey levels", f"{said} (the simulated eye has none)")]


def _rows(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    leans, speeds = [], []
    for frames in sequences:
        for slope, speed in leaning(frames, fps):
            leans.append(slope)
            speeds.append(speed)
    if not leans:
        raise MetrologyError("no two frames one after the other show the object whole")
    row = row_time_us(leans, speeds)
    said = f"{row:.0f} us, by {len(leans)} frames at {min(speeds):.0f} to {max(speeds):.0f} px/s"
    return [Found("time from row to row", said, (f"camera.row_time_us={max(row, 0.0):.0f}",))]


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
        except MetrologyError:
            continue
    for one, other in pairwise(sorted(placed)):
        if other != one + 1:
            continue
        (rows, columns), (own_rows, own) = placed[one], placed[other]
        both = np.intersect1d(rows, own_rows)
        if len(both) < len(own_rows) // 2:
            continue
        moved = own[np.isin(own_rows, both)] - columns[np.isin(rows, both)]
        yield lean(own, own_rows), float(moved.mean()) * fps


def _loop(sequences: Sequence[Images], fps: float, gain: float) -> list[Found]:
    loop = exposure_loop(sequences)
    found = [Found(
        "step of the exposure", f"{loop.step:.4f} of it, up to {loop.steps} a frame",
        ("camera.auto_exposure=true", f"camera.ae_step={loop.step:.4f}", f"camera.ae_steps={loop.steps}"),
    )]  # fmt: skip
    ends = {"lower": loop.low, "upper": loop.high}
    said = "; ".join(f"{name} end {own[0]:.1f} to {own[1]:.1f}" for name, own in ends.items() if own)
    settings: tuple[str, ...] = ()
    if loop.target is not None and loop.zone is not None:
        settings = (f"camera.ae_target={loop.target:.1f}", f"camera.ae_zone={loop.zone:.1f}")
    else:
        said += " (the other end takes sequences that come to rest from the other side)"
    return [*found, Found("control zone (dead band), mean grey", said, settings)]


_MEASURES = {"still": _noise, "flat": _pattern, "edge": _rows, "loop": _loop}
