"""A trial as a data set: its frames, what each pixel truly shows, where the robots are and what models responded."""

import dataclasses
from pathlib import Path

import numpy as np
import numpy.typing as npt

from colias_sim.events import joined, save_events
from experiments.base.errors import UsageError, check_known
from experiments.base.files import Files
from experiments.base.templates import render
from experiments.kinds.result import plan_of
from experiments.settings.settings import events_of
from experiments.show.play import Trial, show, tabulate
from experiments.store.asked import Asked
from experiments.store.recordings import write_pictures

KITTI_UNITS, KITTI_ZERO = 64.0, 2**15
"""Units of a pixel in KITTI's pictures of flow, and the value of no motion."""


def kitti(flow: npt.NDArray[np.float32]) -> npt.NDArray[np.uint16]:
    """Encode flow as KITTI does: 16 bits of 1/64 px, 32768 for none, and whether it is known.

    Parameters
    ----------
    flow
        (..., 2): px, right and down positive, NaN where it is not known.

    Returns
    -------
    ndarray of uint16
        (..., 3): known (1 or 0), down, right: blue, green and red of a PNG file. All are 0 where nothing is known.
    """
    known = np.isfinite(flow).all(axis=-1, keepdims=True)
    units = np.clip(np.rint(np.nan_to_num(flow) * KITTI_UNITS) + KITTI_ZERO, 0, 2**16 - 1)
    coded: npt.NDArray[np.uint16] = np.where(known, np.concatenate([known, units[..., ::-1]], axis=-1), 0)
    return coded.astype(np.uint16)


def write(asked: Asked, trial: int | None, out: Path) -> None:
    """Play a trial of a run once more, and write it with its truth.

    Parameters
    ----------
    asked
        What the run was asked for. Equal trials have equal frames, so the run need not have stored its truth.
    trial
        Number of the trial; ``None``: the first.
    out
        A new folder.

    Raises
    ------
    UsageError
        It is no run of trials with the robot, or has no such trial.
    """
    if asked.kind != "trials":
        raise UsageError(f"--truth: RUN must be a run of trials with the robot, got one of the kind {asked.kind}")
    chosen = dataclasses.replace(_trial(asked, trial), truth=True, controls=None)
    showings = show(chosen)
    for showing in showings:
        place = out / f"camera{showing.eye and f'_{showing.eye}'}"
        truths = [sample.pixels for sample in showing.samples if sample.pixels is not None]
        write_pictures(place, np.stack([sample.image for sample in showing.samples]), ".png")
        write_pictures(place / "flow", kitti(np.stack([truth.flow for truth in truths])), ".png")
        pixels = ("flow", "depth_m", "depth_before_m", "geom", "robot", "interval_ms", "translation_m")
        np.savez_compressed(
            place / "truth.npz", allow_pickle=False, time_s=np.array([sample.time_s for sample in showing.samples]),
            focal_px=truths[0].focal_px, geoms=np.array(truths[0].geoms), robots=np.array(truths[0].robots),
            **{name: np.stack([getattr(truth, name) for truth in truths]) for name in pixels},
        )  # fmt: skip
    files = Files(out)
    files.write_text("frames.csv", tabulate(chosen, showings, 0.0).frames.write_csv())
    files.write_text("README.md", render("kinds/data_set.md.j2", trial=chosen, truth=truths[0]) + "\n")


def _trial(asked: Asked, number: int | None) -> Trial:
    """Return a trial of a run, planned anew: the first for ``None``."""
    trials: dict[str, Trial] = {str(one.index): one for one in plan_of(asked).trials}
    wanted = next(iter(trials)) if number is None else str(number)
    check_known("--trial", wanted, list(trials))
    return trials[wanted]


def write_events(asked: Asked, trial: int | None, out: Path) -> None:
    """Play a trial of a run once more before an event camera, and write its events.

    Parameters
    ----------
    asked
        What the run was asked for. The event camera is that of its models, or of the settings ``events``.
    trial
        Number of the trial; ``None``: the first.
    out
        A new folder. It gets ``events.npz`` of each camera, and ``events.h5`` where h5py is installed.

    Raises
    ------
    UsageError
        It is no run of trials with the robot or of clips, or has no such trial.
    """
    if asked.kind not in ("trials", "clips"):
        raise UsageError(f"--events: RUN must be a run of trials or clips, got one of the kind {asked.kind}")
    chosen = _trial(asked, trial)
    for showing in show(dataclasses.replace(chosen, events=chosen.events or events_of(asked.values), controls=None)):
        events, times = joined(sample.events for sample in showing.samples), [one.time_s for one in showing.samples]
        save_events(out / f"camera{showing.eye and f'_{showing.eye}'}", events, showing.source.shape, times)
