"""Off-line experiments: clips of a stimulus shown to models, without a robot.

An experiment of clips, the result of one clip, and the rows it leaves.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from dsnn.stimuli import SCENES, ClipParams, Jittered, Stimulus, StimulusEntry, stimulus_entry
from dsnn.stimuli.background import PHOTOGRAPH
from experiments.bench.clips import stimuli
from experiments.bench.engine.pictures import Pictures
from experiments.bench.run.errors import check_declared, plain
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.stats.claim import Claim
from experiments.bench.stats.declared import check_claims

DRAWN = ("speed", "grey", "background_speed")
"""Names of the changes that a figure of peaks may be drawn against."""
BACKGROUND = "background"
"""The parameter that names what is behind an object."""
CLIP = "experiments.Clip(name, stimulus, changes, jitter_px)"


@dataclass(frozen=True, slots=True)
class Clip:
    """A stimulus to show, with changes to its defaults.

    Parameters
    ----------
    name
        Tells it from the experiment's other clips.
    stimulus
        One that ``colias list`` names: ``plain``, ``cluttered``, ...; or a `dsnn.stimuli.StimulusEntry` of your own.
    changes
        Pairs of a parameter's name and its value, or a mapping. ``colias stimulus NAME --parameters`` lists them.
    jitter_px
        Standard deviation of a trembling camera's shifts, px (`dsnn.stimuli.Jittered`); 0: the camera stands.

    Raises
    ------
    ValueError
        There is no such stimulus or parameter, or a value is out of range.

    Examples
    --------
    >>> from experiments import Clip
    >>> Clip("dark", "plain", (("grey", 40.0), ("speed", 120.0))).label()
    'dark'
    """

    name: str
    stimulus: str | StimulusEntry
    changes: tuple[tuple[str, Any], ...] = ()
    jitter_px: float = 0.0

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or not self.name:
            raise ValueError(f"clip {self.name!r}: its name: legal is a text")
        if not isinstance(self.jitter_px, int | float) or isinstance(self.jitter_px, bool):
            raise ValueError(f"clip {self.name}: jitter_px={self.jitter_px!r}: legal is a number")
        try:
            object.__setattr__(
                self, "changes", tuple((name, plain(value)) for name, value in dict(self.changes).items())
            )
        except (TypeError, ValueError):
            problem = f"changes={self.changes!r}: legal is pairs of a parameter's name and its value"
            raise ValueError(f"clip {self.name}: {problem}") from None
        self.build(0)

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Cross to another process: a stimulus of a user's own file is found in that file there."""
        if isinstance(self.stimulus, StimulusEntry) and (place := stimuli.place_of(self.stimulus)):
            return _rebuilt, (self.name, *place, self.changes, self.jitter_px)
        return object.__reduce_ex__(self, protocol)

    @property
    def entry(self) -> StimulusEntry:
        """The stimulus itself: its name, its defaults and how it is built."""
        return self.stimulus if isinstance(self.stimulus, StimulusEntry) else stimulus_entry(self.stimulus)

    def build(self, seed: int) -> Stimulus[ClipParams]:
        """Make the clip itself.

        Parameters
        ----------
        seed
            Of what is random in it, 0 or more.

        Returns
        -------
        Stimulus
            The clip. Nothing is painted yet.

        Raises
        ------
        ValueError
            The seed is below 0.
        """
        clip = self.entry.clip(seed, **dict(self.changes))
        return Jittered(clip, self.jitter_px, seed) if self.jitter_px else clip

    def takes_scene(self) -> bool:
        """Tell whether a replicate chooses the background: the stimulus has one, and the clip names none.

        Returns
        -------
        bool
            Whether it does.
        """
        return hasattr(self.entry.params, BACKGROUND) and BACKGROUND not in dict(self.changes)

    def label(self) -> str:
        """Return the clip's name, as tables show it.

        Returns
        -------
        str
            The name.
        """
        return self.name


def _rebuilt(name: str, file: str, attribute: str, changes: tuple[tuple[str, Any], ...], jitter_px: float) -> Clip:
    return Clip(name, stimuli.of_file(Path(file), attribute), changes, jitter_px)


