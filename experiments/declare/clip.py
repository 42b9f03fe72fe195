"""Clips of synthetic stimuli, without a robot: how a clip, and an experiment of clips, is declared."""

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar, Literal, get_args

from dsnn.stimuli import SCENES, ClipParams, Jitter, Stimulus, StimulusEntry, stimulus_entry
from dsnn.stimuli.background import PHOTOGRAPH
from experiments.base.errors import UsageError, as_usage_error, check_declared, check_known, check_unique
from experiments.base.user_code import USER_MODULE, declared, is_file, run_main
from experiments.declare.claim import Claim, check_claims

BACKGROUND = "background"
"""The parameter that names what is behind an object."""


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
        Pairs of a parameter's name and its value, or a mapping. ``colias list parameters NAME`` lists them.
    jitter_px
        Standard deviation of a trembling camera's shifts, px (`dsnn.stimuli.Jitter`); 0: the camera stands.

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
    changes: Mapping[str, Any] | Iterable[tuple[str, Any]] = ()
    jitter_px: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "changes", tuple(dict(self.changes).items()))
        self.build(0)

    def __reduce_ex__(self, protocol: Any) -> Any:
        """Cross to another process: a stimulus of a user's own file is found in that file there."""
        if isinstance(self.stimulus, StimulusEntry) and (place := place_of(self.stimulus)):
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
            Seed of its random draws, 0 or more.

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
        return Jitter(clip, self.jitter_px, seed) if self.jitter_px else clip

    def takes_scene(self) -> bool:
        """Tell whether a replicate chooses the background: the stimulus has a scene there, and the clip names none.

        Returns
        -------
        bool
            Whether it does.
        """
        usual = getattr(self.entry.params, BACKGROUND, "")
        return usual in (PHOTOGRAPH, *SCENES) and BACKGROUND not in dict(self.changes)

    @property
    def is_random(self) -> bool:
        """Whether it differs between seeds: it has a scene of its own in each replicate, or some frame differs."""
        pairs = zip(self.build(0), self.build(1), strict=True) if not self.takes_scene() else ()
        return self.takes_scene() or any((one.luma != other.luma).any() for one, other in pairs)

    def label(self) -> str:
        """Return the clip's name, as tables show it.

        Returns
        -------
        str
            The name.
        """
        return self.name


def _rebuilt(name: str, file: str, attribute: str, changes: Iterable[tuple[str, Any]], jitter_px: float) -> Clip:
    return Clip(name, declared(Path(file), attribute, StimulusEntry), changes, jitter_px)


Form = Literal["traces", "peaks", "background", "ranges", "contrast"]


DRAWN = ("speed", "grey", "background_speed")
"""Names of the parameters that a figure of peaks may be drawn against."""


@dataclass(frozen=True, slots=True)
class ClipFigure:
    """Way to draw an off-line experiment.

    Parameters
    ----------
    form
        ``traces``: the models' potentials over each clip. ``peaks``: their peaks against a parameter of the clips.
        ``background``: their peaks in depth and translation against the background's speed, px a frame.
        ``contrast``: clips of several greys and speeds: peaks along speed and along grey.
        ``ranges``: of each model, from which to which peak ``|HS|`` its clips with an object reach, and without one.
    along
        The parameter on the axis of peaks: ``speed``, ``grey`` or ``background_speed``.
    lines, panels
        Peaks have a line for each value of the one, and a row of panels for each of the other: names as of ``along``.

    Raises
    ------
    ValueError
        A value is none of these.
    """

    form: Form = "traces"
    along: str = "speed"
    lines: str = "background_speed"
    panels: str = "grey"

    def __post_init__(self) -> None:
        for name, legal in (("form", get_args(Form)), ("along", DRAWN), ("lines", DRAWN), ("panels", DRAWN)):
            check_known(f"figure: {name}", getattr(self, name), legal)

    def parameters(self) -> tuple[str, ...]:
        """Return the parameters of clips that it is drawn against.

        Returns
        -------
        tuple of str
            Their names.
        """
        return (self.along, self.lines, self.panels) if self.form in ("peaks", "background") else ()


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
        Ids of the paper's claims about clips, and claims of your own (`experiments.Claim`, ``on="clips"``).
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
    clips: Sequence[Clip]
    models: Sequence[str]
    claims: tuple[str | Claim, ...] = ()
    repeats: int = 1
    figure: ClipFigure = ClipFigure()
    recorded: bool = True
    file: str = field(default="", compare=False, repr=False, kw_only=True)
    kind: ClassVar[str] = "clips"

    def __post_init__(self) -> None:
        check_declared(self.name, self.repeats, self.models)
        check_claims(self.name, self.claims)
        object.__setattr__(self, "clips", tuple(self.clips))  # a list, or what a generator yields, does as well
        object.__setattr__(self, "models", tuple(self.models))
        if not self.clips:
            raise ValueError(f"experiment {self.name}: it needs clips")
        check_unique(f"experiment {self.name}: two clips", [clip.name for clip in self.clips])
        for clip in self.clips:
            for name in self.figure.parameters():
                if not hasattr(clip.entry.params, name):
                    missing = f"the clip '{clip.name}', a {clip.entry.name}, has no {name} to be drawn against"
                    raise ValueError(f"experiment {self.name}: {missing}")

    def main(self) -> None:
        """Run the experiment of the file that is executed, as ``colias run FILE`` does with its options."""
        run_main()


def find_stimulus(source: str) -> StimulusEntry:
    """Return the registered stimulus called ``source``, or the one that the file ``source`` declares as ``STIMULUS``.

    Raises
    ------
    UsageError
        The name is not known, or the file cannot be read, or declares no `dsnn.stimuli.StimulusEntry`.
    """
    if is_file(source):
        return declared(Path(source), "STIMULUS", StimulusEntry)
    with as_usage_error(after=", or a .py file"):
        return stimulus_entry(source)


def place_of(entry: StimulusEntry) -> tuple[str, str] | None:
    """Return the user's file that a stimulus is declared in, and its name there; ``None`` where that is no such file.

    Raises
    ------
    UsageError
        The file has no name for it, so that no other process could find it.
    """
    for name, module in list(sys.modules.items()):
        if name.startswith(USER_MODULE) and (file := getattr(module, "__file__", None)):
            for attribute, value in vars(module).items():
                if value is entry:
                    return file, attribute
    if (getattr(entry.build, "__module__", "") or "").startswith(USER_MODULE):
        raise UsageError(f"stimulus {entry.name} needs a name in its file, as STIMULUS = StimulusEntry(...)")
    return None
