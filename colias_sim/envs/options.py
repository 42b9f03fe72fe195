"""The keyword arguments of the envs: frozen dataclasses that pydantic checks."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from functools import partial
from typing import Annotated, Any, Literal, Self, TypeVar, cast

from pydantic import (
    BeforeValidator,
    ConfigDict,
    Field,
    PlainValidator,
    ValidationError,
    model_validator,
)
from pydantic.dataclasses import dataclass

from colias_sim.config import Arena as Arena, CameraConfig, EventConfig, ProcessorConfig, RobotConfig
from colias_sim.envs.randomise import PRESET, Range, camera_ends, checked_randomise
from dsnn.field_docs import unit, with_field_docs
from scenes.hints import nearest

MOST_ROBOTS = 20
STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True, arbitrary_types_allowed=True)
"""The pydantic configuration of every options class. These classes are keyword-only dataclasses too."""
FPS = 30.0
"""Frame rate of an env's camera. Actions, step limits and the models' times are counted in its frames."""

Options = TypeVar("Options", bound="EnvOptions")
T = TypeVar("T")


def checked(kind: Callable[..., T], values: Mapping[str, Any]) -> T:
    """Make an instance of a pydantic dataclass from keyword arguments.

    Parameters
    ----------
    kind
        The class.
    values
        The keyword arguments.

    Returns
    -------
    object
        ``kind(**values)``.

    Raises
    ------
    ValueError
        A value is out of range, or a name is unknown. The message is one line with each name and its bound, or the most
        similar known name.
    """
    try:
        return kind(**values)
    except ValidationError as error:
        known = [field.name for field in dataclasses.fields(cast(Any, kind))]
        raise ValueError("; ".join(_problem(problem, known) for problem in error.errors())) from None


def _problem(problem: Mapping[str, Any], known: list[str]) -> str:
    name, text = ".".join(map(str, problem["loc"])), str(problem["msg"])
    if problem["type"] == "unexpected_keyword_argument":
        return f"no keyword argument '{name}' ({nearest(name, known, after='; ')}all: {', '.join(known)})"
    if problem["type"] == "value_error":
        text = text.removeprefix("Value error, ")
        return f"{name}={problem['input']!r}: {text}" if name else text
    return f"{name} must be {text.removeprefix('Input should be ')}, got {problem['input']!r}"


def _configured(kind: type[CameraConfig] | type[RobotConfig] | type[EventConfig], value: Any) -> Any:
    """Convert a preset's name, or settings by name, to a configuration."""
    if isinstance(value, str):
        return kind.preset(value)
    if isinstance(value, Mapping):
        settings = dict(value)
        base: Any = kind.preset(settings.pop(PRESET, "default"))
        return checked(kind, {field.name: getattr(base, field.name) for field in dataclasses.fields(kind)} | settings)
    return value


CameraSettings = Annotated[CameraConfig, BeforeValidator(partial(_configured, CameraConfig))]
"""A camera: a preset's name, settings by name (with ``preset``, changes to it), or a configuration."""
RobotSettings = Annotated[RobotConfig, BeforeValidator(partial(_configured, RobotConfig))]
"""A robot, likewise."""
EventSettings = Annotated[EventConfig, BeforeValidator(partial(_configured, EventConfig))]
"""An event camera, likewise."""
Randomise = Annotated[float | Mapping[str, Range], PlainValidator(checked_randomise)]
"""A strength, a preset's name, or factors with their ranges (with ``preset``, additions to it)."""


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class EnvOptions:
    """Keyword arguments of every env."""

    observation: Literal["pixels", "neural", "both", "state", "events"] = "pixels"
    """What the agent observes."""
    actions: Literal["wheels", "manoeuvres"] = "wheels"
    """Two wheel speeds, or one of seven manoeuvres."""
    frame_skip: int | None = Field(default=None, ge=1, le=30)
    """Camera frames, of 1/30 s, that an action lasts: a multiple of processor.every, and by default just that."""
    processor: ProcessorConfig = ProcessorConfig()
    """The processor of the vision model, as {"every": 2}: of each two frames after a reset it takes the second."""
    robots: int = Field(default=1, ge=0, le=MOST_ROBOTS)
    """Other robots in the arena."""
    arena: Arena = "bright"
    """An arena of scenes, or your own file."""
    camera: CameraSettings = Field(default=cast(Any, "default"), validate_default=True)
    """The observer's camera: a preset, settings by name (with preset, changes to it), or a CameraConfig."""
    robot: RobotSettings = Field(default=cast(Any, "default"), validate_default=True)
    """Body and wheels of all robots: a preset, settings by name, or a RobotConfig."""
    events: EventSettings = EventConfig()
    """The observer's event camera: a preset, settings by name, or an EventConfig. It works for the observation events,
    and for a model that senses events."""
    noise: float = Field(default=1.0, ge=0.0, le=10.0)
    """Camera noise, times the camera's own."""
    randomise: Randomise = 0.0
    """Domain randomisation: a strength from 0 (none) to 1, a preset, or ranges of factors (with preset, additions to
    it)."""
    truth: bool = False
    """Whether info has what truly moved in the camera's frame, which a policy can learn from and cannot see."""
    model: Any = "hybrid"
    """Vision model of neural observations: a name, a .py file, an entry, or a factory called with (rows, columns)."""
    render_mode: Literal["rgb_array", "human"] | None = None
    """Output of render(): a picture, or a window."""
    render_view: Literal["arena", "top", "observer"] = "arena"
    """Viewpoint of render()."""
    render_width: Annotated[int, unit("px")] = Field(default=480, ge=16, le=1920)
    """Width of render()'s picture."""
    render_height: Annotated[int, unit("px")] = Field(default=360, ge=16, le=1080)
    """Height of render()'s picture."""

    @model_validator(mode="after")
    def _apparatus_is_possible(self) -> Self:
        if self.camera.fps != FPS:
            raise ValueError(f"camera: fps must be {FPS:g} in an env, got {self.camera.fps:g}")
        if self.truth and self.observation == "state":
            raise ValueError(
                "truth is that of a camera's frame, so observation must be pixels, neural, both or events, got state"
            )
        camera_ends(self.noisy_camera(), self.robot, self.randomise)
        if self.frames_per_step % self.processor.every:
            raise ValueError(
                f"frame_skip must be a multiple of processor.every={self.processor.every}, got {self.frame_skip}"
            )
        return self

    @property
    def frames_per_step(self) -> int:
        """Number of camera frames that an action lasts."""
        return self.frame_skip or self.processor.every

    def noisy_camera(self) -> CameraConfig:
        """Make the camera's settings in an episode without randomisation.

        Returns
        -------
        CameraConfig
            ``camera``, with its noise times ``noise``.

        Raises
        ------
        ValueError
            The camera's noise would exceed its range.
        """
        return dataclasses.replace(
            self.camera, shot_noise=self.noise * self.camera.shot_noise, read_noise=self.noise * self.camera.read_noise
        )