@dataclass(frozen=True, slots=True)
class Figure:
    """Way to draw an off-line experiment.

    Parameters
    ----------
    kind
        ``traces``: the models' potentials over each clip. ``peaks``: their peaks against a parameter of the clips.
        ``background``: their peaks in depth and translation against the background's speed, px a frame.
        ``edges``: clips of a single edge of either polarity, and what the other models leave of the DSNN's ``|HS|``.
        ``contrast``: clips of several greys and speeds: HS over time, and peaks along speed and along grey.
        ``ranges``: of each model, from which to which peak ``|HS|`` its clips with an object reach, and without one.
    along
        The parameter on the axis of peaks: ``speed``, ``grey`` or ``background_speed``.
    lines, panels
        Peaks have a line for each value of the one, and a row of panels for each of the other. Both are legal as
        ``along`` is.

    Raises
    ------
    ValueError
        A value is none of these.
    """

    kind: Literal["traces", "peaks", "background", "edges", "ranges", "contrast"] = "traces"
    along: str = "speed"
    lines: str = "background_speed"
    panels: str = "grey"

    def __post_init__(self) -> None:
        kinds = ("traces", "peaks", "background", "edges", "ranges", "contrast")
        if self.kind not in kinds:
            raise ValueError(f"figure: kind={self.kind!r}: legal is {', '.join(kinds)}")
        for name in ("along", "lines", "panels"):
            if getattr(self, name) not in DRAWN:
                raise ValueError(f"figure: {name}={getattr(self, name)!r}: legal is {', '.join(DRAWN)}")


@dataclass(frozen=True, slots=True)
class OfflineExperiment:
    """A declaration of clips that models are shown, without a robot: every clip to every model.

    Parameters
    ----------
    name
        Letters, digits, ``-`` and ``_``.
    summary
        A line for ``colias list``.
    clips
        What is shown; any iterable of `Clip` objects.
    models
        Names, or paths of .py files, of the models that it is about.
    claims
        Ids of the paper's claims about clips, and claims of your own (`experiments.ClipClaim`).
    repeats
        How often, each time with another seed and before another scene: a repeat is a replicate. Where nothing in the
        clips is random, one is enough.
    figure
        How it is drawn.
    recorded
        Whether the first seed's clips are recorded for Rerun; a grid of long clips would fill a disk.
    file
        The .py file that declares it, which commands and `experiments.run` fill in.

    Raises
    ------
    ValueError
        The declaration cannot be run as it stands.

    Examples
    --------
    >>> from experiments import Clip, OfflineExperiment
    >>> clips = [Clip(way, "plain", {"motion": way}) for way in ("rightward", "leftward")]
    >>> both = OfflineExperiment("both-ways", "crossings both ways", clips, ("dsnn", "emd"))
    """

    name: str
    summary: str
    clips: tuple[Clip, ...]
    models: tuple[str, ...]
    claims: tuple[str | Claim, ...] = ()
    repeats: int = 1
    figure: Figure = Figure()
    recorded: bool = True
    file: str = field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_declared("experiment", self.name, self.summary, self.repeats)
        check_claims(self.name, self.claims)
        if isinstance(self.models, str) or not isinstance(self.models, Sequence):
            raise ValueError(f"experiment {self.name}: models={self.models!r}: legal is a tuple of names")
        if isinstance(self.clips, str) or not isinstance(self.clips, Iterable):
            raise ValueError(f"experiment {self.name}: clips={self.clips!r}: legal is a tuple of {CLIP}")
        object.__setattr__(self, "clips", tuple(self.clips))  # a list, or what a generator yields, does as well
        object.__setattr__(self, "models", tuple(self.models))
        if not self.clips or not self.models:
            raise ValueError(f"experiment {self.name}: it needs clips and models")
        for index, clip in enumerate(self.clips):
            if not isinstance(clip, Clip):
                raise ValueError(f"experiment {self.name}: clips[{index}] is {clip!r}: expected {CLIP}")
        for index, model in enumerate(self.models):
            if not isinstance(model, str):
                raise ValueError(f"experiment {self.name}: models[{index}] is {model!r}: expected a name or a path")
        if not isinstance(self.figure, Figure):
            raise ValueError(f"experiment {self.name}: figure={self.figure!r}: legal is a Figure")
        if not isinstance(self.recorded, bool):
            raise ValueError(f"experiment {self.name}: recorded={self.recorded!r}: legal is True or False")
        names = [clip.name for clip in self.clips]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ValueError(f"experiment {self.name}: two clips are called '{twice}'")
        self._check_figure()

    def _check_figure(self) -> None:
        """Peaks are drawn against parameters: every clip has to have them."""
        of_peaks = (self.figure.along, self.figure.lines, self.figure.panels)
        of_edges = ("polarity", "motion", "speed")
        drawn = {"peaks": of_peaks, "background": ("speed", "grey", "background_speed"), "edges": of_edges}.get(
            self.figure.kind, ()
        )
        for clip in self.clips:
            known = clip.entry.params
            for name in drawn:
                if not hasattr(known, name):
                    problem = f"'{clip.name}', a {clip.entry.name}, has no {name} to draw peaks against"
                    raise ValueError(f"experiment {self.name}: the clip {problem}")


