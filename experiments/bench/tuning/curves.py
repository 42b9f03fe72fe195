"""Tuning curves from answers: pure functions, from rows to responses, preferences and selectivity.

The response to a clip, steady over the second half of the frames in which something moves:

- of a direction model, the mean over that half of (hs, vs) projected on the direction of the motion,
  ``hs cos a + vs sin a``, negative if it answers the other way, in the model's own unit;
- of a looming detector the largest potential while something moves, above its rest of 0.5; of an approach, whichever
  model with a looming potential sees it, that from its begin to the clip's end.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa

from dsnn.looming.grouping import REST
from dsnn.stimuli import ClipParams, Stimulus
from dsnn.stimuli.looming import Looming
from experiments.bench.engine.alarms import first_alarm_s
from experiments.bench.tuning.probes import Family, Probe

NOTHING = 1e-6
"""A response up to here is none: rounding."""
PLATEAU = 0.99
"""Share of the largest response that counts as equally large."""
ROW_FLOOR = 0.1
"""Share of a map's largest response: a column that answers less prefers nothing."""


@dataclass(frozen=True, slots=True)
class TuningPoint:
    """One model's response to one probe. ``hs`` and ``vs`` are steady means, ``looming`` the peak above rest.

    ``spikes`` are those of the looming channel in the clip, ``contact_s`` the time to contact at the first of them in
    an approach, s, ``None`` without one. ``repeat`` is that of the probe.
    """

    curve: str
    line: str
    model: str
    x: float
    y: float | None
    direction_deg: float
    response: float
    hs: float
    vs: float
    looming: float
    spikes: int = 0
    contact_s: float | None = None
    repeat: int = 0


@dataclass(frozen=True, slots=True)
class Preferred:
    """Range where a response is largest: from ``low`` to ``high``, the ends of what is within 1 % of the largest.

    ``from_least`` and ``to_most`` say that it reaches the least or the most that was shown: the true one may lie
    beyond.
    """

    low: float
    high: float
    from_least: bool
    to_most: bool

    @property
    def inside(self) -> bool:
        """Tell whether it is a maximum within what was shown."""
        return not self.from_least and not self.to_most

    def __str__(self) -> str:
        if self.from_least and self.to_most:
            return "flat"
        if not self.inside:
            return f"≥{self.low:.3g}" if self.to_most else f"≤{self.high:.3g}"
        return f"{self.low:.3g}" if self.low == self.high else f"{self.low:.3g}..{self.high:.3g}"


@dataclass(frozen=True, slots=True)
class Selectivity:
    """Preference of a set of responses for one direction: `dsi` of them, and the direction of their sum, degrees."""

    dsi: float
    preferred_deg: float


def moving(clip: Stimulus[ClipParams]) -> npt.NDArray[np.int64]:
    """Return the frames in which something moves, by the clip's truth."""
    return np.array([i for i, frame in enumerate(clip) if frame.truth.motion != "still"], np.int64)


