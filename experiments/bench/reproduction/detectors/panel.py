"""The looming detectors that C21 is asked of, each with the presets that were published."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from dsnn import LGMD1Params

EXPERIMENT, CLAIM = "angular-approach", "C21"
ARENAS = MappingProxyType({"bright": (), "dim": ("scene.arena=dim",)})
"""Arena -> the ``--set`` texts that make it."""


@dataclass(frozen=True, slots=True)
class Detector:
    """A detector under one set of published constants.

    Parameters
    ----------
    label
        What ``--model`` takes, and tables show.
    preset
        What its constants are called.
    source
        Where its spike threshold is from.
    """

    label: str
    preset: str
    source: str


PANEL = (
    Detector("lgmd1", "paper", "Yue and Rind 2006"),
    Detector("lgmd1:preset=firmware", "firmware", "T_s of the firmware's SI-LGMD1"),
    Detector("lgmd1:preset=arena", "firmware, arena", "its T_s for the arena"),
    Detector("lgmd2", "paper", "Fu, Hu and Yue 2018"),
    Detector("lgmd2:preset=firmware", "firmware", "the ON/OFF-competing LGMD2 on Colias"),
    Detector("si-lgmd1", "firmware", "the firmware's T_s"),
    Detector("si-lgmd1:preset=arena", "firmware, arena", "its T_s for the arena"),
    Detector("si-lgmd1:beta_3=0", "firmware, no self-inhibition", "the firmware's T_s"),
    Detector("si-lgmd1:preset=paper", "paper", "the firmware's T_s"),
    Detector("si-lgmd2", "firmware", "the firmware's T_spi"),
    Detector("si-lgmd2:preset=paper", "paper", "the firmware's T_spi"),
    Detector("lplc2", "paper", "Hua and others 2022; the scale of its potential is assumed"),
    Detector("mlplc2", "paper", "Liu and Fu 2025"),
    Detector("lplc2-gf", "robot", "Zhao and others 2023, in the angles of the robot's camera"),
    Detector("pon-lgmd", "paper", "assumed: Fu and Li 2022 give none"),
    Detector("hybrid", "robot", "that of its LGMD1, Yue and Rind 2006"),
)
"""All are shown the same trials."""


def spikes_in_a_row(network: Any) -> int:
    """Return how many spikes without a silent frame between them mean a collision to a detector.

    The hybrid has no such parameter: its LGMD1 has the default.
    """
    return int(getattr(network, "n_sp", LGMD1Params().n_sp))
