"""Settings of robot, camera and scene: frozen, validated dataclasses.

Lengths are in centimetres and speeds in cm/s. Names of quantities with a unit end in the unit. A value outside
its range raises ``pydantic.ValidationError``, a ``ValueError`` that names field and bound.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from colias_sim.registers import CONTRAS_CENTER_RESET, GAMMA_RESET, UNIT_CONTRAS
from dsnn.field_docs import parameters, unit
from scenes import ARENA_RADIUS_CM, ARENAS, arena_path
from scenes.hints import nearest

COLIAS4: Mapping[str, Any] = {
    "max_speed_cm_s": 15.3, "power_step_cm_s": 0.06, "dead_band": 20, "trim": 3, "motor_inequality": 3.29,
    "command_slot_ms": 100.0, "serial_ms": 2.1, "open_loop": True,
}  # fmt: skip
"""The Colias's own wheels; see `RobotConfig` for the sources."""

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
    # says whether the loop meters before the curve, which nearly doubles HS, or after it, which hardly changes it: the
    # presets ov7670-gamma and ov7670-gamma-metered.
    "gamma": False,
}
"""A model of the robot's camera: docs/explanation/camera.md lists what it assumes."""

_Register = Annotated[int, Field(ge=0, le=255)]


def _checked_curve(points: tuple[int, ...]) -> tuple[int, ...]:
    if len(points) != len(GAMMA_RESET) or any(after < before for before, after in pairwise(points)):
        raise ValueError(f"gamma_points must be {len(GAMMA_RESET)} values that do not fall, got {points}")
    return points


def known_picture(path: str) -> str:
    """Check the path of a picture, which may be empty, and return it; otherwise raise ``ValueError``."""
    if path and not Path(path).is_file():
        raise ValueError(f"there is no such file: {path}")
    return path


def known_arena(name: str) -> str:
    """Check the name of an arena, or the path of your own file, and return it; a path becomes absolute.

    It raises ``ValueError`` for an unknown arena or a missing file. The file is not read.
    """
    path = arena_path(name)
    return name if name in ARENAS else str(path)


_AsText = BeforeValidator(lambda value: os.fspath(value) if isinstance(value, os.PathLike) else value)
Arena = Annotated[str, _AsText, AfterValidator(known_arena)]
"""The name of a registered arena, or the path of your own file."""
Picture = Annotated[str, _AsText, AfterValidator(known_picture)]
"""The path of a picture; empty: none."""


class _Presets:
    """Base class with named presets: name -> summary, and the fields that differ from the defaults."""

    _named: ClassVar[Mapping[str, tuple[str, Mapping[str, Any]]]]

    @classmethod
    def presets(cls) -> Mapping[str, Self]:
        """Make the presets.

        Returns
        -------
        mapping
            Name -> settings.
        """
        return {name: cls(**settings) for name, (_, settings) in cls._named.items()}

    @classmethod
    def preset_summaries(cls) -> Mapping[str, str]:
        """Describe each of the `presets`.

        Returns
        -------
        mapping of str to str
            Name -> a few words.
        """
        return {name: summary for name, (summary, _) in cls._named.items()}

    @classmethod
    def preset(cls, name: str) -> Self:
        """Look up one of the `presets`; ``--set camera.preset=NAME`` does the same.

        Parameters
        ----------
        name
            Its name.

        Returns
        -------
        settings
            Of this class.

        Raises
        ------
        ValueError
            There is no such preset.
        """
        if name not in cls._named:
            raise ValueError(
                f"no preset '{name}' ({nearest(name, cls._named, after='; ')}all: {', '.join(cls._named)})"
            )
        return cls(**cls._named[name][1])