@dataclass(frozen=True, slots=True)
class Showing:
    """One clip to show, wholly determined: `show` is a pure function of it."""

    experiment: str
    index: int
    repeat: int
    seed: int
    condition: Clip
    models: tuple[ConfiguredModel, ...]

    def frame_rates(self) -> Iterable[tuple[ConfiguredModel, float]]:
        """Return the job's models, each with the clip's frame rate, 1/s."""
        rate = _fps(self.condition)
        return ((model, rate) for model in self.models)


@cache
def _fps(clip: Clip) -> float:
    return clip.build(0).fps


def showings(
    experiment: OfflineExperiment, models: tuple[ConfiguredModel, ...], repeats: int, seed: int,
    pictures: Pictures | None = None,
) -> list[Showing]:  # fmt: skip
    """Every clip of every repeat. Repeat r has the seed ``seed + r`` throughout: one background for all its clips."""
    whole = [(repeat, clip) for repeat in range(repeats) for clip in clips_of(experiment.clips, repeat, pictures)]
    return [
        Showing(experiment.name, index, repeat, seed + repeat, clip, models)
        for index, (repeat, clip) in enumerate(whole)
    ]


def clips_of(clips: Sequence[Clip], replicate: int, pictures: Pictures | None = None) -> list[Clip]:
    """Return clips as a replicate shows them: replicate r has scene r.

    Replicate 0 has the stimulus's own background, the photograph. Those from 1 on go through the kinds of
    `dsnn.stimuli.SCENES`, one after another and again, and the replicate's seed makes the scene. With ``pictures``
    each has one of those instead, replicate 0 too. A clip that names its background keeps it.
    """
    if pictures is None and not replicate:
        return list(clips)
    image = (BACKGROUND, _image(replicate, pictures))
    return [replace(clip, changes=(*clip.changes, image)) if clip.takes_scene() else clip for clip in clips]


def _image(replicate: int, pictures: Pictures | None) -> str:
    """Return the background of a replicate's clips that name none."""
    if pictures:
        return pictures.of(replicate)
    return list(SCENES)[(replicate - 1) % len(SCENES)] if replicate else PHOTOGRAPH


def described_scenes(clips: Iterable[Clip], replicates: int, pictures: Pictures | None) -> dict[str, list[str]]:
    """Return what ``run.json`` has of the scenes of clips; nothing where none of them takes one.

    ``backgrounds`` has the background of each replicate, ``pictures`` each of a user's own with its digest.
    """
    if not any(clip.takes_scene() for clip in clips):
        return {}
    names = [Path(_image(replicate, pictures)).name for replicate in range(replicates)]
    return {"backgrounds": names, **({"pictures": pictures.described()} if pictures else {})}
