"""Preferences in a model's tuning curves: one row a model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from experiments.bench.tuning.curves import (
    PLATEAU,
    Preferred,
    Selectivity,
    TuningPoint,
    best_rows,
    curve,
    directional,
    grid,
    half_contrast,
    lobes,
    pointing_error,
    preferred,
    selectivity,
    speed_slope,
)
from experiments.bench.tuning.defined import SOME, undefined_direction, undefined_peak
from experiments.bench.tuning.probes import CROSSES, LOOMS, PHASES, RECEDES, STIMULUS, curve_family

OBJECT, GRATING, LOOMING = "dark object", "grating", "dark looming"


@dataclass(frozen=True, slots=True)
class Preferences:
    """Preferences of one model: where it answers most, and how it tells directions; ``None`` for what was not shown or
    answered.

    ``dsi`` and ``prefers_deg`` are those of HS, or of a looming detector's potential, for gratings; ``error_deg``
    is how far (hs, vs) points off them. ``slope`` is that of `curves.speed_slope`. ``fires_deg`` is the full angle at
    which dark looming makes it spike first, the median over l/v. ``looming_by_potential`` and
    ``looming_by_spikes`` are the shares of l/v at which a dark disc that looms gets a higher peak, or more spikes, than
    the same that recedes and the same that crosses. ``stimulus`` is along the parameter of ``--stimulus``'s clips.
    ``undefined`` says of measures why they are within
    the noise (`experiments.bench.tuning.defined`); they are ``None`` too.
    """

    model: str
    speed_px_s: Preferred | None = None
    size_px: Preferred | None = None
    half_contrast: float | None = None
    wavelength_px: Preferred | None = None
    temporal_hz: Preferred | None = None
    slope: float | None = None
    dsi: float | None = None
    prefers_deg: float | None = None
    vs_dsi: float | None = None
    error_deg: float | None = None
    fires_deg: float | None = None
    looming_by_potential: float | None = None
    looming_by_spikes: float | None = None
    stimulus: Preferred | None = None
    undefined: Mapping[str, str] = field(default_factory=dict)

    def row(self) -> dict[str, Any]:
        """Make a row for a table: ranges as their ends and whether it is a maximum inside what was shown."""
        row: dict[str, Any] = {}
        for entry in dataclasses.fields(self):
            value = getattr(self, entry.name)
            if entry.name == "undefined":
                row["not_defined"] = "; ".join(f"{name}: {why}" for name, why in value.items())
            elif entry.type.startswith("Preferred"):
                row[f"{entry.name}_low"] = None if value is None else value.low
                row[f"{entry.name}_high"] = None if value is None else value.high
                row[f"{entry.name}_inside"] = None if value is None else value.inside
            else:
                row[entry.name] = value
        return row


def preferences(given: Sequence[TuningPoint], model: str, channels: Sequence[str]) -> Preferences:
    """Return the preferences of ``model``, which answers by ``channels``."""
    speed, size = (curve(given, model, family, OBJECT) for family in ("speed", "size"))
    values: dict[str, Any] = {
        "speed_px_s": preferred(*speed),
        "size_px": preferred(*size),
        "half_contrast": half_contrast(*curve(given, model, "contrast", OBJECT)),
        "fires_deg": firing_angle(given, model),
        "looming_by_potential": prefers_looming(given, model, lambda a: a.response),
        "looming_by_spikes": prefers_looming(given, model, lambda a: float(a.spikes)),
        **_of_map(given, model),
        **_of_directions(given, model, directional(channels)),
    }
    shapes: dict[str, Any] = {"speed_px_s": speed[1], "size_px": size[1]}
    response = grid(given, model, "frequency")[2]
    for line in {a.line for a in given if a.curve == STIMULUS}:
        x, shapes["stimulus"] = curve(given, model, STIMULUS, line)
        values["stimulus"] = preferred(x, shapes["stimulus"])
    shapes |= {"wavelength_px": response, "temporal_hz": response}
    undefined = {
        name: why
        for name, shape in shapes.items()
        if values.get(name) is not None and str(values[name]) != "flat" and (why := undefined_peak(shape))
    }
    if "temporal_hz" in undefined:
        values["slope"] = None
    if why := direction_undefined(given, model, channels):
        undefined |= dict.fromkeys([name for name in ("dsi", "prefers_deg") if values.get(name) is not None], why)
    values |= dict.fromkeys(undefined)
    return Preferences(model, **values, undefined=undefined)


def firing_angle(given: Sequence[TuningPoint], model: str) -> float | None:
    """Find the full angle that a dark square subtends at the first spike, degrees: the median over l/v; or ``None``."""
    angles = [
        2 * math.degrees(math.atan(a.x / a.contact_s))
        for a in given
        if (a.model, a.curve, a.line) == (model, "l-over-v", LOOMING) and a.contact_s is not None
    ]
    return float(np.median(angles)) if angles else None


def prefers_looming(given: Sequence[TuningPoint], model: str, value: Callable[[TuningPoint], float]) -> float | None:
    """Find the share of l/v at which looming of a disc has more of a ``value`` than receding and crossing.

    More by 1 % of the largest: two potentials at their ceiling are equal. ``None`` where the disc was not shown.
    """
    values = {(a.line, a.x): value(a) for a in given if (a.model, a.curve) == (model, "disc")}
    places = sorted({x for line, x in values if line == LOOMS})
    if not places:
        return None
    others = [max(values[RECEDES, x], values[CROSSES, x]) for x in places]
    return sum(PLATEAU * values[LOOMS, x] > other for x, other in zip(places, others, strict=True)) / len(places)


def direction_undefined(given: Sequence[TuningPoint], model: str, channels: Sequence[str]) -> str:
    """Tell why the preferred direction of HS, or of looming, varies too much with the grating's phase; empty otherwise.

    Of a model that answers all directions alike, by a DSI below `SOME`, nothing is to be told.
    """
    directions = [_first(given, model, directional(channels), repeat) for repeat in range(PHASES)]
    known = [direction for direction in directions if direction is not None]
    if len(known) < 2 or max(direction.dsi for direction in known) < SOME:
        return ""
    turns = lobes(given, model, GRATING)["hs"][0]
    return undefined_direction([direction.preferred_deg for direction in known], 360.0 / len(turns))


def _first(given: Sequence[TuningPoint], model: str, tells: bool, repeat: int) -> Selectivity | None:
    """Return the selectivity of HS, or of looming, at one phase; ``None`` where a direction is missing."""
    responses = lobes(given, model, GRATING, repeat)["hs" if tells else "looming"]
    return selectivity(*responses) if len(responses[0]) == _directions() else None


def _directions() -> int:
    return sum(probe.line == GRATING and probe.repeat == 0 for probe in curve_family("direction").probes)


def _of_map(given: Sequence[TuningPoint], model: str) -> dict[str, Any]:
    """Preferences are those of the best answer along the other axis."""
    x, y, response = grid(given, model, "frequency")
    if not x:
        return {}
    known = np.nan_to_num(response, nan=-math.inf)
    return {
        "wavelength_px": preferred([1 / column for column in x], known.max(axis=0).tolist()),
        "temporal_hz": preferred(y, known.max(axis=1).tolist()),
        "slope": speed_slope(x, best_rows(y, response)),
    }


def _of_directions(given: Sequence[TuningPoint], model: str, tells: bool) -> dict[str, Any]:
    responses = lobes(given, model, GRATING)
    # An index over some of the directions alone would be wrong, not rough.
    if len(responses["hs"][0]) < _directions():
        return {}
    first = selectivity(*responses["hs" if tells else "looming"])
    second = selectivity(*responses["vs"]) if tells else None
    return {
        "dsi": first.dsi if first else None,
        "prefers_deg": first.preferred_deg if first else None,
        "vs_dsi": second.dsi if second else None,
        "error_deg": pointing_error(given, model, GRATING) if tells else None,
    }
