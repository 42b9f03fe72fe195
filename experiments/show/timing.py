"""Time that models take for a frame, side by side in one process."""

from __future__ import annotations

from collections.abc import Sequence

from dsnn.frames import frozen
from dsnn.stimuli import stimulus
from experiments.settings.models import ConfiguredModel
from experiments.show.play import ModelRunner, one_thread

ROUNDS, BLOCK = 40, 4
"""Times that each model is timed, and frames in each time."""


def time_models(models: Sequence[ConfiguredModel], shape: tuple[int, int]) -> dict[str, list[float]]:
    """Time models side by side: in one process, on one thread, in turns, so that a slow moment hits all of a round.

    Parameters
    ----------
    models
        The models. One that raises is left out.
    shape
        Shape of the frames, (R, C).

    Returns
    -------
    dict
        Model -> microseconds per frame, a mean of `BLOCK` frames for each of `ROUNDS` rounds, after one to warm up.
    """
    rows, columns = shape
    clip = stimulus("cluttered", 0, rows=rows, columns=columns, width=columns / 6, height=rows / 2, speed=columns / 2)
    frames = [frozen(clip[index].luma) for index in range(min(len(clip), 60))]
    runners = [ModelRunner(model, shape, keep=False) for model in models]
    taken: dict[str, list[float]] = {runner.label: [] for runner in runners}
    with one_thread():
        for number in range(ROUNDS + 1):
            block = [frames[(number * BLOCK + i) % len(frames)] for i in range(BLOCK)]
            for runner in runners:
                before = runner.seconds
                for frame in block:
                    runner.see(frame)
                taken[runner.label].append((runner.seconds - before) / BLOCK * 1e6)
    return {runner.label: taken[runner.label][1:] for runner in runners if not runner.trouble}
