"""The laws that trials, clips and envs take for granted of every vision model, stimulus and arena.

A law is a function of a model, a stimulus or an arena; its docstring states it. ``colias check`` tries them on
yours, and the tests on all that ship.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from itertools import pairwise, product
from typing import Any, TypeVar

import cv2
import numpy as np
import numpy.typing as npt

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.scene import compile_arena
from colias_sim.streams import world
from dsnn import CHANNELS, ResponseError, ResponseSeries, checked_response
from dsnn.model import SPIKING
from dsnn.stimuli import StimulusEntry, StimulusFrame, stimulus
from experiments.base.streams import stream
from experiments.base.user_code import of_users, traced
from experiments.judge.tests import written
from experiments.settings.models import ConfiguredModel

T = TypeVar("T")
Frames = npt.NDArray[np.uint8]


def try_laws(laws: Sequence[Callable[[T], None]], subject: T) -> dict[Callable[[T], None], str]:
    """Try laws on a subject.

    Returns
    -------
    dict
        Law -> how it is broken, empty where it is kept: the message of a ``ValueError`` of ours, or the
        traceback of what a user's own code raises, which breaks the law too.
    """
    troubles = {}
    for law in laws:
        troubles[law] = ""
        try:
            law(subject)
        except (Exception, SystemExit) as error:
            ours = isinstance(error, ValueError) and not of_users(error)
            troubles[law] = str(error) if ours else traced(error)
    return troubles


# --- models -----------------------------------------------------------------------------------------------------------

SHAPE, LARGER = (72, 99), (180, 320)
REST = {"hs": 0.0, "vs": 0.0, "looming": 0.5}
"""Largest size of each potential while nothing moves."""
NEGLIGIBLE = 1e-6
LEAST_SHARE = 0.5
"""Share, of the stronger of two responses to mirror images, that the weaker one has to reach."""
ALIKE = 0.02
"""Largest difference of two looming potentials to mirror images."""


def _stacked(frames: Iterable[Frames]) -> Frames:
    """Return frames as an array that no model can write to, (T, R, C)."""
    clip = np.stack([*frames])
    clip.flags.writeable = False
    return clip


@cache
def crossing(shape: tuple[int, int] = SHAPE) -> Frames:
    """Return a dark square that goes right and, shifted by hand, a little down, (T, R, C)."""
    rows, columns = shape
    size = {"rows": rows, "columns": columns, "width": columns / 4, "height": rows / 3, "speed": columns}
    clip = stimulus("plain", 0, **size, rest_s=0.1, enters=False)
    return _stacked(np.roll(frame.luma, i // 2, axis=0) for i, frame in enumerate(clip))


@cache
def approach() -> Frames:
    """Return a dark square that looms off the middle, (T, R, C)."""
    return _stacked(frame.luma for frame in stimulus("looming", l_over_v_s=0.08, azimuth_deg=5.0, elevation_deg=-3.0))


def _responses(chosen: ConfiguredModel, frames: Iterable[Frames], model: Any = None) -> ResponseSeries:
    """Return the responses of a model, or of a new one; ``ValueError`` for the first invalid one."""
    responses = []
    for index, frame in enumerate(frames):
        model = model or chosen.build(frame.shape)
        try:
            responses.append(checked_response(model.step(frame), chosen.channels))
        except ResponseError as error:
            raise ValueError(f"in frame {index}, {error}") from error
    return ResponseSeries.from_responses(responses)


def _demand_equal(chosen: ConfiguredModel, one: ResponseSeries, other: ResponseSeries, remedy: str) -> None:
    """Raise ``ValueError`` at the first frame in which two series are not the same."""
    for channel in chosen.channels:
        before, now = getattr(one, channel), getattr(other, channel)
        for at in np.flatnonzero(before != now)[:1]:
            raise ValueError(f"in frame {at} {channel} is {now[at]:z.3g}, and {before[at]:z.3g} before: {remedy}")


def answers(chosen: ConfiguredModel) -> None:
    """Every frame, of 99x72 and 320x180, gets a response in its range."""
    for frames in (crossing(), approach(), crossing(LARGER)[:10]):
        looming = _responses(chosen, frames).looming
        if "looming" in chosen.channels and not (looming.min() >= REST["looming"] and looming.max() <= 1.0):
            raise ValueError(f"looming must be from 0.5, at rest, to 1, got {looming.min():.3g} to {looming.max():.3g}")


def reset(chosen: ConfiguredModel) -> None:
    """After reset() the same frames get the same responses."""
    model = chosen.build(SHAPE)
    first = _responses(chosen, crossing(), model)
    model.reset()
    _demand_equal(chosen, first, _responses(chosen, crossing(), model), "reset() has to forget every frame")


def determinism(chosen: ConfiguredModel) -> None:
    """Two models built alike respond alike."""
    one, other = (_responses(chosen, crossing()) for _ in range(2))
    _demand_equal(chosen, one, other, "draws need a seed of their own, a parameter")


def buffer(chosen: ConfiguredModel) -> None:
    """The caller may reuse the array of a frame."""

    def reused() -> Iterator[Frames]:
        frame = np.zeros(SHAPE, np.uint8)
        for shown in crossing():
            frame[:] = shown
            yield frame
            frame[:] = 0

    remedy = "the caller reuses its frame, so keep a copy, frame.astype(float)"
    _demand_equal(chosen, _responses(chosen, crossing()), _responses(chosen, reused()), remedy)


def stillness(chosen: ConfiguredModel) -> None:
    """A still scene is silent."""
    frame = stream("conformance.frame", 0).integers(0, 256, SHAPE, np.uint8)
    series = _responses(chosen, [frame] * 6)
    for channel in (channel for channel in SPIKING if channel in chosen.channels):
        potential, spikes = getattr(series, channel), getattr(series, f"{channel}_spikes")
        if (np.abs(potential - REST[channel]) > NEGLIGIBLE).any() or spikes.any():
            problem = f"{channel} is {potential[-1]:.3g} with {np.abs(spikes).sum()} spikes in a still scene"
            raise ValueError(f"{problem}: expected {REST[channel]:g} and none")


def mirror(chosen: ConfiguredModel) -> None:
    """A mirror image turns the sign of hs and vs, and leaves looming."""
    # The clip for VS is the same one on its side: its main motion is downward.
    for channel, clip, axis in (("hs", crossing(), 2), ("vs", crossing(SHAPE[::-1]).transpose(0, 2, 1), 1)):
        if channel in chosen.channels:
            # Means over the clip: of a potential that saturates, the strongest moment would be any.
            there, back = (getattr(_responses(chosen, f), channel).mean() for f in (clip, np.flip(clip, axis).copy()))
            weak, strong = sorted((abs(there), abs(back)))
            if strong > NEGLIGIBLE and (there * back >= 0 or weak < LEAST_SHARE * strong):
                problem = f"the mean {channel} is {there:.3g} for a crossing and {back:.3g} for its mirror image"
                raise ValueError(f"{problem}: expected the other sign, at least half as strong")
    if "looming" in chosen.channels:
        one, other = (_responses(chosen, frames).looming for frames in (approach(), np.flip(approach(), 2).copy()))
        if (apart := np.abs(one - other).max()) > ALIKE:
            raise ValueError(f"looming differs by {apart:.3g} between an approach and its mirror image: expected none")


def refusal(chosen: ConfiguredModel) -> None:
    """Frames of another shape are rejected."""
    model, wrong = chosen.build(SHAPE), np.zeros((SHAPE[0], SHAPE[1] - 1), np.uint8)
    try:
        for _ in range(2):  # some compare a frame with the last
            model.step(wrong)
    except Exception:
        return
    raise ValueError(f"a model built for {SHAPE} takes frames of {wrong.shape}: dsnn.frames.luma(frame, shape) refuses")


def declaration(chosen: ConfiguredModel) -> None:
    """Channels that respond are declared, and what passes a threshold spikes."""
    runs = [(chosen.build(frames.shape[1:]), frames) for frames in (crossing(), approach())]
    responses = [model.step(frame) for model, frames in runs for frame in frames]
    names = [*CHANNELS, *(f"{channel}_spikes" for channel in SPIKING)]
    largest = {name: max(abs(getattr(response, name, 0.0)) for response in responses) for name in names}
    for channel in CHANNELS:
        if largest[channel] and channel not in chosen.channels:
            raise ValueError(f"it responds in {channel}, which is not declared and is dropped: ModelEntry(channels=)")
    fires = {channel: largest[f"{channel}_spikes"] > 0 for channel in SPIKING if channel in chosen.channels}
    for channel, spikes in fires.items():
        threshold = chosen.thresholds[channel]
        if spikes and threshold is None:
            raise ValueError(f"{channel} spikes without a threshold, t_sp or thresholds= of ModelEntry: not counted")
        if threshold is not None and largest[channel] > threshold and not any(fires.values()):
            raise ValueError(f"{channel} passes {threshold:g}, but {channel}_spikes stays 0: step returns the spikes")


def vision(chosen: ConfiguredModel) -> Iterator[str]:
    """Yield what a model responds to one clip and its controls, a line for each channel with a potential.

    HS and VS are means over a crossing to the right, or down; looming is the largest potential of an approach.
    """
    down = crossing(SHAPE[::-1]).transpose(0, 2, 1)
    clips = {"hs": (crossing(), 2), "vs": (down, 1), "looming": (approach(), 2)}
    for channel, (clip, axis) in ((name, clips[name]) for name in clips if name in chosen.channels):
        shown = {
            "shown": clip, "frozen": np.repeat(clip[:1], len(clip), 0), "absent": np.full_like(clip, clip[0, 0, 0]),
            "mirrored": np.flip(clip, axis), "reversed": clip[::-1],
        }  # fmt: skip
        series = {name: getattr(_responses(chosen, frames.copy()), channel) for name, frames in shown.items()}
        read = np.max if channel == "looming" else np.mean
        texts = (f"{name} {written(float(read(values)))}" for name, values in series.items())
        yield f"{channel:<13}{', '.join(texts)}"


MODELS = (answers, reset, determinism, buffer, stillness, mirror, refusal, declaration)

# --- stimuli: the truth of a frame is compared with what is painted --------------------------------------------------

SEED = 3
MOST_FRAMES = 150
"""Frames that are looked at, from the first; a clip may be longer."""
EDGE_PX = 1.0
"""Greatest reach of an object's antialiased edge beyond its outline, px."""
SLOPPY = 1.0
"""Largest difference between an object's displacement in a frame and what its velocity says, px."""
UNLIKE = 1e-3
"""Difference of two correlations of pictures that is none: a grating moved by half a period moves either way."""
STILL_GREY = 1
"""Largest change of a pixel that is called still, grey levels: what rounding does."""


