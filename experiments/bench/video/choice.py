"""Choice of the models of a recording that are shown: those that were asked for, or as many as can be told apart."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from experiments.bench.run.errors import UsageError
from experiments.bench.video.reading import Reel
from scenes.hints import nearest

MOST_MODELS = 8
"""In one picture: each has a panel of its own then, and more would be too small to read."""


def with_models(reel: Reel, asked: Sequence[str] = ()) -> Reel:
    """Return a recording with the traces of some of its models.

    Parameters
    ----------
    reel
        The recording.
    asked
        Labels of models. None: all, or the first `MOST_MODELS` where there are more.

    Returns
    -------
    Reel
        The recording, its models in the order asked for. ``hidden`` counts those that were left out unasked.

    Raises
    ------
    UsageError
        The recording has no such model, or more than `MOST_MODELS` are asked for.
    """
    every = reel.models
    for name in asked:
        if name not in every:
            near = nearest(name, every, " (", ")")
            raise UsageError(f"--model {name}: {reel.path} has no such model{near}; there are: {', '.join(every)}")
    chosen = tuple(dict.fromkeys(asked)) or every[:MOST_MODELS]
    if len(chosen) > MOST_MODELS:
        raise UsageError(f"--model: {len(chosen)} models; legal are up to {MOST_MODELS} in one picture")
    if chosen == every:
        return reel
    traces = [trace for name in chosen for trace in reel.traces if trace.model == name]
    levels = tuple(level for level in reel.levels if {*reel.owners.get(level, chosen)} & {*chosen})
    hidden = 0 if asked else len(every) - len(chosen)
    return dataclasses.replace(reel, traces=tuple(traces), levels=levels, hidden=hidden)
