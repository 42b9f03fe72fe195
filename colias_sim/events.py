"""Pixels of an event camera: from samples of the light to events."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import numpy.typing as npt

from colias_sim.config import EventConfig

EVENT = np.dtype([("t", np.float64), ("x", np.uint16), ("y", np.uint16), ("polarity", np.int8)])
"""An event: time (s), column, row, and 1 for ON (brighter) or -1 for OFF (darker)."""
LINEAR = 20.0
"""Grey level below which the logarithm of the light is replaced by a line through 0."""
LONGEST_SAMPLE_S = 0.0019
"""Longest time between two samples of a clip's light, as long as a physics step can be."""
_LEAST_THRES, _ROUNDING = 0.01, 1e-9
_QUIET_AT_WHITE = 0.75
"""Share of the shot noise of darkness that is missing at white."""

Events = npt.NDArray[np.void]
"""Events, (N,) of `EVENT`, in order of time."""
Floats = npt.NDArray[np.float64]
Light = npt.NDArray[np.floating] | npt.NDArray[np.uint8]


def log_light(light: Light) -> Floats:
    """Compute the log light of grey levels: their natural logarithm, and below 20 a line from 0 to ln 20."""
    grey = light.astype(np.float64)
    return np.where(grey > LINEAR, np.log(np.maximum(grey, LINEAR)), grey * (np.log(LINEAR) / LINEAR))


