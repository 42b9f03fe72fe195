"""Hold the emulated chip against the host's form of the network, bit for bit, on at least 1,000 frames."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dsnn import Response
from dsnn.onboard.model import OnboardDSNN
from experiments.bench.firmware import clips
from experiments.bench.firmware.budget import Tools
from experiments.bench.firmware.build import build
from experiments.bench.firmware.clips import Frames
from experiments.bench.firmware.emulator import Q15, ChipAnswer, Emulator
from experiments.bench.firmware.settings import Firmware

LENGTH = 90
"""Frames of each synthetic clip."""
LEAST_FRAMES = 1000
CHANNELS = ("hs", "vs", "hs_spikes", "vs_spikes")


@dataclass(frozen=True, slots=True)
class Difference:
    """The first answer that is not equal: clip, frame (from 0), channel, and its two values."""

    clip: str
    frame: int
    channel: str
    host: float
    chip: float

    def words(self) -> str:
        """Tell the result in a line."""
        return (
            f"{self.clip}, frame {self.frame}: {self.channel} is {self.chip:g} on the chip, {self.host:g} on the host"
        )


@dataclass(frozen=True, slots=True)
class Checked:
    """Result of a check.

    Parameters
    ----------
    clips
        Name -> number of frames compared, up to the first difference.
    spiking
        Frames with a spike: equal answers that are all zero would say little.
    large
        Whether the program was too large for the chip, so that a board with more memory ran it.
    difference
        The first one; ``None`` where all answers are equal.
    """

    clips: Mapping[str, int]
    spiking: int
    large: bool
    difference: Difference | None

    @property
    def frames(self) -> int:
        """Frames compared."""
        return sum(self.clips.values())


def sequences(shape: tuple[int, int], trial: Frames | None) -> list[tuple[str, Frames]]:
    """Return what is shown, in order. Each clip begins after a reset, and the first is shown again at the end.

    Where all clips together are shorter than `LEAST_FRAMES`, the synthetic ones are made longer.
    """
    recorded = [*clips.golden(shape).items(), *([] if trial is None else [("a trial's frames", trial)])]
    have = sum(len(frames) for _, frames in recorded)
    short_clips = clips.synthetic(shape, 1)
    length = max(LENGTH, -(-(LEAST_FRAMES - have) // (len(short_clips) + 1)))
    clips_made = clips.synthetic(shape, length)
    again = clips_made["noise"]
    return [*clips_made.items(), *recorded, ("noise again after a reset", again)]


def host(response: Response) -> tuple[int, int, int, int]:
    """Return the host's answer in the chip's units: hs and vs in Q15, and the spikes."""
    return round(response.hs * Q15), round(response.vs * Q15), response.hs_spikes, response.vs_spikes


def compare(
    model: Any, chip: Emulator, clips_shown: Sequence[tuple[str, Frames]], done: Callable[[], None]
) -> tuple[dict[str, int], int, Difference | None]:
    """Show clips to both, each after a reset; frames compared, frames with spikes, the first difference.

    Parameters
    ----------
    model
        The host's form: ``reset`` and ``step``.
    chip
        The emulated chip.
    clips_shown
        Names and frames.
    done
        Called after each clip.
    """
    counts: dict[str, int] = {}
    spiking = 0
    for name, frames in clips_shown:
        model.reset()
        chip.reset()
        counts[name] = 0
        for place, frame in enumerate(frames):
            response, answer = model.step(frame), chip.step(frame)
            counts[name] += 1
            difference = _difference(name, place, response, answer)
            if difference is not None:
                return counts, spiking, difference
            spiking += bool(answer.hs_spikes or answer.vs_spikes)
        done()
    return counts, spiking, None


def _difference(clip: str, place: int, response: Response, answer: ChipAnswer) -> Difference | None:
    for channel, expected, theirs in zip(CHANNELS, host(response), answer.values, strict=True):
        if expected != theirs:
            return Difference(clip, place, channel, expected, theirs)
    return None


def check(
    wanted: Firmware, tools: Tools, clips_shown: Sequence[tuple[str, Frames]], done: Callable[[], None]
) -> Checked:
    """Build the program and hold it against the host's form; errors as `experiments.bench.firmware.budget.measure`."""
    with tempfile.TemporaryDirectory(prefix="colias-firmware-") as folder:
        built = build(wanted, tools.compiler, Path(folder))
        with Emulator(tools.qemu, built.path, wanted.shape) as chip:
            model = OnboardDSNN(wanted.shape, wanted.network)
            counts, spiking, difference = compare(model, chip, clips_shown, done)
    return Checked(counts, spiking, bool(built.over), difference)
