"""Clips of synthetic stimuli, without a robot: how an experiment of clips is declared, and what its trials show."""

from __future__ import annotations

import itertools
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import polars as pl

from dsnn.stimuli import SCENES, ClipParams, Jitter, Stimulus, StimulusEntry, StimulusFrame, Truth, stimulus_entry
from dsnn.stimuli.background import PHOTOGRAPH
from experiments.base.errors import UsageError, as_usage_error, check_declared, check_known, check_unique
from experiments.base.user_code import USER_MODULE, declared, is_file, run_main
from experiments.declare.claim import Claim, check_claims
from experiments.settings.models import ConfiguredModel
from experiments.settings.pictures import Pictures, digests
from experiments.show.play import FRAMES, Sample, Showing, Trial
from experiments.store.tables import COUNTS, JOB, PEAKS, peaks

if TYPE_CHECKING:
    from rerun.chunk import Chunk

    from dsnn import ResponseSeries
    from experiments.show.record import Frames

BACKGROUND = "background"
"""The parameter that names what is behind an object."""
BOX = ("left_px", "top_px", "width_px", "height_px")
BOX_COLOUR = (214, 39, 40)


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

    def open(self, seed: int) -> ClipSource:
        """Return the source of the clip's frames.

        Parameters
        ----------
        seed
            Seed of its random draws, 0 or more.

        Returns
        -------
        ClipSource
            The frames, and the columns and measures of their trial.
        """
        return ClipSource(self, self.build(seed))

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


def _rebuilt(name: str, file: str, attribute: str, changes: Iterable[tuple[str, Any]], jitter_px: float) -> Clip:
    return Clip(name, declared(Path(file), attribute, StimulusEntry), changes, jitter_px)


SHOWN: Mapping[str, type] = {
    "motion": str, "grey": float, "speed": float, "speed_unit": str, "background": str, "background_speed": float,
    "object": str, "movers": str, "foliage": str, "polarity": str, "fps": float,
}  # fmt: skip
"""Columns that are parameters of clips, null where its stimulus has no such.

``background`` is the photograph, a scene, or the name of a user's own picture; ``polarity`` of an edge is on or off.
"""
TRIALS = pl.Schema(
    {
        **JOB,
        "stimulus": str,
        "clip": str,
        **SHOWN,
        "background_mean": float,  # mean grey of what the object passes
        **COUNTS,
        **PEAKS,
        "hs_rightward": float,  # the highest HS of the frames in which the truth says rightward
        "hs_leftward": float,  # the lowest HS of those in which it says leftward
        "hs_against": float,  # distance that HS goes against the truth's direction in either, 0 if it never does
        "frames": int,
        "wall_s": float,  # time that the clip took to show
    }
)
"""Columns of ``trials.parquet`` of clips: a row per clip and model."""


