"""Show a stimulus to models, and keep what they saw and answered."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from dsnn import ResponseSeries
from dsnn.stimuli import ClipParams, Stimulus, Truth
from experiments.bench.models import Chosen


@dataclass(frozen=True, slots=True)
class Answer:
    """What one model made of the clip."""

    model: str
    threshold: float | None
    series: ResponseSeries


@dataclass(frozen=True, slots=True)
class Played:
    """A clip that was shown: its T frames, (T, R, C) uint8, the truth about each, and every model's answer."""

    name: str
    settings: dict[str, Any]
    """What made the clip: name -> value."""
    frames: npt.NDArray[np.uint8]
    truths: tuple[Truth, ...]
    times_s: npt.NDArray[np.float64]
    answers: tuple[Answer, ...]


def play(
    name: str, clip: Stimulus[ClipParams], models: Sequence[Chosen], advance: Callable[[], None] = lambda: None
) -> Played:
    """Show ``clip`` to every model, frame by frame; ``advance`` is called after each."""
    built = [model.build(clip.shape) for model in models]
    frames = np.empty((len(clip), *clip.shape), np.uint8)
    truths: list[Truth] = []
    responses = []
    for image, frame in zip(frames, clip, strict=True):
        image[:] = frame.luma
        truths.append(frame.truth)
        responses.append([model.step(frame.luma) for model in built])
        advance()
    series = (ResponseSeries.from_responses(column) for column in zip(*responses, strict=True))
    return Played(
        name,
        {**dataclasses.asdict(clip.params), "seed": clip.seed},
        frames,
        tuple(truths),
        np.arange(len(clip)) / clip.fps,
        tuple(Answer(m.label, m.threshold, s) for m, s in zip(models, series, strict=True)),
    )
