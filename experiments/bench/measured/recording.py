"""A Rerun recording of a real robot's trial: its frames where they are there, and what models answered."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import partial

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from experiments.bench.measured.log import LoggedTrial
from experiments.bench.measured.rows import Given
from experiments.bench.recording import Images, lanes, page, potentials, recorded, timelines, video


def record(experiment: str, trial: LoggedTrial, answers: Sequence[Given], frames: Images | None) -> bytes:
    """Record a trial.

    Parameters
    ----------
    experiment
        Name of the experiment.
    trial
        The trial.
    answers
        What models answered, at least one.
    frames
        What the robot's camera saw, (T, R, C), if it is known.

    Returns
    -------
    bytes
        Of an .rrd file.
    """
    name = f"{trial.index:04d} {trial.condition.label()}, {answers[0].provenance}"
    digest = hashlib.blake2s(
        b"".join(answer.series.hs.tobytes() for answer in answers) + trial.time_s.tobytes(), digest_size=6
    )
    identity = f"{experiment}-measured-{trial.index:04d}-{digest.hexdigest()}"
    write = partial(_write, experiment, trial, answers, frames)
    return recorded(write, _blueprint(answers, frames is not None), name, identity)


def _write(
    experiment: str, trial: LoggedTrial, answers: Sequence[Given], frames: Images | None, recording: rr.RecordingStream
) -> None:
    condition = {name: value for name, value in trial.condition.columns().items() if value is not None}
    values = {"experiment": experiment, "trial": trial.index, "provenance": answers[0].provenance, **condition}
    recording.send_property("trial", rr.AnyValues(**values))
    if frames is not None:
        video(recording, "camera", frames, timelines(trial.time_s, np.arange(len(trial.time_s))))
    potentials(recording, answers, trial.time_s)


def _blueprint(answers: Sequence[Given], pictured: bool) -> rrb.Blueprint:
    views = [rrb.Spatial2DView(origin="camera", name="camera of the robot (Y, 8 bit)")] if pictured else []
    return page(*views, lanes(answers), shares=[3, 2] if pictured else [1])