def _frames(entry: StimulusEntry) -> list[StimulusFrame]:
    clip = entry.clip(SEED)
    return [clip.frame(index) for index in range(min(len(clip), MOST_FRAMES))]


def frames(entry: StimulusEntry) -> None:
    """Every frame is uint8, of the shape of its parameters, and there are 2 or more."""
    for clip in (entry.clip(SEED), entry.clip(SEED, rows=48, columns=80)):
        if len(clip) < 2:
            raise ValueError(f"len(clip) must be 2 or more, got {len(clip)}")
        shape = (clip.params.rows, clip.params.columns)
        for index in range(min(len(clip), MOST_FRAMES)):
            luma = np.asarray(clip.frame(index).luma)
            if luma.dtype != np.uint8 or luma.shape != shape:
                raise ValueError(f"frame {index} must be uint8 {shape}, got {luma.dtype} {luma.shape}")


def order(entry: StimulusEntry) -> None:
    """A frame is the same whenever and in whatever order it is asked for."""
    clip = entry.clip(SEED)
    places = (0, len(clip) // 2, len(clip) - 1)
    forward = [clip.frame(index).luma.copy() for index in places]
    clip.frame(places[1]).luma[:] = 7  # what a caller does with its frame is no business of the next
    for index, before in zip(reversed(places), reversed(forward), strict=True):
        if not np.array_equal(clip.frame(index).luma, before):
            raise ValueError(f"frame {index} changes when asked for again: paint it from index, params and seed alone")


def seeds(entry: StimulusEntry) -> None:
    """Equal seeds give equal bytes and equal truth."""
    for index, (one, other) in enumerate(zip(_frames(entry), _frames(entry), strict=True)):
        if not np.array_equal(one.luma, other.luma) or one.truth != other.truth:
            raise ValueError(f"frame {index} is another in a clip built alike: draw by dsnn.stimuli.streams.stream")


def truth(entry: StimulusEntry) -> None:
    """The truth has a word and finite numbers, and pictures that move as a whole move as it says."""
    shown, fps = _frames(entry), entry.clip(SEED).fps
    for index, known in enumerate(frame.truth for frame in shown):
        box = (known.box.left, known.box.top, known.box.width, known.box.height) if known.box else ()
        if not known.motion or not np.isfinite((*(known.velocity or ()), *known.background_velocity, *box)).all():
            raise ValueError(f"in frame {index} the truth is {known}: expected a word for the motion, finite numbers")
    alike = []
    for before, after in pairwise(shown):
        right, down = (speed / fps for speed in before.truth.background_velocity)
        margin = math.ceil(max(abs(right), abs(down)))
        if margin and before.truth.background_velocity == after.truth.background_velocity:
            inner = (slice(margin, -margin),) * 2
            alike.append([_likeness(_shifted(before.luma, sign * right, sign * down)[inner], after.luma[inner])
                          for sign in (1, -1)])  # fmt: skip
    forth, back = np.mean(alike, axis=0) if alike else (0.0, 0.0)
    if back > forth + UNLIKE:
        raise ValueError("the background moves against the truth's background_velocity: right and down are positive")


def _shifted(luma: Frames, right: float, down: float) -> Frames:
    return cv2.warpAffine(luma, np.array([[1.0, 0.0, right], [0.0, 1.0, down]]), luma.shape[::-1]).astype(np.uint8)


def _likeness(one: Frames, other: Frames) -> float:
    """Return the size of two pictures' correlation: the contrast of reverse phi turns with each of its steps."""
    blank = min(one.shape) < 2 or not one.std() or not other.std()
    return 0.0 if blank else abs(float(np.corrcoef(one.ravel(), other.ravel())[0, 1]))


def place(entry: StimulusEntry) -> None:
    """Before a background at rest nothing changes outside of the truth's box.

    A clip that has a word for motion without an object moves by itself, as leaves do: it is not asked.
    """
    shown = _frames(entry)
    if any(frame.truth.box is None and frame.truth.motion != "still" for frame in shown):
        return
    for index, pair in enumerate(pairwise(shown)):
        if any(frame.truth.background_velocity != (0.0, 0.0) for frame in pair):
            continue
        changed = np.abs(pair[1].luma.astype(int) - pair[0].luma) > STILL_GREY
        for box in (frame.truth.box for frame in pair if frame.truth.box is not None):
            ends = ((box.top, box.top + box.height), (box.left, box.left + box.width))
            rows, columns = (slice(max(math.floor(a - EDGE_PX), 0), max(math.ceil(b + EDGE_PX), 0)) for a, b in ends)
            changed[rows, columns] = False
        for row, column in np.argwhere(changed)[:1]:
            raise ValueError(f"pixel ({row}, {column}) changes after frame {index}, outside of the truth's box")


def velocity(entry: StimulusEntry) -> None:
    """The box moves by the truth's velocity between two frames that have the same one."""
    fps = entry.clip(SEED).fps
    for index, (before, after) in enumerate(pairwise(frame.truth for frame in _frames(entry))):
        if before.box is None or after.box is None or not before.velocity or before.velocity != after.velocity:
            continue
        moved = (after.box.left + after.box.width / 2 - before.box.left - before.box.width / 2,
                 after.box.top + after.box.height / 2 - before.box.top - before.box.height / 2)  # fmt: skip
        expected = [speed / fps for speed in before.velocity]
        if np.abs(np.subtract(moved, expected)).max() > SLOPPY:
            raise ValueError(f"after frame {index} the box moves by {moved} px, and by its velocity {expected}")


STIMULI = (frames, order, seeds, truth, place, velocity)

# --- arenas: an .xml file, or a .py file with an ``ARENA`` ------------------------------------------------------------

AWAY_CM, ASIDE_DEG = (8.0, 6.0, 10.0, 14.0, 20.0), (0.0, 15.0, -15.0, 28.0, -28.0)
"""Places of the stimulus from the camera at which it is looked for."""
SEEN_GREY, SEEN_PX = 8, 12
"""Grey levels by which so many pixels change where the camera sees the stimulus."""


def room(source: str) -> None:
    """It can be read and compiled, and stands in the room of 45 cm radius, in metres."""
    compile_arena(source)


def robots(source: str) -> None:
    """The observer fits into its middle."""
    with Simulation(scene=SceneConfig(arena=source), robots={"observer": "colias"}, seeing=False) as simulation:
        simulation.reset({}, world(0))


def camera(source: str) -> None:
    """The camera sees a black robot before it."""
    scene = SceneConfig(arena=source, light_sd=0.0, turn_wall=False)

    def look(simulation: Simulation, **placed: Pose) -> npt.NDArray[np.int_]:
        generator = world(0)
        simulation.reset(placed, generator)
        return simulation.step(generator).luma.astype(int)

    with Simulation(scene=scene, robots={"observer": "colias"}) as alone:
        empty = look(alone)
    with Simulation(scene=scene) as simulation:
        for away, aside in product(AWAY_CM, map(math.radians, ASIDE_DEG)):
            x, y = CameraConfig().forward_cm + away * math.cos(aside), away * math.sin(aside)
            try:
                seen = look(simulation, stimulus=Pose(x / 100, y / 100, -math.pi / 2))
            except ValueError:  # an obstacle stands there
                continue
            if (np.abs(seen - empty) >= SEEN_GREY).sum() >= SEEN_PX:
                return
    problem = f"a black robot before the camera changes no picture by {SEEN_GREY} grey levels"
    raise ValueError(f"{problem} (mean {empty.mean():.0f}): give it light, and clear the middle")


ARENAS = (room, robots, camera)
