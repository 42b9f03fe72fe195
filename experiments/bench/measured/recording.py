"""A Rerun recording of a real robot's trial: its frames where they are there, and what models responded."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

import numpy as np

from experiments.bench.measured.log import LoggedTrial
from experiments.bench.measured.rows import Given
from experiments.bench.run import record as rerun
from experiments.bench.run.record import Content, Frames, Images, Model


def record(experiment: str, trial: LoggedTrial, answers: Sequence[Given], frames: Images | None) -> bytes:
    """Record a trial.

    Parameters
    ----------
    experiment
        Name of the experiment.
    trial
        The trial.
    answers
        What models responded, at least one.
    frames
        What the robot's camera saw, (T, R, C), if it is known.

    Returns
    -------
    bytes
        Of an .rrd file.
    """
    models = tuple(Model(one.model, one.channels, tuple(one.thresholds.items())) for one in answers)
    seen = {} if frames is None else {"": frames}
    shown = Frames(trial.time_s, np.arange(len(trial.time_s)), {one.model: one.series for one in answers}, seen)
    provenance = answers[0].provenance
    properties = {
        "experiment": experiment, "trial": trial.index, "provenance": provenance, **trial.condition.columns(),
    }  # fmt: skip
    digest = hashlib.blake2s(b"".join(one.series.hs.tobytes() for one in answers), digest_size=6)
    digest.update(trial.time_s.tobytes())
    return rerun.write(
        Content(models, tuple(seen)), shown, f"{trial.index:04d} {trial.condition.label()}, {provenance}",
        f"{experiment}-measured-{trial.index:04d}-{digest.hexdigest()}", {"trial": rerun.known(properties)},
    )  # fmt: skip
