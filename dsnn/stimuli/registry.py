"""Look up stimuli by name. To add one, write a file with its parameters and class, and a line in `_ENTRIES` below.

Your own stimulus is a file with parameters, a class and a `StimulusEntry` called ``STIMULUS``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from pydantic.dataclasses import dataclass

from dsnn.registry import Name, look_up
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
from dsnn.stimuli.target import Target, TargetParams


@dataclass(frozen=True)
class StimulusEntry:
    """A registered stimulus: its default parameters, and how to build it.

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
    pydantic.ValidationError
        The name has other characters, or a value has the wrong type.
    """

    name: Name
    summary: str
    build: Callable[[Any, int], Stimulus[ClipParams]]
    params: ClipParams

    def clip(self, seed: int = 0, **changes: Any) -> Stimulus[ClipParams]:
        """Make the stimulus, with changes to its default parameters.

        Parameters
        ----------
        seed
            Seed of its random parts, 0 or more. Equal seeds give equal bytes on one machine.
        **changes
            Other values of its parameters, by name.

        Returns
        -------
        Stimulus
            The clip. Nothing is painted yet.

        Raises
        ------
        pydantic.ValidationError
            A parameter is unknown, or a value is out of range.
        """
        return self.build(replace(self.params, **changes), seed)


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
    StimulusEntry("target", "a target of 1 to 15 px before a moving natural image", Target, TargetParams()),
)


STIMULI: Mapping[str, StimulusEntry] = {entry.name: entry for entry in _ENTRIES}
"""The built-in stimuli: name -> `StimulusEntry`."""


def stimulus_entry(name: str) -> StimulusEntry:
    """Look up a built-in stimulus.

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
        The stimulus is unknown; the message suggests the most similar name.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus_entry
    >>> stimulus_entry("looming").params.end_deg
    60.0
    """
    return look_up("stimulus", name, STIMULI)


def stimulus(name: str, seed: int = 0, **changes: Any) -> Stimulus[ClipParams]:
    """Make a built-in stimulus, with changes to its default parameters.

    Parameters
    ----------
    name
        Its name in `STIMULI`.
    seed
        Seed of its random parts, 0 or more. Equal seeds give equal bytes on one machine.
    **changes
        Other values of its parameters, by name. ``colias list parameters NAME`` lists them.

    Returns
    -------
    Stimulus
        The clip. Nothing is painted yet.

    Raises
    ------
    ValueError
        The name or a parameter is unknown, or a value is out of range.

    Examples
    --------
    >>> from dsnn.stimuli import stimulus
    >>> clip = stimulus("plain", speed=120.0, motion="leftward")
    >>> len(clip), clip.shape, clip.fps
    (112, (180, 320), 30.0)
    """
    return stimulus_entry(name).clip(seed, **changes)
