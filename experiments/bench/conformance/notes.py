"""Oddities that break no law and are rarely meant: dropped answers, potentials without spikes, spikes without a
threshold.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dsnn.frames import frozen
from dsnn.model import CHANNELS, SPIKING
from experiments.bench.conformance.laws import approach, crossing
from experiments.bench.report.terminal import count
from experiments.bench.run.models import ConfiguredModel
from experiments.bench.run.user_code import is_file


def notes(chosen: ConfiguredModel) -> list[str]:
    """Tell each oddity of a model's answers to a crossing and to an approach; none where it fails to answer."""
    try:
        answers = _answers(chosen)
        return [*_dropped(answers, chosen), *_silent(answers, chosen), *_uncounted(answers, chosen)]
    except Exception:  # the laws say what is wrong
        return []


def _answers(chosen: ConfiguredModel) -> list[Any]:
    """Return the answers as the model gives them, to be looked at before undeclared channels are dropped."""
    responses = []
    for frames in (crossing(), approach()):
        shape = (frames.shape[1], frames.shape[2])
        model: Any = chosen.build(shape)
        responses += [model.step(frozen(frame)) for frame in frames]
    return responses


def _dropped(answers: Sequence[Any], chosen: ConfiguredModel) -> list[str]:
    return [
        f"answers {channel}, which is not declared: it is dropped"
        for channel in CHANNELS
        if channel not in chosen.channels and any(getattr(answer, channel, 0.0) != 0.0 for answer in answers)
    ]


def _uncounted(answers: Sequence[Any], chosen: ConfiguredModel) -> list[str]:
    """Tell spikes of a channel without a threshold: trials and clips take it for one that does not spike."""
    names = "a parameter counts as the threshold that is called t_sp, or that thresholds= of its ModelEntry names"
    return [
        f"{channel}_spikes come, and {channel} has no threshold, so they are not counted: {names}"
        for channel in SPIKING
        if channel in chosen.channels and channel not in chosen.spiking
        and any(getattr(answer, f"{channel}_spikes", 0) for answer in answers)
    ]  # fmt: skip


def _silent(answers: Sequence[Any], chosen: ConfiguredModel) -> list[str]:
    """Note silent channels of a user's own file: of those that ship, the hybrid holds its spikes back on purpose while
    nothing looms.
    """
    silent: list[str] = []
    if not is_file(chosen.source):
        return silent
    names = chosen.declared.thresholds
    for channel, threshold in chosen.thresholds.items():
        if (
            channel not in SPIKING
            or threshold is None
            or any(getattr(answer, f"{channel}_spikes") for answer in answers)
        ):
            continue
        above = sum(abs(getattr(answer, channel)) > threshold for answer in answers)
        if above:
            passes = f"{channel} passes {names.get(channel, 't_sp')} = {threshold:g} in {count(above, 'frame')}"
            silent.append(f"{passes}, and {channel}_spikes stays 0: step itself returns the spikes")
    return silent
