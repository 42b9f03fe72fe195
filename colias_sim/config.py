"""The settings of the apparatus: robot, camera and scene. They are frozen and validated.

Lengths are in centimetres and speeds in cm/s. Names of quantities with a unit end in the unit. A value outside
its range raises ``pydantic.ValidationError``, a ``ValueError`` that names field and bound.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, ClassVar

from pydantic import AfterValidator, ConfigDict, Field, model_validator
from pydantic.dataclasses import dataclass

from colias_sim.field_docs import with_field_docs
from scenes import arena_path

_STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)


def known_arena(name: str) -> str:
    """Check the name of an arena; return it, or raise ``ValueError`` naming the nearest one."""
    arena_path(name)
    return name


@with_field_docs
@dataclass(frozen=True, config=_STRICT)
class RobotConfig:
    """The body and the drive of the Colias. Public sources disagree on the wheels; these fit inside its 4 cm body."""

    wheel_radius_cm: float = Field(
        default=1.0, ge=0.5, le=1.3, description="radius of a driven wheel (public: 1.0..1.3)"
    )
    track_cm: float = Field(default=3.2, ge=2.0, le=3.6, description="distance between the wheels' mid-planes")
    axle_back_cm: float = Field(default=0.0, ge=0.0, le=0.5, description="wheel axle behind the body's centre")
    mass_g: float = Field(default=28.0, ge=10.0, le=100.0, description="whole mass (public: 28)")
    motor_gain: float = Field(default=2e-4, ge=5e-5, le=5e-4, description="velocity servo gain of a wheel, N m s/rad")
    max_speed_cm_s: float = Field(default=35.0, ge=1.0, le=100.0, description="top speed of a wheel's rim (public: 35)")
    power_step_cm_s: float = Field(
        default=0.0, ge=0.0, le=1.0, description="speed of one step of a wheel's 8-bit power; 0: speeds have no steps"
    )
    dead_band: int = Field(default=0, ge=0, le=254, description="power below which a wheel does not turn")
    trim: int = Field(default=0, ge=-50, le=50, description="powers taken off the left wheel to drive straight")
    motor_inequality: float = Field(
        default=0.0, ge=-50.0, le=50.0, description="powers by which the left motor is faster than the right one"
    )
    motor_inequality_sd: float = Field(
        default=0.0, ge=0.0, le=10.0, description="spread of that between trials, in powers"
    )
    command_slot_ms: float = Field(
        default=0.0, ge=0.0, le=1000.0, description="slot of the motor board's queue; 0: commands act at once"
    )
    serial_ms: float = Field(
        default=0.0, ge=0.0, le=100.0, description="time of a command on the serial line to the motor board"
    )
    open_loop: bool = Field(
        default=False, description="whether a trial's stimulus drives by time alone, without feedback of its pose"
    )

    PRESETS: ClassVar[Mapping[str, Mapping[str, Any]]] = MappingProxyType(
        {
            "default": MappingProxyType({}),
            "colias4": MappingProxyType(
                {
                    "max_speed_cm_s": 15.3, "power_step_cm_s": 0.06, "dead_band": 20, "trim": 3,
                    "motor_inequality": 3.29, "command_slot_ms": 100.0, "serial_ms": 2.1, "open_loop": True,
                }
            ),
        }
    )  # fmt: skip
    """Name of a preset -> its fields that are not at their defaults.

    ``colias4``: 255 steps of 0.06 cm/s, so a step is 3 % of 2 cm/s and the top speed 15.3 cm/s. The public firmware
    drives straight ahead at powers of 77 and 80, and slowly at 27 and 30: a trim of 3. A trim in whole powers leaves
    an inequality of up to half a power, 1 / sqrt(12) = 0.29 rms, which the preset has. The dead band is an assumption:
    below the lowest power of that firmware. A command is 6 bytes, with 2 of framing 8, of 10 bits at 38,400 baud.
    """

    @model_validator(mode="after")
    def _powers_need_steps(self) -> RobotConfig:
        counted = ("dead_band", "trim", "motor_inequality", "motor_inequality_sd")
        set_ones = [name for name in counted if getattr(self, name)]
        if set_ones and not self.power_step_cm_s:
            raise ValueError(f"{', '.join(set_ones)}: counted in powers, so power_step_cm_s has to be above 0")
        if self.serial_ms and not self.command_slot_ms:
            raise ValueError("serial_ms: the line to the motor board, so command_slot_ms has to be above 0")
        return self

    @classmethod
    def preset(cls, name: str) -> RobotConfig:
        """Make the settings of a preset.

        Parameters
        ----------
        name
            ``default``, or ``colias4``: wheels as the robot has them, driven open loop in trials.

        Raises
        ------
        ValueError
            For an unknown name.
        """
        if name not in cls.PRESETS:
            raise ValueError(f"no preset '{name}' of the robot: there are {', '.join(cls.PRESETS)}")
        return cls(**cls.PRESETS[name])


@with_field_docs
@dataclass(frozen=True, config=_STRICT)
class CameraConfig:
    """The camera: an OV7670 as the Colias uses it, 99x72 pixels of luma, 70 degrees wide, 30 frames per second.

    Noise has the variance ``read_noise^2 + shot_noise^2 L / 255`` at grey level L. The defaults are the data
    sheet's 52 dB of dynamic range (255 / 10^(52/20) = 0.64) and 46 dB of signal to noise at white (1.28).
    """

    width: int = Field(default=99, ge=8, le=1920, description="columns, px")
    height: int = Field(default=72, ge=8, le=1080, description="rows, px")
    hfov_deg: float = Field(default=70.0, ge=10.0, le=150.0, description="horizontal field of view")
    fps: float = Field(default=30.0, ge=5.0, le=120.0, description="frames per second")
    forward_cm: float = Field(
        default=1.95, ge=0.0, le=2.5, description="lens in front of the robot's centre (public: 1.7..2.5)"
    )
    up_cm: float = Field(default=2.0, ge=0.5, le=3.0, description="lens above the floor (public: 1.2..2.7)")
    exposure_ms: float = Field(default=8.0, ge=0.0, le=200.0, description="exposure; 0: an instant; at most a frame")
    exposure_samples: int = Field(default=1, ge=1, le=64, description="renders averaged over the exposure")
    multisample: int = Field(default=4, ge=0, le=16, description="OpenGL samples per rendered pixel")
    supersample: int = Field(default=1, ge=1, le=32, description="rendered pixels per camera pixel and axis")
    shot_noise: float = Field(default=1.28, ge=0.0, le=64.0, description="photon noise at white, sd in grey levels")
    read_noise: float = Field(default=0.64, ge=0.0, le=64.0, description="read noise, sd in grey levels")

    @property
    def focal_px(self) -> float:
        """Focal length in pixels, 70.7 by default: (width / 2) / tan(hfov / 2)."""
        return self.width / 2 / math.tan(math.radians(self.hfov_deg) / 2)

    @classmethod
    def ideal(cls) -> CameraConfig:
        """Settings without noise and motion blur and with sixteen samples a pixel, to compare physics and geometry."""
        return cls(exposure_ms=0.0, exposure_samples=1, supersample=4, shot_noise=0.0, read_noise=0.0)


@with_field_docs
@dataclass(frozen=True, config=_STRICT)
class SceneConfig:
    """Arena, light and the stimulus's shell, and how far the seed of a trial varies them."""

    arena: Annotated[str, AfterValidator(known_arena)] = Field(
        default="bright", description="name of an arena of the scenes folder: bright, plain or dim"
    )
    light: float = Field(default=1.0, ge=0.05, le=2.0, description="strength of all lamps, times the arena's own")
    light_sd: float = Field(default=0.03, ge=0.0, le=0.5, description="spread of that strength between trials")
    turn_wall: bool = Field(default=True, description="turn the wall's texture to a random phase in each trial")
    shell_grey: float = Field(default=0.02, ge=0.0, le=1.0, description="reflectance of the stimulus's shell")
    wall_contrast: float = Field(default=1.0, ge=0.0, le=4.0, description="contrast of the wall's texture")
