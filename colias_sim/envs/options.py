"""The keyword arguments that every env takes, frozen and validated."""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Protocol, TypeVar

import numpy as np
import numpy.typing as npt
from pydantic import AfterValidator, ConfigDict, Field, ValidationError
from pydantic.dataclasses import dataclass
from pydantic.fields import FieldInfo

from colias_sim.config import known_arena

MOST_ROBOTS = 20
STRICT = ConfigDict(extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)
Arena = Annotated[str, AfterValidator(known_arena)]
"""The name of a registered arena."""


class Answer(Protocol):
    """What a vision model says of a frame: potentials in (-1, 1), spikes a frame, looming from 0.5 up to 1, azimuth."""

    @property
    def hs(self) -> float: ...  # noqa: D102
    @property
    def vs(self) -> float: ...  # noqa: D102
    @property
    def hs_spikes(self) -> int: ...  # noqa: D102
    @property
    def vs_spikes(self) -> int: ...  # noqa: D102
    @property
    def looming(self) -> float: ...  # noqa: D102
    @property
    def looming_spikes(self) -> int: ...  # noqa: D102
    @property
    def azimuth(self) -> float: ...  # noqa: D102


class Model(Protocol):
    """What an env asks of a vision model; those of ``dsnn`` have it."""

    def step(self, frame: npt.NDArray[np.uint8]) -> Answer:
        """Answer the next frame, (R, C) uint8."""
        ...

    def reset(self) -> None:
        """Forget every frame."""
        ...


RenderMode = Literal["rgb_array", "rgb_array_list", "human"]
View = Literal["arena", "top", "observer"]
T = TypeVar("T")


@dataclass(frozen=True, config=STRICT)
class EnvOptions:
    """What a person may set of any env; a value outside its range raises ``ValueError`` through `checked`."""

    observation: Literal["pixels", "neural", "both", "state"] = Field(
        default="pixels", description="what the agent observes"
    )
    actions: Literal["wheels", "manoeuvres"] = Field(
        default="wheels", description="two wheel speeds, or one of seven manoeuvres"
    )
    frame_skip: int = Field(default=1, ge=1, le=30, description="camera frames, of 1/30 s, that an action lasts")
    robots: int = Field(default=1, ge=0, le=MOST_ROBOTS, description="other robots in the arena")
    arena: Arena = Field(default="bright", description="an arena of scenes")
    noise: float = Field(default=1.0, ge=0.0, le=10.0, description="camera noise, times the data sheet's")
    randomise: float = Field(default=0.0, ge=0.0, le=1.0, description="domain randomisation: 0 none, 1 the widest")
    model: Any = Field(
        default="hybrid", description="vision model of neural observations: a name, a .py file, an entry, or a factory"
    )
    render_mode: RenderMode | None = Field(default=None, description="how render() shows the scene")
    render_view: View = Field(default="arena", description="where render() looks from")
    render_width: int = Field(default=480, ge=16, le=1920, description="of render()'s picture, px")
    render_height: int = Field(default=360, ge=16, le=1080, description="of render()'s picture, px")


def checked(kind: type[T], values: Mapping[str, Any]) -> T:
    """``kind(**values)``; ``ValueError`` in one line naming each wrong value and what is legal, or no such name."""
    try:
        return kind(**values)
    except ValidationError as error:
        raise ValueError("; ".join(_said(kind, problem) for problem in error.errors())) from None


def options_of(kind: type[Any]) -> dict[str, FieldInfo]:
    """The options by name, in order: default, range and meaning of each."""
    every: Mapping[str, FieldInfo] = kind.__pydantic_fields__
    return {field.name: every[field.name] for field in dataclasses.fields(kind)}


def bounds(option: FieldInfo) -> str:
    """``least .. greatest`` of a number; empty for what is none."""
    low, high = ([getattr(m, sign) for m in option.metadata if hasattr(m, sign)] for sign in ("ge", "le"))
    return f"{low[0]:g} .. {high[0]:g}" if low and high else ""


def _said(kind: type[Any], problem: Mapping[str, Any]) -> str:
    text = str(problem["msg"]).removeprefix("Value error, ")
    if not problem["loc"]:  # of several options together
        return text
    name, known = str(problem["loc"][0]), options_of(kind)
    if name not in known:
        near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
        return f"no keyword argument '{name}': known are {', '.join(known)} (nearest: {near})"
    legal = bounds(known[name])
    return f"{name}={problem['input']!r}: {text[0].lower()}{text[1:]}" + (f" ({legal})" if legal else "")
