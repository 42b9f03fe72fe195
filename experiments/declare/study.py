"""Declared sweeps and fits: claims and measures over a grid with names, or over a box, in a file of their own."""

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from experiments.base.errors import UsageError, check_name
from experiments.base.values import key_texts
from experiments.declare.claim import Claim
from experiments.declare.clip import OfflineExperiment
from experiments.declare.experiment import Experiment

Levels = Mapping[str, tuple[str, ...]]
"""Name of a level -> the ``KEY=VALUE`` texts that make it. A key that an experiment or a model lacks is ignored."""
TOGETHER = "all"
"""Id of all claims of a grid, or a fit, together, where there are several."""
WHOLE = 10
"""Trials of each condition in a whole replicate, as in the paper."""


@dataclass(frozen=True, slots=True)
class Study:
    """A sweep that is written down: claims and measures at every point of a grid, in replicates.

    A study that ships is a file of `experiments.paper.studies` that defines ``STUDY``; a user's own file does the same.

    Parameters
    ----------
    name
        Letters, digits, ``-`` and ``_``: its files are called so.
    summary
        A line for ``colias list`` and the report.
    claims
        Ids of claims, or claims. Without claims and measures: all that the experiments declare about a model of
        ``models``, and without those the mean number of spikes in each condition.
    measures
        Names of `experiments.judge.sweep.MEASURES`.
    experiments
        Names, files or experiments as they are, of one kind; a claim is judged on the first that declares it. Without:
        for each claim the paper's experiment that answers for it.
    axes
        Name of an axis -> its levels, each with the ``KEY=VALUE`` texts that make it.
    over
        Further axes, as ``KEY=V1,V2`` texts.
    models
        The models judged, one by one, at every point; as ``--model`` takes them. Empty: each claim is judged on the
        models that it is about, which see the same trials.
    assignments
        ``KEY=VALUE`` texts that hold at every point.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number. Clips have none.
    replicates
        Number of replicates; replicate k has the seed of the sweep plus k.
    file
        The .py file that declares it, which ``colias sweep`` fills in.

    Raises
    ------
    UsageError
        The name is invalid, or a text stands where several belong.

    Examples
    --------
    >>> from experiments import Study
    >>> light = {"as it is": (), "dim": ("scene.light=0.7",)}
    >>> Study("dim", "C13 and C14 in less light", claims=("C13", "C14"), axes={"light": light}, replicates=5).models
    ('dsnn',)
    """

    name: str
    summary: str
    claims: tuple[str | Claim, ...] = ()
    measures: tuple[str, ...] = ()
    experiments: tuple[str | Experiment | OfflineExperiment, ...] = ()
    axes: Mapping[str, Levels] = field(default_factory=dict)
    over: tuple[str, ...] = ()
    models: tuple[str, ...] = ("dsnn",)
    assignments: tuple[str, ...] = ()
    repeats: int | None = WHOLE
    replicates: int = 20
    file: str = field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_name("study", self.name)
        make_tuples(self, f"study {self.name}", ("claims", "measures", "experiments", "over", "models", "assignments"))
        where, axes = f"study {self.name}: a level", self.axes.items()
        made = {axis: {name: tuple_of(level, where) for name, level in levels.items()} for axis, levels in axes}
        object.__setattr__(self, "axes", made)


@dataclass(frozen=True, slots=True)
class Fit:
    """A search for the parameters under which all claims of a study hold.

    Parameters
    ----------
    study
        Claims, experiments, one model, what holds at every point, and the replicates that each setting is searched by.
        It has neither axes nor measures.
    over
        The box: ``KEY=A..B`` or ``KEY=V1,V2`` texts, one for each parameter, or for several of one value with ``+``
        between their keys. A range of positive numbers whose ends are 100 times apart is searched by its logarithm.
    trials
        Settings that are searched, rounded up to whole batches of twice ``share``.
    share
        Settings of the network that are shown the frames of one rendering.
    sample
        Settings of the space-filling sample, each with a rendering of its own.
    held_out
        Replicates in which the winner and the ten next best are judged anew.
    search_repeats
        Trials of each condition in a replicate of search and sample; ``None``: those of the study, which the judging
        anew always has. Fewer make a search quicker, and its slack rougher.

    Raises
    ------
    UsageError
        The study has axes, measures or several models.

    Examples
    --------
    >>> from experiments import Fit, Study
    >>> speed = Study("threshold", "C15 at some threshold", claims=("C15",), replicates=1)
    >>> Fit(speed, over=("dsnn.t_sp=0.05..0.3",), trials=60).sample
    64
    """

    study: Study
    over: tuple[str, ...]
    trials: int = 400
    share: int = 10
    sample: int = 64
    held_out: int = 20
    search_repeats: int | None = None

    def __post_init__(self) -> None:
        make_tuples(self, f"fit {self.study.name}", ("over",))
        study = self.study
        if study.axes or study.over or study.measures or len(study.models) != 1:
            raise UsageError(f"fit {study.name}: its study must have one model, and neither axes nor measures")


def make_tuples(declaration: object, where: str, fields: Iterable[str]) -> None:
    """Make tuples of what some fields of a frozen declaration have: see `tuple_of`."""
    for name in fields:
        object.__setattr__(declaration, name, tuple_of(getattr(declaration, name), f"{where}: {name}"))


def tuple_of(values: Iterable[Any], what: str) -> tuple[Any, ...]:
    """Return values as a tuple, settings as ``KEY=VALUE`` texts, and paths as texts; `UsageError` for one text."""
    if isinstance(values, str):
        raise UsageError(f"{what} must be a tuple, got {values!r}; a comma makes one: ({values!r},)")
    values = key_texts(values) if isinstance(values, Mapping) else values
    return tuple(os.fspath(value) if isinstance(value, os.PathLike) else value for value in values)
