"""The keyword arguments of the envs: declared once, as frozen dataclasses, and checked."""

from __future__ import annotations

import dataclasses
import functools
import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Concatenate, Literal, ParamSpec, Self, TypeVar, cast

from pydantic import AfterValidator, ConfigDict, Field, PlainValidator, ValidationError, model_validator
from pydantic.dataclasses import dataclass
from pydantic.fields import FieldInfo

from colias_sim.config import CameraConfig, RobotConfig, known_arena
from colias_sim.envs.episode_settings import EpisodeSettings
from colias_sim.envs.factors import PRESET, Range, checked_randomise, ends_of, ranges_of, reason
from colias_sim.envs.flags import is_flag
from dsnn.field_docs import unit, with_field_docs
from scenes.hints import nearest

MOST_ROBOTS = 20
STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True, arbitrary_types_allowed=True)
"""The pydantic configuration of every options class; these are keyword-only dataclasses too."""
Arena = Annotated[str, AfterValidator(known_arena)]
"""The name of a registered arena, or the path of a file of one's own."""
Observation = Literal["pixels", "neural", "both", "state"]
Actions = Literal["wheels", "manoeuvres"]
RenderMode = Literal["rgb_array", "human"]
View = Literal["arena", "top", "observer"]

Env = TypeVar("Env")
Options = TypeVar("Options", bound="EnvOptions")
Arguments = ParamSpec("Arguments")
T = TypeVar("T")
FPS = 30.0
"""Frames per second of an env's camera: actions, limits of steps and the models' times are counted in its frames."""


def _apparatus(kind: type[T]) -> Callable[[Any], T]:
    """Make a check that turns a preset's name, or a mapping of settings, into an instance of ``kind``."""

    def convert(value: Any) -> T:
        if isinstance(value, kind):
            return value
        if isinstance(value, Mapping):
            base = _preset(kind, value.get(PRESET, "default"))
            fields = {field.name: getattr(base, field.name) for field in dataclasses.fields(cast(Any, base))}
            return checked(kind, fields | {name: given for name, given in value.items() if name != PRESET})
        return cast(T, _preset(kind, value))

    return convert


def _preset(kind: Any, name: Any) -> Any:
    known = kind.presets()
    if not isinstance(name, str):
        raise ValueError(f"expected a preset ({', '.join(known)}), {{setting: value}}, or a {kind.__name__}")
    if name not in known:
        raise ValueError(f"no preset '{name}' ({nearest(name, known, after='; ')}all: {', '.join(known)})")
    return known[name]


Camera = Annotated[str | Mapping[str, Any] | CameraConfig, PlainValidator(_apparatus(CameraConfig))]
"""A camera: a preset's name, settings by name (with ``preset``, changes to that), or a configuration."""
Wheels = Annotated[str | Mapping[str, Any] | RobotConfig, PlainValidator(_apparatus(RobotConfig))]
"""A robot, likewise."""
Randomise = Annotated[float | str | Mapping[str, Range | str], PlainValidator(checked_randomise)]
"""A strength, a preset's name, or factors with their ranges (with ``preset``, beside those of that)."""


@with_field_docs
@dataclass(frozen=True, kw_only=True, config=STRICT)
class EnvOptions:
    """The keyword arguments that every env takes."""

    observation: Observation = "pixels"
    """What the agent observes."""
    actions: Actions = "wheels"
    """Two wheel speeds, or one of seven manoeuvres."""
    frame_skip: int = Field(default=1, ge=1, le=30)
    """Camera frames, of 1/30 s, that an action lasts."""
    robots: int = Field(default=1, ge=0, le=MOST_ROBOTS)
    """Other robots in the arena."""
    arena: Arena = "bright"
    """An arena of scenes, or a file of one's own."""
    camera: Camera = Field(default="default", validate_default=True)
    """The observer's eye: a preset, or settings by name."""
    robot: Wheels = Field(default="default", validate_default=True)
    """Body and wheels of all robots: a preset, or settings by name."""
    noise: float = Field(default=1.0, ge=0.0, le=10.0)
    """Camera noise, times the camera's own."""
    randomise: Randomise = 0.0
    """Domain randomisation: 0 none .. 1, a preset, or a range for each factor."""
    model: Any = "hybrid"
    """Vision model of neural observations: a name, a .py file, an entry, or a factory."""
    render_mode: RenderMode | None = None
    """How render() shows the scene."""
    render_view: View = "arena"
    """Where render() looks from."""
    render_width: Annotated[int, unit("px")] = Field(default=480, ge=16, le=1920)
    """Width of render()'s picture."""
    render_height: Annotated[int, unit("px")] = Field(default=360, ge=16, le=1080)
    """Height of render()'s picture."""

    @model_validator(mode="after")
    def _apparatus_can_be_had(self) -> Self:
        try:
            plain = self.plain_settings()
        except ValueError as error:
            raise ValueError(f"noise={self.noise:g}, times that of the camera: {reason(error)}") from None
        if plain.camera.fps != FPS:
            raise ValueError(f"camera: fps={plain.camera.fps:g}: an env has {FPS:g} frames a second")
        ends_of(plain, ranges_of(cast(Any, self.randomise)))
        return self

    def plain_settings(self) -> EpisodeSettings:
        """Make the settings of an episode without randomisation.

        Returns
        -------
        EpisodeSettings
            Camera, with its noise times ``noise``, and robot.

        Raises
        ------
        pydantic.ValidationError
            The camera cannot have that much noise.
        """
        camera, robot = cast(CameraConfig, self.camera), cast(RobotConfig, self.robot)
        noisy = dataclasses.replace(
            camera, shot_noise=self.noise * camera.shot_noise, read_noise=self.noise * camera.read_noise
        )
        return EpisodeSettings(noisy, robot)