class EventPixels:
    """The pixels of an event camera, which compare samples of the light with what they remember.

    Between two samples the log light is taken to change evenly, so events have times of their own.

    Parameters
    ----------
    shape
        Rows and columns.
    config
        The settings.
    """

    def __init__(self, shape: tuple[int, int], config: EventConfig) -> None:
        self._columns, self._count, self.config = shape[1], shape[0] * shape[1], config

    def restart(self, light: Light, time_s: float, rng: np.random.Generator) -> None:
        """Start again: draw the pixels' thresholds, and remember the present light.

        Parameters
        ----------
        light
            Grey levels, (R, C).
        time_s
            The present time, s.
        rng
            Generator of thresholds and noise, kept until the next restart.
        """
        self._rng, self._time_s, self._log = rng, time_s, log_light(light.ravel())
        nominal = np.array([[self.config.pos_thres], [self.config.neg_thres]])
        self._thres = nominal + self.config.sigma_thres * rng.standard_normal((2, self._count))
        self._thres = np.maximum(self._thres, _LEAST_THRES)
        self._shots = 0.5 * self.config.shot_noise_rate_hz * nominal / self._thres
        self._memory = self._log.copy()
        self._rests_until = np.full(self._count, -np.inf)
        self._taken: list[Events] = []

    def see(self, light: Light, time_s: float) -> None:
        """Take the next sample of the light.

        Parameters
        ----------
        light
            Grey levels, (R, C).
        time_s
            Its time, s, after that of the sample before.
        """
        config, begin, dt = self.config, self._time_s, time_s - self._time_s
        grey = light.ravel()
        bright = (grey + LINEAR) / 275.0
        before, now = self._log - self._memory, log_light(grey)
        if config.cutoff_hz:
            now = self._log + (now - self._log) * -np.expm1(-2.0 * np.pi * config.cutoff_hz * dt * bright)
        self._memory -= config.leak_rate_hz * dt * self._thres[0]
        self._log, self._time_s = now, time_s
        after = now - self._memory
        found = []
        at = self._beyond(after, np.arange(self._count))
        while at.size:
            polarity, way = np.where(after[at] > 0.0, 1, -1), after[at] - before[at]
            step = polarity * self._thres[(1 - polarity) // 2, at]
            share = np.where(polarity * before[at] < np.abs(step), (step - before[at]) / np.where(way, way, 1.0), 0.0)
            times = np.maximum(begin + np.clip(share, 0.0, 1.0) * dt, self._rests_until[at])
            at, polarity, step, times = (each[times <= time_s] for each in (at, polarity, step, times))
            self._memory[at] += step
            before[at] -= step
            after[at] -= step
            self._rests_until[at] = times + config.refractory_period_s
            found.append((times, at, polarity))
            at = self._beyond(after, at)
        if config.shot_noise_rate_hz:
            rates = self._shots * dt * (1.0 - _QUIET_AT_WHITE * bright)
            sign, at = np.nonzero(self._rng.random((2, self._count)) < rates)
            found.append((begin + dt * self._rng.random(at.size), at, 1 - 2 * sign))
        if found:
            when, place, sign = map(np.concatenate, zip(*found, strict=True))
            events = np.empty(len(when), EVENT)
            events["t"], events["y"], events["x"], events["polarity"] = when, *np.divmod(place, self._columns), sign
            self._taken.append(events[np.argsort(when, kind="stable")])

    def sample(self, light: Callable[[float], Light], time_s: float, parts: int) -> None:
        """Take several samples of a light that changes from the last sample on.

        Parameters
        ----------
        light
            Share of the time that has passed, above 0 and up to 1 -> grey levels, (R, C).
        time_s
            The time of the last of them, s.
        parts
            Number of samples.
        """
        begin = self._time_s
        for share in np.arange(1, parts + 1) / parts:
            self.see(light(share), begin + share * (time_s - begin))

    def _beyond(self, change: Floats, at: npt.NDArray[np.intp]) -> npt.NDArray[np.intp]:
        """Return those of the pixels ``at`` whose change has reached a threshold."""
        on, off = self._thres[:, at] - _ROUNDING
        return np.extract((change[at] >= on) | (-change[at] >= off), at)

    def take(self) -> Events:
        """Return the events since the last call.

        Returns
        -------
        ndarray
            (N,) of `EVENT`, in order of time, read-only.
        """
        events, self._taken = joined(self._taken), []
        return events


def joined(parts: Iterable[Events | None]) -> Events:
    """Join events that follow each other, and leave ``None`` out: (N,) of `EVENT`, read-only."""
    events: Events = np.concatenate([np.empty(0, EVENT), *(part for part in parts if part is not None)])
    events.flags.writeable = False
    return events


def replayed(events: Events, from_s: float, to_s: float, *, backwards: bool = False) -> Events:
    """Show events at another time, or backwards.

    Parameters
    ----------
    events
        (N,) of `EVENT`.
    from_s, to_s
        A moment of theirs, s, and when it is then.
    backwards
        Whether time runs backwards from there: what became brighter becomes darker.

    Returns
    -------
    ndarray
        (N,) of `EVENT`, in order of time.
    """
    way = -1 if backwards else 1
    again = events[::way].copy()
    again["t"] = to_s + way * (again["t"] - from_s)
    again["polarity"] *= way
    return again


def save_events(folder: Path, events: Events, shape: tuple[int, int], frame_s: Sequence[float]) -> None:
    """Write events as ``events.npz``, and as ``events.h5`` where h5py is installed.

    Parameters
    ----------
    folder
        Where; it is made.
    events
        (N,) of `EVENT`. Files have an array for each of its fields.
    shape
        Rows and columns.
    frame_s
        Times of the frames, s.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parts = {name: events[name] for name in EVENT.names or ()}
    parts |= {"shape": np.array(shape), "frame_s": np.array(frame_s)}
    np.savez_compressed(folder / "events.npz", allow_pickle=False, **parts)
    if find_spec("h5py"):
        with import_module("h5py").File(folder / "events.h5", "w") as file:
            file.update(parts)


def event_counts(events: Events, shape: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Count the events of each pixel.

    Parameters
    ----------
    events
        (N,) of `EVENT`.
    shape
        Rows and columns.

    Returns
    -------
    ndarray of uint8
        (2, R, C): ON events, then OFF events, at most 255 each.

    Examples
    --------
    >>> import numpy as np
    >>> from colias_sim.events import EVENT, event_counts
    >>> event_counts(np.array([(0.1, 4, 2, -1)], EVENT), (3, 5))[1, 2, 4]
    np.uint8(1)
    """
    place = np.ravel_multi_index(((events["polarity"] < 0).astype(np.intp), events["y"], events["x"]), (2, *shape))
    counts = np.bincount(place, minlength=2 * shape[0] * shape[1]).reshape(2, *shape)
    return np.minimum(counts, 255).astype(np.uint8)