@parameters
class RobotConfig(_Presets):
    """Settings of the Colias's body and drive. Public sources disagree on the wheels; these fit inside its 4 cm body.

    Preset ``colias4`` has the robot's own wheels, driven open loop in trials: 255 steps of 0.06 cm/s. So a step is 3 %
    of 2 cm/s, and the top speed is 15.3 cm/s. The public firmware drives straight ahead at powers of 77 and 80, and
    slowly at 27 and 30, which is a trim of 3. A trim in whole powers leaves an inequality of up to half a power, 1 /
    sqrt(12) = 0.29 rms, which the preset has. The dead band, below the lowest power of that firmware, is an assumption.
    A command has 6 bytes, or 8 with framing, of 10 bits each at 38,400 baud.

    Examples
    --------
    >>> from colias_sim import RobotConfig
    >>> RobotConfig.preset("colias4").trim
    3
    """

    _named: ClassVar = {
        "default": ("wheels without steps, under feedback of the pose", {}),
        "colias4": ("the robot's own wheels in open loop, as public firmware says; the dead band is assumed", COLIAS4),
    }

    wheel_radius_cm: Annotated[float, unit("cm")] = Field(default=1.0, ge=0.5, le=1.3)
    """Radius of a driven wheel (public: 1.0..1.3)."""
    track_cm: Annotated[float, unit("cm")] = Field(default=3.2, ge=2.0, le=3.6)
    """Distance between the wheels' mid-planes."""
    axle_back_cm: Annotated[float, unit("cm")] = Field(default=0.0, ge=0.0, le=0.5)
    """Distance of the wheels' axle behind the body's centre."""
    mass_g: Annotated[float, unit("g")] = Field(default=28.0, ge=10.0, le=100.0)
    """Mass of the whole robot (public: 28)."""
    motor_gain: Annotated[float, unit("N m s/rad")] = Field(default=2e-4, ge=5e-5, le=5e-4)
    """Gain of a wheel's velocity servo."""
    max_speed_cm_s: Annotated[float, unit("cm/s")] = Field(default=35.0, ge=1.0, le=100.0)
    """Top speed of a wheel's rim (public: 35)."""
    power_step_cm_s: Annotated[float, unit("cm/s")] = Field(default=0.0, ge=0.0, le=1.0)
    """Speed of one step of a wheel's 8-bit power; 0: wheel speeds have no steps."""
    dead_band: Annotated[int, unit("powers")] = Field(default=0, ge=0, le=254)
    """Power of a motor below which its wheel does not turn."""
    trim: Annotated[int, unit("powers")] = Field(default=0, ge=-50, le=50)
    """Power taken off the left wheel to drive straight."""
    motor_inequality: Annotated[float, unit("powers")] = Field(default=0.0, ge=-50.0, le=50.0)
    """Power by which the left motor is faster than the right one."""
    motor_inequality_sd: Annotated[float, unit("powers")] = Field(default=0.0, ge=0.0, le=10.0)
    """Spread of motor_inequality between trials."""
    command_slot_ms: Annotated[float, unit("ms")] = Field(default=0.0, ge=0.0, le=1000.0)
    """Slot of the motor board's queue of commands; 0: commands act at once."""
    serial_ms: Annotated[float, unit("ms")] = Field(default=0.0, ge=0.0, le=100.0)
    """Time of a motor command on the serial line to the motor board."""
    open_loop: bool = False
    """Whether a trial's stimulus drives by time alone, without feedback of its pose."""

    @model_validator(mode="after")
    def _powers_need_steps(self) -> RobotConfig:
        counted = ("dead_band", "trim", "motor_inequality", "motor_inequality_sd")
        set_ones = [name for name in counted if getattr(self, name)]
        if set_ones and not self.power_step_cm_s:
            raise ValueError(f"{', '.join(set_ones)}: counted in powers, so power_step_cm_s must be above 0")
        if self.serial_ms and not self.command_slot_ms:
            raise ValueError("serial_ms: the line to the motor board, so command_slot_ms must be above 0")
        return self

    @property
    def full_turn(self) -> float:
        """Turn rate with the wheels at full speed against each other, in rad/s."""
        return 2 * (self.max_speed_cm_s / 100) / (self.track_cm / 100)