def keyword_arguments(
    options: Callable[Arguments, Options],
) -> Callable[[Callable[[Env, Options], None]], Callable[Concatenate[Env, Arguments], None]]:
    """Give an env's constructor the fields of its options class as explicit keyword arguments.

    The decorated ``__init__(self, options)`` is called with a checked instance of the class. For type checkers,
    editors, `inspect.signature` and `help` the constructor has every field by its name, type and default.

    Parameters
    ----------
    options
        The options class: a keyword-only dataclass with the fields of `EnvOptions` and those of the env.

    Returns
    -------
    callable
        The decorator. The constructor it makes raises ``ValueError`` in one line that names each wrong value and what
        is legal, and ``TypeError`` for positional arguments.

    Examples
    --------
    >>> class MyEnv(ColiasEnv[MyOptions]):
    ...     options_type = MyOptions
    ...
    ...     @keyword_arguments(MyOptions)
    ...     def __init__(self, options: MyOptions) -> None:
    ...         super().__init__(options)
    """

    def decorate(constructor: Callable[[Env, Options], None]) -> Callable[Concatenate[Env, Arguments], None]:
        @functools.wraps(constructor)
        def init(self: Env, *args: Arguments.args, **kwargs: Arguments.kwargs) -> None:
            if args:
                raise TypeError(f"{type(self).__name__}() takes keyword arguments only, {len(args)} positional given")
            constructor(self, checked(options, kwargs))

        init.__signature__ = _with_self(options)  # type: ignore[attr-defined]
        return cast(Callable[Concatenate[Env, Arguments], None], init)

    return decorate


def checked(kind: Callable[..., T], values: Mapping[str, Any]) -> T:
    """Make an instance of an options class from keyword arguments.

    Parameters
    ----------
    kind
        The options class.
    values
        The keyword arguments.

    Returns
    -------
    object
        ``kind(**values)``.

    Raises
    ------
    ValueError
        In one line: each wrong value by its name and what is legal, or the unknown name and the nearest known one.
    """
    flags = _flags(kind, values)
    try:
        validated = kind(**values)
    except ValidationError as error:
        problems = [
            problem for problem in error.errors() if not flags or (problem["loc"] and problem["loc"][0] not in flags)
        ]
        raise ValueError("; ".join([*flags.values(), *(_problem(kind, problem) for problem in problems)])) from None
    if flags:
        raise ValueError("; ".join(flags.values()))
    return validated


def options_of(kind: Any) -> dict[str, FieldInfo]:
    """List the fields of an options class.

    Parameters
    ----------
    kind
        The options class.

    Returns
    -------
    dict
        Name -> default, range and description, in the order of declaration.
    """
    every: Mapping[str, FieldInfo] = kind.__pydantic_fields__
    return {field.name: every[field.name] for field in dataclasses.fields(kind)}


def bounds(option: FieldInfo) -> str:
    """Return the range of a number in words; empty for anything else."""
    low, high = ([getattr(m, sign) for m in option.metadata if hasattr(m, sign)] for sign in ("ge", "le"))
    return f"between {low[0]:g} and {high[0]:g}" if low and high else ""


def _with_self(options: Callable[..., Any]) -> inspect.Signature:
    """Return the signature of ``options``, with aliases of types resolved, as that of a method."""
    fields = options_of(options)
    given = inspect.signature(options).parameters
    parameters = [parameter.replace(annotation=fields[name].annotation) for name, parameter in given.items()]
    itself = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    return inspect.Signature([itself, *parameters], return_annotation=None)


def _flags(kind: Any, values: Mapping[str, Any]) -> dict[str, str]:
    """Name -> what is wrong, for truth values in the place of numbers, which pydantic would take for 0 and 1."""
    numbers = {name: option for name, option in options_of(kind).items() if option.annotation in (int, float)}
    return {
        name: f"{name} must be a number {bounds(option)}, got {values[name]!r}"
        for name, option in numbers.items()
        if is_flag(values.get(name))
    }


def _problem(kind: Any, problem: Mapping[str, Any]) -> str:
    """Return one problem that pydantic found, in words."""
    text = str(problem["msg"]).removeprefix("Value error, ")
    if not problem["loc"]:  # a rule on several options together
        return text
    name, known = str(problem["loc"][0]), options_of(kind)
    if name not in known:
        return f"no keyword argument '{name}'{nearest(name, known, ' (', ')')}: known are {', '.join(known)}"
    if problem["type"] == "value_error":
        return f"{name}={problem['input']!r}: {text}"
    must = text.removeprefix("Input should be ")
    return f"{name} must be {bounds(known[name]) or f'{must[0].lower()}{must[1:]}'}, got {problem['input']!r}"
