"""Controls: the frames of a trial, shown to its models again in ways that leave no motion, or another one.

``frozen`` is the first frame throughout, ``mirrored`` left to right (top to bottom where the motion is vertical),
``reversed`` last frame first, and ``shuffled`` an order that is drawn from the trial's seed. ``absent`` is drawn once
more: what moves by itself is taken away, and a background stands still.

A sample of a control has the time at which its model sees it, and the truth of the frame in the trial that it shows.
"""

import copy
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import polars as pl

from colias_sim.events import Events, joined, replayed
from dsnn.frames import frozen
from experiments.base.streams import stream
from experiments.settings.models import CONTROLS, ConfiguredModel
from experiments.show.play import Sample, Source, most_common

VERTICAL = ("downward", "upward")


class Replay:
    """The samples of a source in another order, or mirrored: see `Source`."""

    def __init__(self, source: Source, samples: Sequence[Sample], control: str, seed: int) -> None:
        self._source = copy.copy(source)  # what it measures it may remember
        self._samples, self._control, self._seed = samples, control, seed
        self.fps, self.shape, self.frame_columns = source.fps, source.shape, source.frame_columns
        self.columns, self.absent = source.columns, source.absent

    def _order(self) -> Sequence[int]:
        count = len(self._samples)
        if self._control == "shuffled":
            return list(map(int, stream("trial.shuffled", self._seed).permutation(count)))
        return {"frozen": [0] * count, "reversed": range(count - 1, -1, -1)}.get(self._control, range(count))

    def __iter__(self) -> Iterator[Sample]:
        axis = 0 if most_common(sample.truth.get("motion") for sample in self._samples) in VERTICAL else 1
        for now, place in zip(self._samples, self._order(), strict=True):
            seen = self._samples[place]
            image = frozen(np.flip(seen.image, axis).copy()) if self._control == "mirrored" else seen.image
            truth = {**seen.truth, **({"time_s": now.time_s} if "time_s" in seen.truth else {})}
            yield Sample(now.time_s, image, truth, since=seen.since, events=self._events(now, place, axis))

    def _events(self, now: Sample, place: int, axis: int) -> Events | None:
        """Return the events of the sample at a place, as the control has them now."""
        backwards, here = self._control == "reversed", self._samples[place]
        at = place + backwards  # backwards, from the sample after it to this one
        if here.events is None:
            return None
        events = joined(seen.events for seen in self._samples[at : at + (self._control != "frozen")])
        events = replayed(events, here.time_s, now.time_s, backwards=backwards)
        if self._control == "mirrored":
            events["yx"[axis]] = self.shape[axis] - 1 - events["yx"[axis]]
        return events

    def measures(self, model: ConfiguredModel, frames: pl.DataFrame) -> dict[str, Any]:
        """Measure the responses to what was seen, as the source would."""
        return self._source.measures(model, frames)


def controls(source: Source, samples: Sequence[Sample], seed: int) -> Iterator[tuple[str, Source]]:
    """Yield the controls of a source whose samples were all shown, by name; of a film there is none without motion.

    Parameters
    ----------
    source, samples
        What was shown.
    seed
        Of the order of ``shuffled``.
    """
    for name in CONTROLS:
        if name == "absent":
            with source.absent() as without:
                if without is not None:
                    yield name, without
        else:
            yield name, Replay(source, samples, name, seed)