@parameters
class CameraConfig(_Presets):
    """Settings of the camera: the Colias's OV7670 with 99x72 pixels of luma, 70 degrees wide, at 30 frames/s.

    Noise has the variance ``gain^2 read_noise^2 + gain shot_noise^2 L / 255`` at grey level L. The defaults are the
    data sheet's 52 dB of dynamic range (255 / 10^(52/20) = 0.64) and 46 dB of signal to noise at white (1.28).

    By default the camera is ideal apart from noise: a global shutter, a fixed exposure and no lens. Preset ``ov7670``
    models the robot's camera from data sheets and firmware, and two more have its gamma curve on.
    docs/explanation/camera.md lists their assumptions. None was compared with frames of a real robot.

    Light passes the stages in this order: the lens's falloff and blur, exposure and gain, noise, clipping at 0 and 255,
    the gamma curve, contrast, brightness, the range of the luma, and rounding to 8 bits.

    References
    ----------
    OmniVision: data sheets of the OV7670 and the OV7675. Public firmware of the Colias (ColiasSenseV4).

    Examples
    --------
    >>> from colias_sim import CameraConfig
    >>> round(CameraConfig().focal_px, 1), CameraConfig.preset("ov7670").auto_exposure
    (70.7, True)
    """

    _named: ClassVar = {
        "default": ("noise, a fixed exposure, a global shutter and no lens", {}),
        "ideal": (
            "no noise, no exposure time and 16 times the samples",
            {"exposure_ms": 0.0, "supersample": 4, "shot_noise": 0.0, "read_noise": 0.0},
        ),
        "ov7670": (
            "a model of the robot's camera, not validated against a robot (docs/explanation/camera.md)",
            OV7670,
        ),
        "ov7670-gamma": (
            "the same with gamma on, as after a reset, and a loop that meters the light before the curve",
            {**OV7670, "gamma": True, "ae_meter": "light"},
        ),
        "ov7670-gamma-metered": (
            "the same with gamma on, and a loop that meters behind it, as the data sheet of a sibling hints",
            {**OV7670, "gamma": True, "ae_meter": "luma"},
        ),
    }

    width: Annotated[int, unit("px")] = Field(default=99, ge=8, le=1920)
    """Columns of a frame."""
    height: Annotated[int, unit("px")] = Field(default=72, ge=8, le=1080)
    """Rows of a frame."""
    hfov_deg: Annotated[float, unit("degrees")] = Field(default=70.0, ge=10.0, le=150.0)
    """Horizontal field of view."""
    fps: Annotated[float, unit("frames/s")] = Field(default=30.0, ge=5.0, le=120.0)
    """Frame rate of the camera."""
    forward_cm: Annotated[float, unit("cm")] = Field(default=1.95, ge=0.0, le=2.5)
    """Distance of the lens in front of the robot's centre (public: 1.7..2.5)."""
    up_cm: Annotated[float, unit("cm")] = Field(default=2.0, ge=0.5, le=3.0)
    """Height of the lens above the floor (public: 1.2..2.7)."""
    exposure_ms: Annotated[float, unit("ms")] = Field(default=8.0, ge=0.0, le=200.0)
    """Exposure time, at most a frame; 0: an instant; with auto_exposure, where the exposure loop starts."""
    exposure_samples: int = Field(default=1, ge=1, le=64)
    """Renders averaged over the exposure; with auto_exposure the most, one for each two physics steps."""
    multisample: int = Field(default=4, ge=0, le=16)
    """OpenGL samples per rendered pixel."""
    supersample: int = Field(default=1, ge=1, le=32)
    """Rendered pixels per camera pixel and axis."""
    supersample_columns: int = Field(default=1, ge=1, le=32)
    """Rendered pixels per camera pixel along a row, times supersample."""
    shot_noise: Annotated[float, unit("grey levels")] = Field(default=1.28, ge=0.0, le=64.0)
    """Standard deviation of the photon noise at white."""
    read_noise: Annotated[float, unit("grey levels")] = Field(default=0.64, ge=0.0, le=64.0)
    """Standard deviation of the read noise."""
    row_time_us: Annotated[float, unit("us")] = Field(default=0.0, ge=0.0, le=20000.0)
    """Time from the read-out of a row of the picture to that of the next row (OV7670: 418); 0: a global shutter."""
    row_bands: int = Field(default=6, ge=1, le=1080)
    """Bands of rows, each rendered at its own moment, where row_time_us > 0."""
    gain: float = Field(default=1.0, ge=0.1, le=16.0)
    """Fixed gain, on light and noise (OV7670 on Colias: 1.5)."""
    auto_exposure: bool = False
    """Whether the exposure loop controls the exposure time."""
    ae_target: Annotated[float, unit("grey levels")] = Field(default=108.0, ge=1.0, le=254.0)
    """Mean grey in the middle of the exposure loop's control zone (OV7670: 108)."""
    ae_zone: Annotated[float, unit("grey levels")] = Field(default=9.0, gt=0.0, le=127.0)
    """Half width of the exposure loop's control zone (OV7670: 9)."""
    ae_step: float = Field(default=0.0625, gt=0.0, le=0.5)
    """One step of the exposure loop, as a share of the exposure time (OV9650: 1/16)."""
    ae_steps: int = Field(default=10, ge=1, le=100)
    """Most steps of the exposure loop in a frame (OV9650: 10 fast, 1 normal)."""
    ae_min_ms: Annotated[float, unit("ms")] = Field(default=0.0627, gt=0.0, le=200.0)
    """Shortest exposure of the exposure loop: 1 VGA row."""
    ae_max_ms: Annotated[float, unit("ms")] = Field(default=32.0, gt=0.0, le=200.0)
    """Longest exposure of the exposure loop: 510 VGA rows."""
    ae_unit_ms: Annotated[float, unit("ms")] = Field(default=8.0, gt=0.0, le=200.0)
    """Exposure time at which, with gain 1, the exposure loop's picture is as bright as a fixed exposure's (assumed)."""
    ae_meter: Literal["light", "luma"] = "light"
    """Grey whose mean the exposure loop judges: light, behind the lens and before gamma, contrast and brightness, or
    luma, after them (assumed: no source says which)."""
    ae_start: Literal["settled", "cold"] = "settled"
    """Whether the exposure loop has settled on the still scene at a reset, or starts cold."""
    blur_px: Annotated[float, unit("px")] = Field(default=0.0, ge=0.0, le=8.0)
    """Standard deviation of the lens's Gaussian point spread (OV7670 on Colias: 0.31)."""
    vignetting: float = Field(default=0.0, ge=0.0, le=8.0)
    """Exponent n of the lens's falloff, the cosine of the angle to the axis to the power n (natural falloff: 4); the
    sensor's correction of lens shading is off."""
    gamma: bool = False
    """Whether the sensor's gamma curve is on (OV7670 after a reset: on)."""
    gamma_points: Annotated[tuple[_Register, ...], AfterValidator(_checked_curve)] = Field(
        default=GAMMA_RESET, json_schema_extra={"minItems": len(GAMMA_RESET), "maxItems": len(GAMMA_RESET)}
    )
    """GAM1 to GAM15, the outputs of the gamma curve at inputs 4, 8, 16, 32, 40, 48, 56, 64, 72, 80, 96, 112, 144, 176
    and 208; they do not fall."""
    contrast: int = Field(default=UNIT_CONTRAS, ge=0, le=255)
    """CONTRAS, the contrast of luma times 64 (OV7670: 64)."""
    contrast_center: Annotated[int, unit("grey levels")] = Field(default=CONTRAS_CENTER_RESET, ge=0, le=255)
    """CONTRAS_CENTER, the luma that contrast leaves as it is (OV7670: 128)."""
    brightness: Annotated[int, unit("grey levels")] = Field(default=0, ge=-127, le=127)
    """BRIGHT with its sign, an offset of luma after contrast (OV7670: 0)."""
    luma_range: Literal["full", "video"] = "full"
    """Range of the luma: full, 0..255, or video, 16..235."""
    drop_probability: float = Field(default=0.0, ge=0.0, lt=1.0)
    """Probability that a frame is lost and the frame before it is delivered again."""
    jitter_ms: Annotated[float, unit("ms")] = Field(default=0.0, ge=0.0, le=3.0)
    """Standard deviation of the frame clock's jitter, rounded to whole physics steps."""

    @model_validator(mode="after")
    def _check(self) -> CameraConfig:
        if self.row_time_us > 0.0:
            if self.row_bands > self.height:
                raise ValueError(f"row_bands must be at most {self.height}, the picture's rows, got {self.row_bands}")
            if self.row_time_us * self.height * self.fps > 1e6:
                longest = math.floor(1e7 / (self.height * self.fps)) / 10  # rounded down: what is named is possible
                raise ValueError(f"row_time_us must be at most {longest:g} to read all rows, got {self.row_time_us:g}")
        if self.auto_exposure:
            self._check_loop()
        return self

    def _check_loop(self) -> None:
        """Raise ``ValueError`` for an exposure loop that could not settle."""
        low, high = self.ae_target - self.ae_zone, self.ae_target + self.ae_zone
        if low * (1.0 + self.ae_step) > high or high * (1.0 - self.ae_step) < low:
            raise ValueError(f"ae_zone={self.ae_zone:g}: a step of {self.ae_step:g} jumps over {low:g}..{high:g}")
        if not 0.0 < self.ae_min_ms <= self.exposure_ms <= self.ae_max_ms:
            ends = f"between {self.ae_min_ms:g} and {self.ae_max_ms:g}"
            raise ValueError(f"exposure_ms must be {ends} with auto_exposure, got {self.exposure_ms:g}")

    @property
    def focal_px(self) -> float:
        """Focal length in pixels, 70.7 by default: (width / 2) / tan(hfov / 2)."""
        return self.width / 2 / math.tan(math.radians(self.hfov_deg) / 2)

    @classmethod
    def ideal(cls) -> CameraConfig:
        """Make a camera without noise and motion blur and with sixteen samples a pixel, to compare with geometry.

        Returns
        -------
        CameraConfig
            The settings.
        """
        return cls.preset("ideal")


