"""Declaration of a study: the axes of a grid, models, claims and measures, and how many replicates."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from experiments.bench.run.errors import UsageError, check_name, of_one
from experiments.bench.stats.claim import Claim

if TYPE_CHECKING:
    import polars as pl

    from experiments.bench.sources.robot import RobotTrial
    from experiments.bench.store.rows import TrialRecord

WHOLE = 10
"""Trials of each condition in a whole replicate, as in the paper."""


@dataclass(frozen=True, slots=True)
class Level:
    """One value of an axis.

    Parameters
    ----------
    label
        What tables and figure call it.
    settings
        The ``KEY=VALUE`` texts that make it. Those whose key an experiment or a model lacks are left out there.
    models
        The study's models that are shown there; empty: all of them.
    plays
        Name of a model that claims know -> the label, in the trials, of the model that stands for it there.

    Raises
    ------
    UsageError
        ``settings`` or ``models`` is a text, not a tuple.
    """

    label: str
    settings: tuple[str, ...] = ()
    models: tuple[str, ...] = ()
    plays: Mapping[str, str] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        make_tuples(self, f"level {self.label}", ("settings", "models"))


def keys_of(name: str) -> tuple[str, ...]:
    """Return the keys of the parameters that have one value, from the text before it: ``KEY`` or ``KEY+KEY``.

    Raises
    ------
    UsageError
        A key is missing beside a ``+``.
    """
    keys = tuple(name.split("+"))
    if len(keys) > 1 and "" in keys:
        raise UsageError(f"--over {name}: a parameter is missing beside '+'; expected KEY+KEY=VALUES")
    return keys


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a study.

    Parameters
    ----------
    name
        What it is called. Of an axis of parameters: one key, or several joined by ``+``, which move together.
    levels
        Its values; those of parameters ascend if all are numbers.
    default
        The value that holds without it; ``None`` where there is no single one.
    unit
        Unit of the values; empty where none is known.
    of_keys
        Whether its levels are values of the parameters that its name names.
    """

    name: str
    levels: tuple[Level, ...]
    default: float | str | None = None
    unit: str = ""
    of_keys: bool = False

    @property
    def labels(self) -> tuple[str, ...]:
        """The labels of its levels."""
        return tuple(level.label for level in self.levels)

    @property
    def keys(self) -> tuple[str, ...]:
        """The parameters that it moves, with their ends: ``dsnn.tau_s.first``; none where its levels are named."""
        return keys_of(self.name) if self.of_keys else ()

    def level(self, label: str) -> Level:
        """Return the level of a label.

        Parameters
        ----------
        label
            One of `labels`.

        Returns
        -------
        Level
            The level that tables and figure call so.
        """
        return next(level for level in self.levels if level.label == label)

    def values(self) -> tuple[float | str, ...]:
        """Return the values of all levels, in their order.

        Returns
        -------
        tuple of float or str
            The labels as numbers if all of them are finite ones, otherwise the labels.
        """
        try:
            numbers = tuple(float(label) for label in self.labels)
        except ValueError:
            return self.labels
        return numbers if all(map(math.isfinite, numbers)) else self.labels

    def value(self, label: str) -> float | str:
        """Return the value of one level.

        Parameters
        ----------
        label
            One of `labels`.

        Returns
        -------
        float or str
            The label as a number if the labels of all levels are finite ones, otherwise the label.
        """
        return self.values()[self.labels.index(label)]

    def words(self) -> list[str]:
        """Return the axis in words, in parts between which a line of a figure may break.

        Returns
        -------
        list of str
            Its keys or its name, then its unit and the default if there are any.
        """
        keys = self.keys or (self.name,)
        default = "" if self.default is None else f"default {value_text(self.default)}"
        more = ", ".join(filter(None, (self.unit, default)))
        return [*(f"{key} +" for key in keys[:-1]), keys[-1], *([f"({more})"] if more else [])]


def value_text(value: float | str) -> str:
    """Return a value of an axis in words."""
    return f"{value:g}" if isinstance(value, float) else value


@dataclass(frozen=True, slots=True)
class Probe:
    """A job that keeps further columns of a study's trials with the robot, beside those of their rows.

    Parameters
    ----------
    work
        A job's pure function, in place of `experiments.bench.trials.work`.
    schema
        Makes the schema of its rows. It is a function, as a declaration loads no tables.
    """

    work: Callable[[RobotTrial], TrialRecord]
    schema: Callable[[], pl.Schema]