class ClipSource:
    """The frames of a clip, with their truth: motion, and the outline of the object in px."""

    frame_columns = FRAMES

    def __init__(self, clip: Clip, stimulus: Stimulus[ClipParams]) -> None:
        self.clip, self.stimulus = clip, stimulus
        self.fps, self.shape = stimulus.fps, stimulus.shape

    def __len__(self) -> int:
        return len(self.stimulus)

    def __iter__(self) -> Iterator[Sample]:
        for index, frame in enumerate(self.stimulus):
            truth = truth_of(frame.truth)
            yield Sample(index / self.fps, frame.luma, {name: truth[name] for name in ("motion", *BOX)})

    def columns(self) -> dict[str, Any]:
        """Return what is shown, as columns of ``trials.parquet``."""
        shown: dict[str, Any] = {name: getattr(self.stimulus.params, name, None) for name in SHOWN}
        if shown[BACKGROUND] is not None:
            shown[BACKGROUND] = Path(shown[BACKGROUND]).name
        named = {"stimulus": self.clip.entry.name, "clip": self.clip.name}
        return {**named, **shown, "background_mean": self._background_mean()}

    def _background_mean(self) -> float | None:
        """Mean grey of the rows that the object passes, without the object; ``None`` without an object."""
        sampled = [self.stimulus[index] for index in range(0, len(self), max(1, len(self) // 10))]
        box = next((frame.truth.box for frame in sampled if frame.truth.box is not None), None)
        if box is None:
            return None
        rows = slice(max(int(box.top), 0), int(box.top + box.height) + 1)
        return float(np.mean([float(_beside_object(frame)[rows].mean()) for frame in sampled]))

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, float | None]:
        """Return peaks and troughs of a model's potentials, and HS by the direction of motion.

        Parameters
        ----------
        frames
            A row per frame: ``hs``, ``vs``, ``looming`` and the truth's ``motion``.
        """
        hs, motion = frames["hs"].to_numpy(), frames["motion"].to_numpy()
        right, left = hs[motion == "rightward"], hs[motion == "leftward"]
        against = np.concatenate([-right, left])
        return {
            **peaks(frames),
            "hs_rightward": float(right.max()) if right.size else None,
            "hs_leftward": float(left.min()) if left.size else None,
            "hs_against": max(float(against.max()), 0.0) if against.size else None,
        }


def truth_of(truth: Truth) -> dict[str, Any]:
    """Return what is true of a frame, as columns: ``None`` where there is no object, or no contact."""
    box, (across, down) = truth.box, truth.velocity or (None, None)
    outline = (None,) * 4 if box is None else (box.left, box.top, box.width, box.height)
    ways = zip(("background_x_px_s", "background_y_px_s"), truth.background_velocity, strict=True)
    return {
        "motion": truth.motion, **dict(zip(BOX, outline, strict=True)), "velocity_x_px_s": across,
        "velocity_y_px_s": down, **dict(ways), "time_to_contact_s": truth.time_to_contact_s,
    }  # fmt: skip


def _beside_object(frame: StimulusFrame) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Return the columns of a frame in which the object is not; all of them where it fills the frame."""
    box = frame.truth.box
    if box is None:
        return frame.luma
    columns = np.arange(frame.luma.shape[1])
    beside = frame.luma[:, (columns < int(box.left)) | (columns > int(box.left + box.width) + 1)]
    return beside if beside.size else frame.luma


def record(trial: Trial, showings: Sequence[Showing], _rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the recording of a clip that was shown in a trial, as the bytes of an .rrd file."""
    import rerun as rr  # not before: it takes its time to load, and declarations need this file

    from experiments.show import record as rerun

    (showing,), stimulus = showings, showings[0].source.stimulus
    responses = {model.label: series for model, series in showing.series()}
    frames, boxes = recorded(showing.samples, responses)
    # Rerun holds a name to the first type it has in a process: two stimuli may have one as int and as float.
    settings = {**asdict(stimulus.params), "seed": stimulus.seed}
    shown = rr.DynamicArchetype(type(stimulus.params).__name__, components=settings)
    content = rerun.Content(tuple(rerun.RecordedModel.of(model) for model, _ in showing.series()), eyes=("",))
    identity = f"{trial.experiment}-{trial.index}-{trial.seed}"
    return rerun.write(content, frames, trial.condition.name, identity, {"stimulus": shown}, boxes)


def recorded(
    samples: Sequence[Sample], responses: Mapping[str, ResponseSeries], first: int = 0
) -> tuple[Frames, list[Chunk]]:
    """Return frames from number ``first`` on as a recording has them, and the outline of their object."""
    import rerun as rr

    from experiments.show import record as rerun

    time_s, numbers = np.array([sample.time_s for sample in samples]), first + np.arange(len(samples))
    frames = rerun.Frames(time_s, numbers, responses, {"": rerun.jpegs(sample.image for sample in samples)})
    there = [sample.truth.get(BOX[0]) is not None for sample in samples]
    if not any(there):
        return frames, []
    shown = itertools.compress(samples, there)
    boxes = np.array([[sample.truth[name] for name in BOX] for sample in shown])
    columns = rr.Boxes2D.columns(centers=boxes[:, :2] + boxes[:, 2:] / 2, half_sizes=boxes[:, 2:] / 2)
    place = f"{rerun.CAMERA}/stimulus"
    look = rerun.fixed(place, rr.Boxes2D.from_fields(colors=[BOX_COLOUR], radii=[0.5]))
    # No box where there is no object, or the last would stay.
    return frames, [look, rerun.chunk(place, rerun.times(time_s, numbers), columns.partition(there))]


Kind = Literal["traces", "peaks", "background", "ranges", "contrast"]
DRAWN = ("speed", "grey", "background_speed")
"""Names of the parameters that a figure of peaks may be drawn against."""


@dataclass(frozen=True, slots=True)
class ClipFigure:
    """Way to draw an off-line experiment.

    Parameters
    ----------
    kind
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

    kind: Kind = "traces"
    along: str = "speed"
    lines: str = "background_speed"
    panels: str = "grey"

    def __post_init__(self) -> None:
        for name, legal in (("kind", get_args(Kind)), ("along", DRAWN), ("lines", DRAWN), ("panels", DRAWN)):
            check_known(f"figure: {name}", getattr(self, name), legal)

    def parameters(self) -> tuple[str, ...]:
        """Return the parameters of clips that it is drawn against.

        Returns
        -------
        tuple of str
            Their names.
        """
        return (self.along, self.lines, self.panels) if self.kind in ("peaks", "background") else ()


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

    def trials(
        self, models: tuple[Any, ...], repeats: int, seed: int, pictures: Pictures | None = None
    ) -> tuple[Trial, ...]:
        """Return every clip of every repeat. Repeat r has the seed ``seed + r``, and so one scene for all its clips.

        Parameters
        ----------
        models
            The models, with their parameters.
        repeats, seed
            Number of repeats, and the seed of the first.
        pictures
            Shown in place of the scenes.

        Returns
        -------
        tuple of Trial
            The trials, repeats outermost.
        """
        whole = [(repeat, clip) for repeat in range(repeats) for clip in clips_of(self.clips, repeat, pictures)]
        return tuple(
            Trial(self.name, index, repeat, seed + repeat, clip, models)
            for index, (repeat, clip) in enumerate(whole)
        )  # fmt: skip


def clips_of(clips: Sequence[Clip], replicate: int, pictures: Pictures | None = None) -> list[Clip]:
    """Return clips as a replicate shows them: replicate r has scene r.

    Replicate 0 has the stimulus's own background, the photograph. Those from 1 on go through the kinds of
    `dsnn.stimuli.SCENES`, one after another and again, and the replicate's seed makes the scene. With ``pictures``
    each has one of those instead, replicate 0 too. A clip that names its background keeps it.
    """
    if pictures is None and not replicate:
        return list(clips)
    image = {BACKGROUND: _image(replicate, pictures)}
    return [replace(clip, changes=dict(clip.changes) | image) if clip.takes_scene() else clip for clip in clips]


def _image(replicate: int, pictures: Pictures | None) -> str:
    """Return the background of a replicate's clips that name none."""
    if pictures:
        return pictures[replicate % len(pictures)]  # after the last one the first comes again
    return list(SCENES)[(replicate - 1) % len(SCENES)] if replicate else PHOTOGRAPH


def described_scenes(clips: Iterable[Clip], replicates: int, pictures: Pictures | None) -> dict[str, list[str]]:
    """Return what ``run.json`` has of the scenes of clips; nothing where none of them takes one.

    ``backgrounds`` has the background of each replicate, ``pictures`` each of a user's own with its digest.
    """
    if not any(clip.takes_scene() for clip in clips):
        return {}
    names = [Path(_image(replicate, pictures)).name for replicate in range(replicates)]
    return {"backgrounds": names, **({"pictures": digests(pictures)} if pictures else {})}


def find_stimulus(source: str) -> StimulusEntry:
    """Return the registered stimulus called ``source``, or the one that the file ``source`` declares as ``STIMULUS``.

    Raises
    ------
    UsageError
        The name is not known, or the file cannot be read, or declares no `dsnn.stimuli.StimulusEntry`.
    """
    if is_file(source):
        entry: StimulusEntry = declared(Path(source), "STIMULUS", StimulusEntry)
        return entry
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
