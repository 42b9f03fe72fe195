"""Camera metrology: what frames tell of the camera that took them, the simulated eye or a real one.

Each function takes frames, (T, R, C) or (R, C), as any camera gives them, and needs no simulator. The numbers it finds
are those of `colias_sim.config.CameraConfig`. The tests hold the simulated eye to its own settings by them.

References
----------
EMVA 1288, Release 4.0: photon transfer, and the correction of spatial variance for temporal noise. ISO 12233: the
slanted edge.
"""

from __future__ import annotations

from colias_sim.metrology.edges import edge_columns, edge_rows, lean, row_time_us, transfer
from colias_sim.metrology.errors import MetrologyError
from colias_sim.metrology.loop import ExposureLoop, exposure_loop
from colias_sim.metrology.noise import (
    NoiseLevels,
    PhotonTransfer,
    fixed_pattern,
    noise_levels,
    photon_transfer,
    unsteadiness,
)
from colias_sim.metrology.tone import LumaLine, falloff_exponent, gamma_points, grey_steps, luma_line

__all__ = [
    "ExposureLoop",
    "LumaLine",
    "MetrologyError",
    "NoiseLevels",
    "PhotonTransfer",
    "edge_columns",
    "edge_rows",
    "exposure_loop",
    "falloff_exponent",
    "fixed_pattern",
    "gamma_points",
    "grey_steps",
    "lean",
    "luma_line",
    "noise_levels",
    "photon_transfer",
    "row_time_us",
    "transfer",
    "unsteadiness",
]