Tables = Mapping[str, list[dict[str, Any]]]
"""Title of a table -> its rows."""


@dataclass(frozen=True, slots=True)
class Study:
    """Claims and measures, counted at every point of a grid, for every model, in whole replicates.

    A study that ships is a file of `experiments.studies` that defines ``STUDY``; a user's own file does the same.

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
        Names of `experiments.bench.studies.measures.MEASURES`.
    experiments
        Names or files, of one kind; the claims are judged on the first that declares them. Without: for each claim the
        paper's experiment that answers for it.
    axes
        Axes with levels of their own.
    over
        Further axes, as ``KEY=V1,V2`` texts.
    models
        The models judged, one by one, at every point; as ``--model`` takes them. Empty: each claim is judged on the
        models that it is about, which see the same trials. Where a study is ``as_run`` the first is judged, and the
        others are shown beside those of the experiment, for its ``tables``.
    assignments
        ``KEY=VALUE`` texts that hold at every point.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number. Clips have none.
    replicates
        Number of replicates, each with a seed of its own.
    every_trial
        Whether whole experiments are run, or just the motions that claims and measures read.
    as_run
        Whether the points are read off the trials of an experiment as it stands, its models and clips with it. Their
        levels then choose among these by ``plays`` and by ``claim_at``.
    claim_at
        Makes the claim that is asked at a point, from the claim and the point's labels by axis.
    probe
        What is kept of a trial beside its row.
    tables
        Makes further tables from the study's result: `experiments.bench.studies.counts.Counts`.
    file
        The .py file that declares it, which ``colias study`` fills in.

    Raises
    ------
    UsageError
        The name is not legal, there are no replicates, or something is there twice.

    Examples
    --------
    >>> from experiments import Axis, Level, Study
    >>> light = Axis("light", (Level("as it is"), Level("dim", ("scene.light=0.7",))))
    >>> Study("dim", "C13 and C14 in less light", claims=("C13", "C14"), axes=(light,), replicates=5).models
    ('dsnn',)
    """

    name: str
    summary: str
    claims: tuple[str | Claim, ...] = ()
    measures: tuple[str, ...] = ()
    experiments: tuple[str, ...] = ()
    axes: tuple[Axis, ...] = ()
    over: tuple[str, ...] = ()
    models: tuple[str, ...] = ("dsnn",)
    assignments: tuple[str, ...] = ()
    repeats: int | None = WHOLE
    replicates: int = 20
    every_trial: bool = True
    as_run: bool = False
    claim_at: Callable[[Claim, Mapping[str, str]], Claim] | None = None
    probe: Probe | None = None
    tables: Callable[[Any], Tables] | None = None
    file: str = field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_name("study", self.name)
        several = ("claims", "measures", "experiments", "axes", "over", "models", "assignments")
        make_tuples(self, f"study {self.name}", several)
        for what, legal in (("replicates", ""), ("repeats", ", or None: the experiment's own number")):
            number = getattr(self, what)
            if not isinstance(number, int) and not (number is None and legal):
                raise UsageError(f"study {self.name}: {what}={number!r}: legal is a whole number{legal}")
        for axis in self.axes:
            if not isinstance(axis, Axis) or not axis.levels:
                raise UsageError(f"study {self.name}: axes: {axis!r}: legal is an experiments.Axis with levels")
            if len(set(axis.labels)) < len(axis.labels):
                raise UsageError(f"study {self.name}: axis {axis.name}: a level is there twice")


def make_tuples(declared: object, where: str, fields: Iterable[str]) -> None:
    """Make tuples of the sequences in some fields of a frozen declaration.

    Parameters
    ----------
    declared
        A level, a study or a fit that is being made.
    where
        What a refusal begins with.
    fields
        Names of the fields.

    Raises
    ------
    UsageError
        One of them is a text, which would become its letters.
    """
    for what in fields:
        values = getattr(declared, what)
        if isinstance(values, str):
            raise UsageError(f"{where}: {what}={values!r}: legal is a tuple{of_one(values)}")
        object.__setattr__(declared, what, tuple(values))