def answer(
    family: Family, probe: Probe, model: str, channels: Sequence[str], series: Mapping[str, Any], frames: Any,
    contact_s: npt.NDArray[np.float64] | None = None,
) -> TuningPoint:  # fmt: skip
    """Return the response of a model that answers by ``channels``; ``series`` are its potentials (T,), ``frames`` move.

    ``contact_s`` is the time to contact by frame (T,) of an approach.
    """
    steady = frames[len(frames) // 2 :]
    hs, vs = (float(series[system][steady].mean()) for system in ("hs", "vs"))
    looming = float(series["looming"][frames].max()) - REST if "looming" in channels else 0.0
    turn = math.radians(probe.direction_deg)
    response = projected(hs, vs, turn) if directional(channels) and family.kind != "approach" else looming
    spikes = np.asarray(series.get("looming_spikes", ()))
    first = first_alarm_s(spikes, contact_s) if contact_s is not None and spikes.size else None
    return TuningPoint(
        family.name, probe.line, model, probe.x, probe.y, probe.direction_deg, response, hs, vs, max(looming, 0.0),
        int(spikes.sum()), first, probe.repeat,
    )  # fmt: skip


def directional(channels: Sequence[str]) -> bool:
    """Tell whether a model that answers by ``channels`` tells directions; otherwise it is a looming detector."""
    return "hs" in channels or "vs" in channels


def projected(hs: float, vs: float, turn: float) -> float:
    """Length of (hs, vs) along the direction ``turn``, radians from rightward to downward."""
    return hs * math.cos(turn) + vs * math.sin(turn)


def answers(
    probes: Iterable[tuple[int, Family, Probe]], channels: Mapping[str, Sequence[str]], frames: pa.Table, seed: int
) -> list[TuningPoint]:
    """Find the responses in ``frames`` (rows of trial, model, hs, vs, looming, by frame), by trial, then model.

    ``probes`` says what the trials showed, ``channels`` by what each model answers. What is not there is left out.
    """
    trial, name = frames["trial"].to_numpy(), np.asarray(frames["model"])
    columns = {system: frames[system].to_numpy() for system in ("hs", "vs", "looming", "looming_spikes")}
    points = []
    for index, family, probe in probes:
        start, end = np.searchsorted(trial, (index, index + 1))  # trials stand in order
        clip = probe.clip.build(seed + probe.repeat)
        contact = clip.contact_s() if isinstance(clip, Looming) else None
        # A potential may lag behind: what looms, recedes or crosses is watched from its begin to the clip's end.
        window = moving(clip)
        window = window if contact is None else np.arange(window[0], len(clip))
        for model in channels:
            frames_of_model = start + np.flatnonzero(name[start:end] == model)
            if len(frames_of_model):
                series = {system: values[frames_of_model] for system, values in columns.items()}
                points.append(answer(family, probe, model, channels[model], series, window, contact))
    return points


def curve(given: Iterable[TuningPoint], model: str, family: str, line: str) -> tuple[list[float], list[float]]:
    """(x, response) of one line, by rising x."""
    wanted = (model, family, line, 0)
    points = sorted((a.x, a.response) for a in given if (a.model, a.curve, a.line, a.repeat) == wanted)
    return [x for x, _ in points], [response for _, response in points]


def grid(
    given: Iterable[TuningPoint], model: str, family: str
) -> tuple[list[float], list[float], npt.NDArray[np.float64]]:
    """(x, y, response) of a map: responses (len(y), len(x)), NaN where there is none."""
    responses = {(a.x, a.y): a.response for a in given if (a.model, a.curve) == (model, family) and a.y is not None}
    xs, ys = sorted({x for x, _ in responses}), sorted({y for _, y in responses if y is not None})
    return xs, ys, np.array([[responses.get((x, y), math.nan) for x in xs] for y in ys])


def preferred(x: Sequence[float], response: Sequence[float]) -> Preferred | None:
    """Return where the response is largest; ``None`` if there is none above zero."""
    largest = max(response, default=0.0)
    if not largest > NOTHING:
        return None
    among = [place for place, value in zip(x, response, strict=True) if value >= PLATEAU * largest]
    low, high = min(among), max(among)
    return Preferred(low, high, low == min(x), high == max(x))


def half_contrast(x: Sequence[float], response: Sequence[float]) -> float | None:
    """Find the contrast of half the largest response, between points on a log axis; ``None`` without it among them."""
    largest = max(response, default=0.0)
    if not largest > NOTHING:
        return None
    above = next(i for i, value in enumerate(response) if value >= largest / 2)
    if above == 0:
        return None
    (x0, x1), (r0, r1) = x[above - 1 : above + 1], response[above - 1 : above + 1]
    share = (largest / 2 - r0) / (r1 - r0)
    return float(math.exp(math.log(x0) + share * math.log(x1 / x0)))


def best_rows(y: Sequence[float], response: npt.NDArray[np.float64]) -> list[float]:
    """Find for each column of a map (len(y), n) the y it prefers, on a log axis the middle of `preferred`.

    NaN where that is no maximum: the column answers too little, or reaches its end, or is level over an octave.
    """
    columns = np.nan_to_num(response, nan=-math.inf).T
    floor = max(ROW_FLOOR * float(columns.max(initial=0.0)), NOTHING)
    rows = [preferred(y, column.tolist()) if column.max() >= floor else None for column in columns]
    return [
        math.nan if best is None or not best.inside or best.high > 2 * best.low else math.sqrt(best.low * best.high)
        for best in rows
    ]


def speed_slope(x: Sequence[float], best: Sequence[float]) -> float | None:
    """Slope of log preferred temporal frequency over log spatial frequency; ``None`` of fewer than three.

    0 where the temporal frequency decides, as in a Reichardt detector; 1 where the speed does, their quotient.
    Source: Priebe, Cassanello and Lisberger 2003, there by the shape of the whole map.
    """
    known = [(math.log(a), math.log(b)) for a, b in zip(x, best, strict=True) if not math.isnan(b)]
    if len(known) < 3:
        return None
    frequencies, peaks = np.array(known).T
    centred = frequencies - frequencies.mean()
    return float(centred @ peaks / (centred @ centred))


def selectivity(direction_deg: Sequence[float], response: Sequence[float]) -> Selectivity | None:
    """Direction-selectivity index, ``|sum r exp(i a)| / sum r``, of responses at evenly spaced directions ``a``.

    r is rectified: a response below zero counts as none, or the sum could vanish. 1 for an answer to one direction
    alone, 0 for the same to all; a half-wave of a cosine has pi / 4. ``None`` without any response. Source: Mazurek,
    Kager and Van Hooser 2014 (1 less their circular variance).
    """
    r = np.maximum(np.asarray(response, float), 0.0)
    if not r.sum() > NOTHING:
        return None
    whole = complex(r @ np.exp(1j * np.radians(direction_deg)) / r.sum())
    return Selectivity(abs(whole), math.degrees(math.atan2(whole.imag, whole.real)) % 360.0)


def lobes(
    given: Iterable[TuningPoint], model: str, line: str, repeat: int = 0
) -> dict[str, tuple[list[float], list[float]]]:
    """Directions, and responses to them, of each system: ``hs``, ``vs``, ``looming``."""
    wanted = (model, "direction", line, repeat)
    points = sorted((a for a in given if (a.model, a.curve, a.line, a.repeat) == wanted), key=lambda a: a.direction_deg)
    turns = [a.direction_deg for a in points]
    return {system: (turns, [getattr(a, system) for a in points]) for system in ("hs", "vs", "looming")}


def pointing_error(given: Iterable[TuningPoint], model: str, line: str) -> float | None:
    """Mean absolute angle between (hs, vs) and the direction of motion, degrees; ``None`` if it never answers."""
    points = [a for a in given if (a.model, a.curve, a.line, a.repeat) == (model, "direction", line, 0)]
    off = [
        abs((math.degrees(math.atan2(a.vs, a.hs)) - a.direction_deg + 180.0) % 360.0 - 180.0)
        for a in points
        if math.hypot(a.hs, a.vs) > NOTHING
    ]
    return float(np.mean(off)) if off else None