@parameters
class SceneConfig:
    """Settings of the arena, the light and the stimulus's shell, and their variation between trials.

    Examples
    --------
    >>> from colias_sim import SceneConfig, Simulation
    >>> simulation = Simulation(scene=SceneConfig(arena="leaves", light=0.7), seeing=False)
    """

    arena: Arena = "bright"
    """An arena: bright, plain, dim, leaves or drum, or the path of your own .xml or .py file."""
    light: float = Field(default=1.0, ge=0.05, le=2.0)
    """Strength of all lamps, times the arena's own."""
    light_sd: float = Field(default=0.03, ge=0.0, le=0.5)
    """Spread of the lamps' strength between trials."""
    floor: float | None = Field(default=None, ge=0.0, le=1.0)
    """Reflectance of the floor, which is matt then (bright: 0.81; a black screen: about 0.1); None: the arena's own."""
    wall_cm: Annotated[float, unit("cm")] = Field(default=ARENA_RADIUS_CM, ge=30.0, le=100.0)
    """Distance of the wall from the arena's middle; its height and its texture grow with it."""
    turn_wall: bool = True
    """Turn the wall's texture to a random phase in each trial."""
    shell_grey: float = Field(default=0.02, ge=0.0, le=1.0)
    """Reflectance of the stimulus's shell."""
    wall: Picture = ""
    """Path of a picture around the wall, joined to its mirror image; empty: the arena's texture."""
    wall_contrast: float = Field(default=1.0, ge=0.0, le=4.0)
    """Contrast of the wall's texture."""
    shell_shape: Literal["cylinder", "sphere", "card"] = "cylinder"
    """Shape of the stimulus's shell; a card is 1 mm thick and faces ahead."""
    shell_width_cm: Annotated[float, unit("cm")] = Field(default=4.0, ge=0.5, le=20.0)
    """Diameter of the stimulus's shell, or width of a card."""
    shell_height_cm: Annotated[float, unit("cm")] = Field(default=2.9, ge=0.2, le=30.0)
    """Height of the stimulus's shell; a sphere is as high as it is wide."""
    shell_turn_deg: Annotated[float, unit("degrees")] = Field(default=0.0, ge=-180.0, le=180.0)
    """Angle by which the shell is turned from the heading, left positive; 90: a card's face is sideways."""
    shell_picture: Picture = ""
    """Path of a picture on each side of the stimulus's shell; empty: plain shell_grey."""

    @property
    def usual_shell(self) -> bool:
        """Whether the stimulus's shell has the Colias's shape and size, and no picture."""
        usual = ("cylinder", 4.0, 2.9, "")
        return (self.shell_shape, self.shell_width_cm, self.shell_height_cm, self.shell_picture) == usual


