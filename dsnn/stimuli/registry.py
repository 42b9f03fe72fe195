"""The stimuli by name. A new one is a file with its parameters and its class, and a line in `_ENTRIES` below.

One of a user's own is a file with the same two and a `StimulusEntry` called ``STIMULUS``.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from dsnn.stimuli.apparent import Apparent, ApparentParams
from dsnn.stimuli.cluttered import Cluttered, ClutteredParams
from dsnn.stimuli.dots import Dots, DotsParams
from dsnn.stimuli.edge import Bar, BarParams, Edge, EdgeParams
from dsnn.stimuli.foliage import Foliage, FoliageParams
from dsnn.stimuli.grating import Grating, GratingParams
from dsnn.stimuli.looming import Looming, LoomingParams
from dsnn.stimuli.plain import Plain, PlainParams
from dsnn.stimuli.reverse_phi import ReversePhi, ReversePhiParams
from dsnn.stimuli.stimulus import ClipParams, Stimulus
from dsnn.stimuli.street import Street, StreetParams


@dataclass(frozen=True, slots=True)
class StimulusEntry:
    """A stimulus: its default parameters, and how to build it from some.

    Parameters
    ----------
    name
        Name by which `stimulus` finds it: up to 60 letters, digits, ``.``, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    build
        Makes the clip from parameters and a seed.
    params
        Default parameters of the stimulus: a frozen, validated dataclass.

    Raises
    ------
    ValueError
        Tables cannot show the name, or a value is of another kind.
    """

    name: str
    summary: str
    build: Callable[[Any, int], Stimulus[ClipParams]]
    params: ClipParams

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,59}", self.name):
            problem = "legal are up to 60 letters, digits, ., - and _"
            raise ValueError(f"StimulusEntry: name={str(self.name)[:40]!r}: {problem}")
        if not isinstance(self.summary, str) or not callable(self.build):
            raise ValueError(f"StimulusEntry {self.name}: legal are a text for summary and a callable for build")
        if not isinstance(self.params, ClipParams):
            kind = type(self.params).__name__
            raise ValueError(f"StimulusEntry {self.name}: params is a {kind}: legal is a dsnn.stimuli.ClipParams")

    def clip(self, seed: int = 0, **changes: Any) -> Stimulus[ClipParams]:
        """Make the stimulus, with changes to its default parameters.

        Parameters
        ----------
        seed
            Of what is random in it, 0 or more. Equal seeds give equal bytes.
        **changes
            Other values of its parameters, by name.

        Returns
        -------
        Stimulus
            The clip. Nothing is painted yet.

        Raises
        ------
        ValueError
            A parameter is unknown, a value is not legal, or ``build`` makes no `Stimulus`: one line that says which.
        """
        known = [field for field in self.params.__dataclass_fields__]
        for key in changes:
            if key not in known:
                near = difflib.get_close_matches(key.lower(), known, 1)
                hint = f" (nearest: {near[0]})" if near else ""
                raise ValueError(f"{self.name} has no parameter '{key}'{hint}: known are {', '.join(known)}")
        try:
            built = self.build(replace(self.params, **changes), seed)
        except ValidationError as error:
            problem = error.errors()[0]
            where = ".".join([self.name, *(str(part) for part in problem["loc"])])
            if problem["type"] == "value_error":
                text = problem["msg"].removeprefix("Value error, ")
                raise ValueError(f"{where}={problem['input']!r}: {text}") from error
            must = problem["msg"].removeprefix("Input should be ")
            raise ValueError(f"{where} must be {must[0].lower()}{must[1:]}, got {problem['input']!r}") from error
        if not isinstance(built, Stimulus):
            raise ValueError(f"{self.name}: build makes a {type(built).__name__}: legal is a dsnn.stimuli.Stimulus")
        return built


_ENTRIES = (
    StimulusEntry("plain", "an object on an even ground: translating, looming, receding", Plain, PlainParams()),
    StimulusEntry("cluttered", "the same before a natural image that shifts", Cluttered, ClutteredParams()),
    StimulusEntry("looming", "a square on a collision course, by half-size over speed", Looming, LoomingParams()),
    StimulusEntry("grating", "a drifting sine or square grating, in any direction", Grating, GratingParams()),
    StimulusEntry("dots", "random dots, a share of which moves together", Dots, DotsParams()),
    StimulusEntry("edge", "one edge that only brightens (ON) or only darkens (OFF)", Edge, EdgeParams()),
    StimulusEntry("bar", "a light or dark bar across the field", Bar, BarParams()),
    StimulusEntry("reverse-phi", "a pattern that reverses its contrast at each step", ReversePhi, ReversePhiParams()),
    StimulusEntry("apparent", "a bar steps on or off, then its neighbour: two strokes", Apparent, ApparentParams()),
    StimulusEntry("foliage", "a natural texture swaying in the wind, going nowhere", Foliage, FoliageParams()),
    StimulusEntry("street", "people or cars that cross a street among windblown foliage", Street, StreetParams()),
)


def _by_name(entries: tuple[StimulusEntry, ...]) -> Mapping[str, StimulusEntry]:
    table = {entry.name: entry for entry in entries}
    if len(table) != len(entries):
        raise ValueError(f"two stimuli share a name in {[entry.name for entry in entries]}")
    return MappingProxyType(table)


STIMULI = _by_name(_ENTRIES)
"""The stimuli that ship: name -> `StimulusEntry`."""


def stimulus_entry(name: str) -> StimulusEntry:
    """Look up a stimulus that ships.

    Parameters
    ----------
    name
        Its name in `STIMULI`.

    Returns
    -------
    StimulusEntry
        Its entry.

    Raises
    ------
    ValueError
        There is no such stimulus; the message has the nearest known name.
    """
    if name not in STIMULI:
        near = difflib.get_close_matches(name.lower(), STIMULI, 1)
        hint = f" (nearest: {near[0]})" if near else ""
        raise ValueError(f"unknown stimulus '{name}'{hint}: known are {', '.join(STIMULI)}")
    return STIMULI[name]


def stimulus(name: str, seed: int = 0, **changes: Any) -> Stimulus[ClipParams]:
    """Make a stimulus that ships, with changes to its default parameters.

    Parameters
    ----------
    name
        Its name in `STIMULI`.
    seed
        Of what is random in it, 0 or more. Equal seeds give equal bytes.
    **changes
        Other values of its parameters, by name. ``colias stimulus NAME --parameters`` lists them.

    Returns
    -------
    Stimulus
        The clip. Nothing is painted yet.

    Raises
    ------
    ValueError
        The name or a parameter is unknown, or a value is not legal: one line that names it and what is legal.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", speed=120.0, motion="leftward")
    >>> len(clip), clip.shape, clip.fps
    (112, (180, 320), 30.0)
    """
    return stimulus_entry(name).clip(seed, **changes)
