"""Watch footage from Python: the intervals of motion, and a row per frame and model."""

from __future__ import annotations

import numbers
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import polars as pl
from threadpoolctl import threadpool_limits

from experiments.bench.footage.rows import FrameTable
from experiments.bench.footage.video import SIZES_PX, Footage, Picture, usual_size
from experiments.bench.footage.watch import Seen, Watcher
from experiments.bench.footage.watch import watch as watch_pictures
from experiments.bench.report.terminal import progress
from experiments.bench.run.errors import UsageError, short
from experiments.bench.run.models import model_texts, rate_notes, shown_models
from experiments.bench.run.rows import table
from experiments.bench.run.settings import assignments, watchers

MOTION_SCHEMA = pl.Schema(
    {"model": str, "direction": str, "start_s": float, "end_s": float, "frames": int, "peak": float, "spikes": int}
)


@dataclass(frozen=True)
class Watched:
    """Answers of models to footage: intervals of motion, and a row for each frame.

    Attributes
    ----------
    motions
        A row per interval of motion and model: ``direction`` (rightward, leftward, downward, upward, looming),
        ``start_s`` and ``end_s``, ``frames`` over the threshold, ``peak`` potential, ``spikes``.
    frames
        A row per frame and model: ``time_s``, potentials and spikes.
    size
        Width and height that the models saw, px.
    seconds
        The time of the last frame, s.
    troubles
        Models that went wrong -> what went wrong.
    notes
        What is to be known of the footage: that it ended early, say.
    """

    motions: pl.DataFrame
    frames: pl.DataFrame
    size: tuple[int, int]
    seconds: float
    troubles: Mapping[str, str]
    notes: tuple[str, ...]

    def __repr__(self) -> str:
        amount = f"{self.motions.height} intervals of motion in {self.seconds:.1f} s"
        failed = (f"{label} failed: {trouble}" for label, trouble in self.troubles.items())
        return f"<Watched {'; '.join([f'{amount}, seen at {self.size[0]}x{self.size[1]}', *self.notes, *failed])}>"


def watch(
    source: str | os.PathLike[str],
    *,
    models: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] = (),
    only: bool = False,
    size: tuple[int, int] | None = None,
    fps: float | None = None,
    settings: Mapping[str, Any] | None = None,
    seconds: float | None = None,
    quiet: bool = False,
) -> Watched:
    """Show footage to models, with progress, and find when what moved which way.

    Parameters
    ----------
    source
        A video file, or the index of a camera, as a text: ``"0"``.
    models
        Models to show it to beside ``dsnn``: names, or paths of .py files.
    only
        Whether to show it just to those of ``models``.
    size
        Width and height that the models see, px; otherwise 320 px along the longer side.
    fps
        The models' frame rate; otherwise 30, whatever the footage's own. The default thresholds belong to 30.
    settings
        Parameter -> value, as ``{"dsnn.n_con": 6}``.
    seconds
        How much of the footage to show; otherwise all. A camera needs it.
    quiet
        Whether to show no progress.

    Returns
    -------
    Watched
        The intervals of motion, and a row per frame and model.

    Raises
    ------
    UsageError
        There is nothing to decode, or an argument is not legal. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import watch
    >>> watch("street.mp4", models=["hybrid"]).motions
    """
    labels, texts = shown_models(["dsnn"], model_texts(models), only), assignments(settings)
    if seconds is not None and not (_is_number(seconds) and seconds > 0):
        raise UsageError(f"watch: seconds={short(seconds)}: legal is a number above 0")
    if fps is not None and not _is_number(fps):
        raise UsageError(f"watch: fps={short(fps)}: legal is a number of frames per second")
    chosen, _ = watchers(labels, texts, fps=fps)
    wanted = _checked(size)
    if str(source).isdecimal() and seconds is None:
        raise UsageError(f"watch: camera {source} has no end: say by seconds= how long to watch")
    film = Footage(str(os.fspath(source)))
    try:
        seen_size = wanted or usual_size(film.size)
        watching = [Watcher(model, seen_size[::-1]) for model in chosen]
        kept, seen = FrameTable([model.label for model in chosen]), Seen()
        cv2.setNumThreads(1)  # as in trials: more threads cost a second core for a sixth of the time
        with threadpool_limits(1):
            watch_pictures(_counted(film, seen_size, seconds, quiet), watching, [kept], seen)
        ended = "" if seconds is not None else film.ended_early()
        rates = rate_notes((model, film.rate) for model in chosen if film.rate is not None)
        notes = tuple(filter(None, (*film.notes(), *rates, ended)))
    finally:
        film.close()
    motions = [
        {"model": watcher.chosen.label, **{name: getattr(motion, name) for name in MOTION_SCHEMA.names()[1:]}}
        for watcher in watching for motion in watcher.motions()
    ]  # fmt: skip
    return Watched(
        table(motions, MOTION_SCHEMA), kept.table(),
        seen_size, seen.until_s,
        {watcher.chosen.label: watcher.trouble for watcher in watching if watcher.trouble}, notes,
    )  # fmt: skip


def _checked(size: Any) -> tuple[int, int] | None:
    if size is None:
        return None
    try:
        width, height = size
    except (TypeError, ValueError):
        width = height = None
    if not all(isinstance(side, int | np.integer) and side in SIZES_PX for side in (width, height)):
        bounds = f"from {SIZES_PX[0]} to {SIZES_PX[-1]} px"
        raise UsageError(f"watch: size={short(size)}: legal is (width, height), each {bounds}")
    return int(width), int(height)


def _is_number(value: Any) -> bool:
    return isinstance(value, numbers.Real) and not isinstance(value, bool)


def _counted(film: Footage, size: tuple[int, int], seconds: float | None, quiet: bool) -> Iterator[Picture]:
    """Yield the pictures, up to so many seconds, counted."""
    with progress(film.source, film.announced or 0, quiet or film.announced is None, "frames") as advance:
        for picture in film.pictures(size):
            if seconds is not None and picture.time_s > seconds:
                return
            yield picture
            advance()
