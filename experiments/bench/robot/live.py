"""A trial streamed to Rerun's viewer while it runs: ``colias run --live``.

It reads what the trial has computed, and changes none of it. The viewer may be closed at any time: the trial goes on.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
import rerun as rr

from dsnn import ResponseSeries
from experiments.bench import viewer
from experiments.bench.recording import (
    APPLICATION,
    Model,
    describe_answers,
    described,
    send_answers,
    send_layout,
    send_thresholds,
)
from experiments.bench.robot import recording
from experiments.bench.sources.experiment import TrialSpec
from experiments.bench.sources.media import Media, collect
from experiments.bench.sources.robot import RunningTrial, columns_of

EVERY_S = 0.1
"""Seconds between two parts of a trial that are sent."""
FLUSH_S = 5.0
"""How long the viewer may take to receive the end of a trial."""

_LAID_OUT: set[str] = set()
"""Addresses of the viewers that this process has sent a layout to."""


class LiveTrial:
    """The stream of one trial, a recording of its own in the viewer: the frames of its first eye, and what the models
    that see through it answer.

    Parameters
    ----------
    spec
        The trial.
    address
        Where the viewer listens, HOST:PORT.
    """

    def __init__(self, spec: TrialSpec, address: str) -> None:
        self._spec, self._address = spec, address
        self._stream: rr.RecordingStream | None = None
        self._eye: str | None = None
        self._sent, self._sent_at = 0, time.monotonic()
        self._gone = not viewer.listens(address)

    def see(self, eye: str, trial: RunningTrial) -> None:
        """Take a trial after each of its frames, and send what is new at times."""
        if self._eye is None:
            self._eye = eye
        over = trial.drive.over
        if self._gone or eye != self._eye or not (over or time.monotonic() - self._sent_at >= EVERY_S):
            return
        try:
            self._send(trial)
        except RuntimeError:  # the viewer was closed meanwhile
            self._gone = True
        self._sent_at = time.monotonic()

    def close(self) -> None:
        """End the stream; what the viewer does not take in time is dropped."""
        stream, self._stream = self._stream, None
        if stream is None:
            return
        try:
            if not self._gone:
                stream.flush(timeout_sec=FLUSH_S)
        except RuntimeError:
            self._gone = True
        finally:
            stream.disconnect()
            rr.init(APPLICATION, init_logging=False)  # or the stream's threads stay: see `recorded`

    def _send(self, trial: RunningTrial) -> None:
        first, end = self._sent, len(trial.frames)
        frames, poses, settings = trial.frames[first:end], trial.poses[first:end], self._spec.settings
        runners = [runner for runner in trial.watching if not runner.trouble]
        answering = described([runner.chosen for runner in runners])
        mapped = [runner for runner in runners if runner.maps]
        eye = self._eye or ""
        media = collect({eye: frames}, mapped[0].responses[first:end] if mapped else [])
        if self._stream is None:
            self._stream = self._begun(media, described([runner.chosen for runner in trial.watching]))
        columns, numbers = columns_of(frames, poses, settings), np.arange(first, end)
        recording.send_frames(self._stream, media, columns, numbers)
        labels = [runner.label for runner in trial.watching]
        for runner, model in zip(runners, answering, strict=True):
            series = ResponseSeries.from_responses(runner.responses[first:end])
            send_answers(self._stream, model, labels, series, columns.sim_time_s, numbers)
        ends = [0, -1]
        send_thresholds(self._stream, answering, columns.sim_time_s[ends], numbers[ends])
        self._sent = end

    def _begun(self, media: Media, answering: Sequence[Model]) -> rr.RecordingStream:
        """Return a new stream to the viewer, with all that stays."""
        stream = rr.RecordingStream(APPLICATION)
        layout, address = recording.layout(media, answering), viewer.url(self._address)
        if self._address not in _LAID_OUT:
            # Before anything else arrives: the viewer would make up a layout of its own, and keep that. A stream of the
            # layout's own stays alive after this, with its threads, so that the process does it once.
            stream.connect_grpc(address, default_blueprint=layout)
            _LAID_OUT.add(self._address)
        else:
            stream.connect_grpc(address)
            send_layout(stream, layout)
        stream.send_recording_name(recording.title(self._spec))
        describe_answers(stream, answering)
        recording.describe_trial(stream, self._spec, media)
        return stream
