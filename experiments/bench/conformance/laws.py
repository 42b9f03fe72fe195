"""The laws that every vision model keeps, tried on one model: what `colias check` asks.

The registered models are held to more, by `tests/dsnn/test_models.py`. These are what trials, clips and envs take for
granted of any model, and what goes wrong without a message where it is broken.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from dsnn import AnswerError, Response, ResponseSeries, checked_answer
from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.streams import stream
from experiments.bench.run.user_code import of_users, traced

T = TypeVar("T")
Frames = npt.NDArray[np.uint8]
SHAPE, LARGER = (72, 99), (180, 320)
REST: Mapping[str, float] = MappingProxyType({"hs": 0.0, "vs": 0.0, "looming": 0.5})
"""Largest size of each potential while nothing moves."""
NEGLIGIBLE = 1e-6
LEAST_SHARE = 0.5
"""Share, of the stronger of two answers to mirror images, that the weaker one has to reach."""
ALIKE = 0.02
"""Largest difference of two looming potentials to mirror images."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Result of a law for a model or a stimulus: ``trouble`` says what is broken and how to mend it; empty if kept."""

    law: str
    asks: str
    trouble: str


def check(chosen: ConfiguredModel) -> list[Finding]:
    """Try every law on a model. Whatever goes wrong in the model breaks the law that was tried."""
    return [Finding(law, asks, tried(question, chosen)) for law, (asks, question) in LAWS.items()]


def tried(question: Callable[[T], str], chosen: T) -> str:
    """Return what a question says is broken; whatever goes wrong in a user's own code breaks the law."""
    try:
        return question(chosen)
    except Exception as error:
        return str(error) if isinstance(error, AnswerError) and of_users(error) is None else traced(error)


