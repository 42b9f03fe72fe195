"""What a model's tuning curves come to: one row a model."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from experiments.bench.tuning.curves import (
    Preferred,
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
from experiments.bench.tuning.probes import curve_family

OBJECT, GRATING = "dark object", "grating"


@dataclass(frozen=True, slots=True)
class Preferences:
    """Of one model: where it answers most, and how it tells directions; ``None`` for what was not shown or answered.

    ``dsi`` and ``prefers_deg`` are those of HS, or of a looming detector's potential, for gratings; ``error_deg``
    is how far (hs, vs) points off them. ``slope`` is that of `curves.speed_slope`.
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

    def row(self) -> dict[str, Any]:
        """The same for a table: ranges as their ends and whether it is a maximum inside what was shown."""
        made: dict[str, Any] = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.type.startswith("Preferred"):
                made[f"{field.name}_low"] = None if value is None else value.low
                made[f"{field.name}_high"] = None if value is None else value.high
                made[f"{field.name}_inside"] = None if value is None else value.inside
            else:
                made[field.name] = value
        return made


def preferences(given: Sequence[TuningPoint], model: str, channels: Sequence[str]) -> Preferences:
    """What the answers of ``model``, which answers by ``channels``, come to."""
    return Preferences(
        model,
        preferred(*curve(given, model, "speed", OBJECT)),
        preferred(*curve(given, model, "size", OBJECT)),
        half_contrast(*curve(given, model, "contrast", OBJECT)),
        **_of_map(given, model),
        **_of_directions(given, model, directional(channels)),
    )


def _of_map(given: Sequence[TuningPoint], model: str) -> dict[str, Any]:
    """Preferences are those of the best answer along the other axis."""
    x, y, response = grid(given, model, "frequency")
    if not x:
        return {}
    known = np.nan_to_num(response, nan=-math.inf)
    return {
        "wavelength_px": preferred([1 / each for each in x], known.max(axis=0).tolist()),
        "temporal_hz": preferred(y, known.max(axis=1).tolist()),
        "slope": speed_slope(x, best_rows(y, response)),
    }


def _of_directions(given: Sequence[TuningPoint], model: str, tells: bool) -> dict[str, Any]:
    own = lobes(given, model, GRATING)
    # An index over some of the directions alone would be wrong, not rough.
    if len(own["hs"][0]) < sum(probe.line == GRATING for probe in curve_family("direction").probes):
        return {}
    first = selectivity(*own["hs" if tells else "looming"])
    second = selectivity(*own["vs"]) if tells else None
    return {
        "dsi": first.dsi if first else None,
        "prefers_deg": first.preferred_deg if first else None,
        "vs_dsi": second.dsi if second else None,
        "error_deg": pointing_error(given, model, GRATING) if tells else None,
    }
