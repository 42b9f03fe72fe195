"""Presets of robot and camera, and the sources of their numbers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

Settings = TypeVar("Settings")

COLIAS4: Mapping[str, Any] = {
    "max_speed_cm_s": 15.3, "power_step_cm_s": 0.06, "dead_band": 20, "trim": 3, "motor_inequality": 3.29,
    "command_slot_ms": 100.0, "serial_ms": 2.1, "open_loop": True,
}  # fmt: skip
"""The robot's own wheels: `colias_sim.RobotConfig.presets` tells the sources."""

OV7670: Mapping[str, Any] = {
    # 480 rows of 2 x 784 pixel clocks at 25 MHz, 62.7 us each, over the 72 rows of the picture (data sheet, derived).
    "row_time_us": 418.0,
    "row_bands": 6,
    # Colias's firmware: register GAIN 0x08, which is 1 + 8/16.
    "gain": 1.5,
    "exposure_samples": 8,
    "auto_exposure": True,
    # Data sheet: the stable region is AEB..AEW, 0x63..0x75 after a reset; Colias's firmware leaves both.
    "ae_target": 108.0,
    "ae_zone": 9.0,
    # Published for the sibling OV9650: steps of 1/16, about ten a frame in fast mode (COM8 of the firmware: fast).
    "ae_step": 0.0625,
    "ae_steps": 10,
    # 1 and 510 rows of 62.7 us (data sheet).
    "ae_min_ms": 0.0627,
    "ae_max_ms": 32.0,
    # A plastic lens blurs by about a pixel at QVGA; read as the sd, it is 99 / 320 px here (an assumption).
    "blur_px": 0.31,
    # Data sheet: COM15 is 0xC0 after a reset, the range 0x00..0xFF; Colias's firmware leaves it.
    "luma_range": "full",
    # Data sheet: COM13 is 0x88 after a reset, gamma on, and Colias's firmware leaves it. It is off here, as no source
    # says whether the loop meters before the curve, which nearly doubles HS, or after it, which hardly changes it.
    "gamma": False,
}
"""A model of the robot's camera: docs/eye.md lists what it assumes."""

CAMERAS: Mapping[str, str] = {
    "default": "noise, a fixed exposure, a global shutter and no lens",
    "ideal": "no noise, no exposure time and 16 times the samples",
    "ov7670": "a model of the robot's camera with assumptions, not validated against a robot (docs/eye.md)",
}
"""Preset of the camera -> what it is."""

ROBOTS: Mapping[str, str] = {
    "default": "wheels without steps, under feedback of the pose",
    "colias4": "the robot's own wheels in open loop, as public firmware says; the dead band is assumed",
}
"""Preset of the robot -> what it is."""


def find(presets: Mapping[str, Settings], section: str, name: str) -> Settings:
    """Return the preset called ``name``; ``ValueError`` with the known names otherwise."""
    if not isinstance(name, str) or name not in presets:
        raise ValueError(f"no {section} preset {name!r}: there are {', '.join(presets)}")
    return presets[name]