@cache
def crossing(shape: tuple[int, int] = SHAPE) -> Frames:
    """Return a dark square that goes right and, shifted by hand, a little down, (T, R, C)."""
    rows, columns = shape
    clip = stimulus(
        "plain", rows=rows, columns=columns, width=columns / 4, height=rows / 3, speed=columns, rest_s=0.1, enters=False
    )
    return np.stack([np.roll(frame.luma, i // 2, axis=0) for i, frame in enumerate(clip)])


@cache
def approach() -> Frames:
    """Return a dark square that looms off the middle, (T, R, C)."""
    clip = stimulus("looming", l_over_v_s=0.08, azimuth_deg=5.0, elevation_deg=-3.0)
    return np.stack([frame.luma for frame in clip])


def _model(chosen: ConfiguredModel, shape: tuple[int, int] = SHAPE) -> Any:
    return chosen.build(shape)


def _step(model: Any, frame: Frames, index: int, channels: Sequence[str]) -> Response:
    answer = model.step(frame)
    try:
        return checked_answer(answer, channels)
    except AnswerError as error:
        raise AnswerError(f"in frame {index}, {error}") from None


def _run(model: Any, frames: Frames, channels: Sequence[str]) -> ResponseSeries:
    """Return the answers to frames (T, R, C) that the model cannot change, from its present state on."""
    return ResponseSeries.from_responses(
        _step(model, frozen(frame), index, channels) for index, frame in enumerate(frames)
    )


def _differing(first: ResponseSeries, second: ResponseSeries, channels: Sequence[str]) -> str:
    """Return the first frame in which two series are not the same, in words; empty where they are."""
    for channel in channels:
        one, other = getattr(first, channel), getattr(second, channel)
        places = np.flatnonzero(one != other)
        if places.size:
            at = int(places[0])
            return f"in frame {at} {channel} is {other[at]:z.3g}, and it was {one[at]:z.3g}"
    return ""


def _answers(chosen: ConfiguredModel) -> str:
    for frames in (crossing(), approach(), crossing(LARGER)[:10]):
        series = _run(_model(chosen, frames.shape[1:]), frames, chosen.channels)
        if "looming" in chosen.channels and not (
            series.looming.min() >= REST["looming"] and series.looming.max() <= 1.0
        ):
            low, high = series.looming.min(), series.looming.max()
            return f"looming goes from {low:.3g} to {high:.3g}: legal is from 0.5, at rest, up to 1"
    return ""


def _reset(chosen: ConfiguredModel) -> str:
    model = _model(chosen)
    first = _run(model, crossing(), chosen.channels)
    model.reset()
    difference = _differing(first, _run(model, crossing(), chosen.channels), chosen.channels)
    return f"{difference} before reset(): reset() has to forget every frame" if difference else ""


def _determinism(chosen: ConfiguredModel) -> str:
    first, second = (_run(_model(chosen), crossing(), chosen.channels) for _ in range(2))
    difference = _differing(first, second, chosen.channels)
    return (
        f"{difference} in another model built alike: draws need a seed of their own, a parameter" if difference else ""
    )


def _buffer(chosen: ConfiguredModel) -> str:
    clean, model, buffer = _run(_model(chosen), crossing(), chosen.channels), _model(chosen), np.zeros(SHAPE, np.uint8)
    answers = []
    for index, frame in enumerate(crossing()):
        buffer[:] = frame
        answers.append(_step(model, buffer, index, chosen.channels))
        buffer[:] = 0
    difference = _differing(clean, ResponseSeries.from_responses(answers), chosen.channels)
    return (
        f"{difference} before, once the caller reuses its frame: keep a copy, frame.astype(float)" if difference else ""
    )


def _stillness(chosen: ConfiguredModel) -> str:
    frame = stream("conformance.frame", 0).integers(0, 256, SHAPE, np.uint8)
    series = _run(_model(chosen), np.repeat(frame[None], 6, axis=0), chosen.channels)
    for channel in (channel_of_rest for channel_of_rest in REST if channel_of_rest in chosen.channels):
        potential, spikes = getattr(series, channel), getattr(series, f"{channel}_spikes")
        off = np.flatnonzero((np.abs(potential - REST[channel]) > NEGLIGIBLE) | (spikes != 0))
        if off.size:
            at = int(off[0])
            problem = f"{channel} is {potential[at]:.3g} with {spikes[at]} spikes in frame {at} of a still scene"
            return f"{problem}: expected {REST[channel]:g} and none"
    return ""


def _mirror(chosen: ConfiguredModel) -> str:
    for channel, axis in (("hs", 2), ("vs", 1)):
        if channel not in chosen.channels:
            continue
        # The clip for VS is the same one on its side: its main motion is downward.
        clip = crossing() if channel == "hs" else crossing(SHAPE[::-1]).transpose(0, 2, 1)
        there, back = (
            _mean(_run(_model(chosen), frames, chosen.channels), channel) for frames in (clip, _turned(clip, axis))
        )
        if max(abs(there), abs(back)) > NEGLIGIBLE and (
            there * back >= 0 or min(abs(there), abs(back)) < LEAST_SHARE * max(abs(there), abs(back))
        ):
            problem = f"the mean {channel} is {there:.3g} for a crossing and {back:.3g} for its mirror image"
            return f"{problem}: expected the other sign, at least half as strong"
    if "looming" in chosen.channels:
        one, other = (
            _run(_model(chosen), frames, chosen.channels).looming for frames in (approach(), _turned(approach(), 2))
        )
        if (apart_by := float(np.abs(one - other).max())) > ALIKE:
            return f"looming differs by {apart_by:.3g} between an approach and its mirror image: expected none"
    return ""


def _turned(frames: Frames, axis: int) -> Frames:
    return np.ascontiguousarray(np.flip(frames, axis))


def _mean(series: ResponseSeries, channel: str) -> float:
    """Over the clip: of a potential that saturates, the strongest moment would be any."""
    return float(getattr(series, channel).mean())


def _refusal(chosen: ConfiguredModel) -> str:
    model, wrong = _model(chosen), np.zeros((SHAPE[0], SHAPE[1] - 1), np.uint8)
    try:
        for _ in range(2):  # some compare a frame with the last
            model.step(wrong)
    except Exception:
        return ""
    problem = f"frames of {wrong.shape} are answered by a model built for {SHAPE}"
    return f"{problem}: take frames through dsnn.frames.luma(frame, shape), which refuses them"


LAWS: Mapping[str, tuple[str, Callable[[ConfiguredModel], str]]] = MappingProxyType(
    {
        "answers": ("every frame, of 99x72 and 320x180, gets a legal answer", _answers),
        "reset": ("after reset() the same frames get the same answers", _reset),
        "determinism": ("two models built alike answer alike", _determinism),
        "buffer": ("the caller may reuse the array of a frame", _buffer),
        "stillness": ("a still scene is silent", _stillness),
        "mirror": ("a mirror image turns the sign of hs and vs, and leaves looming", _mirror),
        "refusal": ("frames of another shape are refused", _refusal),
    }
)
"""Name -> what it asks in words, and what tries it and says what is broken."""