NOISY = {"sigma_thres": 0.05, "cutoff_hz": 30.0, "shot_noise_rate_hz": 5.0, "refractory_period_s": 0.01}
"""The event camera of v2e's preset of that name."""


@parameters
class EventConfig(_Presets):
    """Settings of an event camera, with the names, units and defaults of v2e's emulator.

    A pixel compares its log light with the log light that it remembers, which moves by a threshold at each event. Light
    is in grey levels, 0 to 255. Below 20 the logarithm is replaced by a line, as in v2e: a grey there is 0.15.

    References
    ----------
    Hu, Liu and Delbruck 2021, "v2e: from video frames to realistic DVS events", CVPR workshops.

    Examples
    --------
    >>> from colias_sim import EventConfig
    >>> EventConfig.preset("noisy").cutoff_hz
    30.0
    """

    _named: ClassVar = {
        "default": ("thresholds with a spread, and leak", {}),
        "ideal": ("equal thresholds and no noise", {"sigma_thres": 0.0, "leak_rate_hz": 0.0}),
        "noisy": ("v2e's noisy, for dim light", NOISY),
    }

    pos_thres: Annotated[float, unit("ln light")] = Field(default=0.2, ge=0.01, le=5.0)
    """Threshold of ON events."""
    neg_thres: Annotated[float, unit("ln light")] = Field(default=0.2, ge=0.01, le=5.0)
    """Threshold of OFF events."""
    sigma_thres: Annotated[float, unit("ln light")] = Field(default=0.03, ge=0.0, le=1.0)
    """Standard deviation of both thresholds between pixels."""
    cutoff_hz: Annotated[float, unit("Hz")] = Field(default=0.0, ge=0.0, le=10_000.0)
    """Cutoff frequency of a pixel's low-pass at white, lower in proportion to grey + 20; 0: no low-pass."""
    leak_rate_hz: Annotated[float, unit("Hz")] = Field(default=0.1, ge=0.0, le=100.0)
    """ON events of a pixel in a second of constant light, by its leak."""
    shot_noise_rate_hz: Annotated[float, unit("Hz")] = Field(default=0.0, ge=0.0, le=1000.0)
    """Noise events of a pixel in a second of darkness, half of them ON; at white a quarter."""
    refractory_period_s: Annotated[float, unit("s")] = Field(default=0.0, ge=0.0, le=1.0)
    """Time after an event in which the pixel has no other."""
    samples_per_step: int = Field(default=1, ge=1, le=16)
    """Samples of the light in a physics step of 1.85 ms; above 1 with interpolated poses."""
    supersample_columns: int = Field(default=32, ge=1, le=64)
    """Rendered pixels along a row in a pixel of the event camera."""


