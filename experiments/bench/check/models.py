"""The laws of every vision model: what trials, clips and envs take for granted, and what goes wrong in silence."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import CHANNELS, ResponseError, ResponseSeries, checked_response
from dsnn.model import SPIKING
from dsnn.stimuli import stimulus
from experiments.bench.check.laws import LawBroken
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.streams import stream

Frames = npt.NDArray[np.uint8]
SHAPE, LARGER = (72, 99), (180, 320)
REST = {"hs": 0.0, "vs": 0.0, "looming": 0.5}
"""Largest size of each potential while nothing moves."""
NEGLIGIBLE = 1e-6
LEAST_SHARE = 0.5
"""Share, of the stronger of two answers to mirror images, that the weaker one has to reach."""
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


def answered(model: Any, frames: Iterable[Frames], channels: tuple[str, ...]) -> ResponseSeries:
    """Return a model's answers to frames, from its present state on; `LawBroken` for the first that is not legal."""
    responses = []
    for index, frame in enumerate(frames):
        answer = model.step(frame)
        try:
            responses.append(checked_response(answer, channels))
        except ResponseError as error:
            raise LawBroken(f"in frame {index}, {error}") from error
    return ResponseSeries.from_responses(responses)


def _run(chosen: ConfiguredModel, frames: Frames) -> ResponseSeries:
    return answered(chosen.build(frames.shape[1:]), frames, chosen.channels)


def _demand_equal(now: ResponseSeries, before: ResponseSeries, channels: tuple[str, ...], otherwise: str) -> None:
    """Raise `LawBroken` at the first frame in which two series are not the same."""
    for channel in channels:
        one, other = getattr(before, channel), getattr(now, channel)
        if not np.array_equal(one, other):
            at = int(np.flatnonzero(one != other)[0])
            raise LawBroken(f"in frame {at} {channel} is {other[at]:z.3g}, and it was {one[at]:z.3g} {otherwise}")


def answers(chosen: ConfiguredModel) -> None:
    """Every frame, of 99x72 and 320x180, gets a response in its range."""
    for frames in (crossing(), approach(), crossing(LARGER)[:10]):
        looming = _run(chosen, frames).looming
        low, high = looming.min(), looming.max()
        if "looming" in chosen.channels and not (low >= REST["looming"] and high <= 1.0):
            raise LawBroken(f"looming must be from 0.5, at rest, to 1, and goes from {low:.3g} to {high:.3g}")


def reset(chosen: ConfiguredModel) -> None:
    """After reset() the same frames get the same responses."""
    model = chosen.build(SHAPE)
    first = answered(model, crossing(), chosen.channels)
    model.reset()
    again = answered(model, crossing(), chosen.channels)
    _demand_equal(again, first, chosen.channels, "before reset(): reset() has to forget every frame")


def determinism(chosen: ConfiguredModel) -> None:
    """Two models built alike respond alike."""
    otherwise = "in another model built alike: draws need a seed of their own, a parameter"
    _demand_equal(_run(chosen, crossing()), _run(chosen, crossing()), chosen.channels, otherwise)


def buffer(chosen: ConfiguredModel) -> None:
    """The caller may reuse the array of a frame."""

    def reused() -> Iterator[Frames]:
        frame = np.zeros(SHAPE, np.uint8)
        for shown in crossing():
            frame[:] = shown
            yield frame
            frame[:] = 0

    overwritten = answered(chosen.build(SHAPE), reused(), chosen.channels)
    otherwise = "before, once the caller reuses its frame: keep a copy, frame.astype(float)"
    _demand_equal(overwritten, _run(chosen, crossing()), chosen.channels, otherwise)


def stillness(chosen: ConfiguredModel) -> None:
    """A still scene is silent."""
    frame = stream("conformance.frame", 0).integers(0, 256, SHAPE, np.uint8)
    series = _run(chosen, np.repeat(frame[None], 6, axis=0))
    for channel in SPIKING:
        potential, spikes = getattr(series, channel), getattr(series, f"{channel}_spikes")
        off = np.flatnonzero((np.abs(potential - REST[channel]) > NEGLIGIBLE) | (spikes != 0))
        if channel in chosen.channels and off.size:
            problem = f"{channel} is {potential[off[0]]:.3g} with {spikes[off[0]]} spikes in frame {off[0]}"
            raise LawBroken(f"{problem} of a still scene: expected {REST[channel]:g} and none")


def mirror(chosen: ConfiguredModel) -> None:
    """A mirror image turns the sign of hs and vs, and leaves looming."""
    # The clip for VS is the same one on its side: its main motion is downward.
    for channel, clip, axis in (("hs", crossing(), 2), ("vs", crossing(SHAPE[::-1]).transpose(0, 2, 1), 1)):
        if channel in chosen.channels:
            # Means over the clip: of a potential that saturates, the strongest moment would be any.
            there, back = (getattr(_run(chosen, f), channel).mean() for f in (clip, np.flip(clip, axis).copy()))
            weak, strong = sorted((abs(there), abs(back)))
            if strong > NEGLIGIBLE and (there * back >= 0 or weak < LEAST_SHARE * strong):
                problem = f"the mean {channel} is {there:.3g} for a crossing and {back:.3g} for its mirror image"
                raise LawBroken(f"{problem}: expected the other sign, at least half as strong")
    if "looming" in chosen.channels:
        one, other = (_run(chosen, frames).looming for frames in (approach(), np.flip(approach(), 2).copy()))
        if (apart := np.abs(one - other).max()) > ALIKE:
            raise LawBroken(f"looming differs by {apart:.3g} between an approach and its mirror image: expected none")


def refusal(chosen: ConfiguredModel) -> None:
    """Frames of another shape are rejected."""
    model, wrong = chosen.build(SHAPE), np.zeros((SHAPE[0], SHAPE[1] - 1), np.uint8)
    try:
        for _ in range(2):  # some compare a frame with the last
            model.step(wrong)
    except Exception:
        return
    problem = f"frames of {wrong.shape} are answered by a model built for {SHAPE}"
    raise LawBroken(f"{problem}: take frames through dsnn.frames.luma(frame, shape), which refuses them")


def declaration(chosen: ConfiguredModel) -> None:
    """Channels that respond are declared, and what passes a threshold spikes."""
    runs = [(chosen.build(frames.shape[1:]), frames) for frames in (crossing(), approach())]
    responses = [model.step(frame) for model, frames in runs for frame in frames]

    def largest(name: str) -> float:
        return float(max(abs(getattr(response, name, 0.0)) for response in responses))

    for channel in (channel for channel in CHANNELS if channel not in chosen.channels and largest(channel)):
        raise LawBroken(f"it answers {channel}, which is not declared and is dropped: ModelEntry(..., channels=)")
    fires = {channel: largest(f"{channel}_spikes") > 0 for channel in SPIKING if channel in chosen.channels}
    for channel, spikes in fires.items():
        threshold, name = chosen.thresholds[channel], chosen.declared.thresholds.get(channel, "t_sp")
        if spikes and threshold is None:
            raise LawBroken(f"{channel} spikes without a threshold, t_sp or thresholds= of ModelEntry: not counted")
        if threshold is not None and largest(channel) > threshold and not any(fires.values()):
            problem = f"{channel} passes {name} = {threshold:g}, and {channel}_spikes stays 0"
            raise LawBroken(f"{problem}: step itself returns the spikes")


LAWS = (answers, reset, determinism, buffer, stillness, mirror, refusal, declaration)
