"""The stimuli by name. A new one is a file with its parameters and its class, and a line in `_ENTRIES` below."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from pydantic import ValidationError

from dsnn.hints import nearest
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
    """A registered stimulus: its default parameters, and how to build it from some."""

    name: str
    """Name by which `stimulus` finds it."""
    summary: str
    """A line for ``colias list``."""
    build: Callable[[Any, int], Stimulus[ClipParams]]
    """Makes the clip from parameters and a seed."""
    params: ClipParams
    """Default parameters of the stimulus: a frozen, validated dataclass."""


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
    if not isinstance(name, str):
        raise ValueError(f"a stimulus's name is a {type(name).__name__}: known are {', '.join(STIMULI)}")
    if name not in STIMULI:
        near = nearest(name, STIMULI, " (", ")")
        raise ValueError(f"unknown stimulus '{name}': known are {', '.join(STIMULI)}{near}")
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
    entry = stimulus_entry(name)
    known = [field for field in entry.params.__dataclass_fields__]
    for key in changes:
        if key not in known:
            near = nearest(key, known, " (", ")")
            raise ValueError(f"{name} has no parameter '{key}': known are {', '.join(known)}{near}")
    try:
        return entry.build(replace(entry.params, **changes), seed)
    except ValidationError as error:
        problem = error.errors()[0]
        where = ".".join([name, *(str(part) for part in problem["loc"])])
        text = problem["msg"].removeprefix("Value error, ")
        reason = f"{text[0].lower()}{text[1:]}"
        raise ValueError(f"{where}={problem['input']!r}: {reason}") from None
