"""Show a stimulus to models, and keep what they saw and answered."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from dsnn import ResponseSeries
from dsnn.frames import frozen
from dsnn.stimuli import ClipParams, Stimulus, Truth
from experiments.bench.run.errors import TrialError
from experiments.bench.run.model_runner import ModelRunner
from experiments.bench.run.models import ConfiguredModel


@dataclass(frozen=True, slots=True)
class ClipAnswer:
    """Answers of one model to a clip."""

    model: str
    channels: tuple[str, ...]
    """Channels that the model declares."""
    thresholds: Mapping[str, float | None]
    """Channel -> its spiking threshold."""
    series: ResponseSeries

    @classmethod
    def of(cls, model: ConfiguredModel, series: ResponseSeries) -> ClipAnswer:
        """The answer of a model."""
        return cls(model.label, model.channels, model.thresholds, series)


@dataclass(frozen=True, slots=True)
class Played:
    """A clip that was shown: its T frames, (T, R, C) uint8, the truth about each, and every model's answer."""

    name: str
    params: ClipParams
    seed: int
    """Of the clip, as its parameters are."""
    frames: npt.NDArray[np.uint8]
    truths: tuple[Truth, ...]
    times_s: npt.NDArray[np.float64]
    answers: tuple[ClipAnswer, ...]
    troubles: Mapping[str, str] = field(default_factory=dict)
    """Model -> what went wrong in it; it is not among the answers."""


def play(
    name: str, clip: Stimulus[ClipParams], models: Sequence[ConfiguredModel], advance: Callable[[], None] = lambda: None
) -> Played:
    """Show ``clip`` to every model, frame by frame; ``advance`` is called after each.

    A model that goes wrong loses its own part; `TrialError` says why if all do.
    """
    runners = [ModelRunner(model, clip.shape) for model in models]
    frames = np.empty((len(clip), *clip.shape), np.uint8)
    truths: list[Truth] = []
    for image, frame in zip(frames, clip, strict=True):
        image[:] = frame.luma
        truths.append(frame.truth)
        luma = frozen(image)
        for runner in runners:
            runner.see(luma)
        advance()
    troubles = {runner.label: runner.trouble for runner in runners if runner.trouble}
    answers = tuple(ClipAnswer.of(r.chosen, series) for r in runners if (series := r.series()) is not None)
    if not answers:
        raise TrialError("\n".join(f"{label}: {trouble}" for label, trouble in troubles.items()))
    return Played(
        name,
        clip.params,
        clip.seed,
        frames,
        tuple(truths),
        np.arange(len(clip)) / clip.fps,
        answers,
        troubles,
    )