@parameters
class ProcessorConfig:
    """Settings of the processor that runs a robot's vision model.

    They belong to the model, not to the camera, which exposes and develops every frame. So models on several
    processors see one and the same camera.

    Examples
    --------
    >>> from colias_sim.config import ProcessorConfig
    >>> ProcessorConfig(every=2).takes(1, phase=1), ProcessorConfig(every=2).takes(2, phase=1)
    (True, False)
    """

    every: int = Field(default=1, ge=1, le=6)
    """The model sees every n-th camera frame, as a processor that is too slow skips the others; 1: all frames."""

    def takes(self, frame: int, phase: int = 0) -> bool:
        """Tell whether the model sees a camera frame.

        Parameters
        ----------
        frame
            Its number, from 0 up; lost frames count too.
        phase
            Number of the first frame that the model sees, below ``every``.

        Returns
        -------
        bool
            Whether ``frame % every`` is the phase.
        """
        return frame % self.every == phase


BUILT_IN = (
    "width", "height", "hfov_deg", "fps", "forward_cm", "up_cm", "multisample", "supersample", "supersample_columns",
    "exposure_samples",
)  # fmt: skip
"""Settings that cannot change after a camera was made, because scene and framebuffer depend on them."""


def check_tunable(config: CameraConfig, made_with: CameraConfig) -> None:
    """Check that an existing camera can use other settings of noise, lens, times, luma and the exposure loop.

    Parameters
    ----------
    config
        The new settings.
    made_with
        The settings that the camera was made with.

    Raises
    ------
    ValueError
        The settings need another framebuffer or scene.
    """
    for name in BUILT_IN:
        if getattr(config, name) != getattr(made_with, name):
            raise ValueError(f"{name} must stay {getattr(made_with, name)} in this camera, got {getattr(config, name)}")
    if needs_lamps(config) and not needs_lamps(made_with):
        raise ValueError("auto_exposure and gain must stay off, as the camera was made without them")
    if config.row_time_us > 0.0 and made_with.row_time_us == 0.0:
        raise ValueError(f"row_time_us must be 0, as the camera has a global shutter, got {config.row_time_us:g}")


def needs_lamps(config: CameraConfig) -> bool:
    """Whether gain or exposure loop make the lamps appear stronger or weaker to the camera."""
    return config.auto_exposure or config.gain != 1.0
