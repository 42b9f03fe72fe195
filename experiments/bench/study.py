"""Declarations of sweeps: levels, axes, and the studies that are written down in files."""

from __future__ import annotations

import dataclasses
import importlib
import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from experiments.bench.run.errors import UsageError, check_name, of_one
from experiments.bench.run.models import beside
from experiments.bench.run.user_code import declared, declares, is_file
from experiments.bench.stats.claim import Claim
from scenes.hints import nearest

WHOLE = 10
"""Trials of each condition in a whole replicate, as in the paper."""


@dataclass(frozen=True, slots=True)
class Level:
    """One value of an axis.

    Parameters
    ----------
    label
        Its name in tables and figures.
    settings
        The ``KEY=VALUE`` texts that make it. Keys that an experiment or a model lacks are ignored there.
    models
        The study's models that are shown at this level; empty: all of them.
    plays
        Name of a model that claims know -> the label, in the trials, of the model that takes its place here.

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


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a sweep.

    Parameters
    ----------
    name
        Its column in tables. An axis of parameters is called by its keys: ``KEY`` or ``KEY+KEY``.
    levels
        Its values; those of parameters ascend if all are numbers.
    default
        The value that holds without it; ``None`` where there is no single one.
    title
        The parameters in words, with their unit; of named levels the name.
    of_keys
        Whether its levels are values of the parameters that its name names.
    """

    name: str
    levels: tuple[Level, ...]
    default: float | str | None = None
    title: str = ""
    of_keys: bool = False

    @property
    def labels(self) -> tuple[str, ...]:
        """The labels of its levels."""
        return tuple(level.label for level in self.levels)

    def level(self, label: str) -> Level:
        """Return the level of a label.

        Parameters
        ----------
        label
            One of `labels`.

        Returns
        -------
        Level
            The level.
        """
        return next(level for level in self.levels if level.label == label)

    def values(self) -> tuple[float | str, ...]:
        """Return the values of all levels.

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
        """Return the value of one level, as of `values`.

        Parameters
        ----------
        label
            One of `labels`.

        Returns
        -------
        float or str
            The value.
        """
        return self.values()[self.labels.index(label)]


@dataclass(frozen=True, slots=True)
class Probe:
    """Further columns of a study's trials with the robot.

    Parameters
    ----------
    columns
        From what a trial showed (`experiments.bench.run.play.Showing` of each eye) to the columns of each model, by its
        label. It is pickled, so it is a function of a module or a `functools.partial` of one.
    schema
        The type of each column: ``int``, ``list[float]`` and the like.
    """

    columns: Callable[[Any], Mapping[str, Mapping[str, Any]]]
    schema: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Study:
    """A sweep that is written down: claims and measures at every point of a grid, in replicates.

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
        Names of `experiments.bench.measures.MEASURES`, or ``spikes``.
    experiments
        Names or files, of one kind; a claim is judged on the first that declares it. Without: for each claim the
        paper's experiment that answers for it.
    axes
        Axes with levels of their own.
    over
        Further axes, as ``KEY=V1,V2`` texts.
    models
        The models judged, one by one, at every point; as ``--model`` takes them. Empty: each claim is judged on the
        models that it is about, which see the same trials. With ``as_run`` the first is judged, and the others are
        shown with those of the experiment.
    assignments
        ``KEY=VALUE`` texts that hold at every point.
    repeats
        Trials of each condition in a replicate; ``None``: the experiment's own number. Clips have none.
    replicates
        Number of replicates; replicate k has the seed of the sweep plus k.
    every_trial
        Whether whole experiments are run, or just the motions that claims and measures read.
    as_run
        Whether the points are read off the trials of an off-line experiment as it stands. Their levels then choose
        among these by ``plays`` and ``claim_at``.
    claim_at
        Makes the claim that is judged at a point, from the claim and the point's labels by axis.
    probe
        Further columns of the trials.
    tables
        Makes further tables, a list of rows by title, from the `experiments.bench.sweep.Sweep`.
    file
        The .py file that declares it, which ``colias sweep`` fills in.

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
    tables: Callable[[Any], Mapping[str, list[dict[str, Any]]]] | None = None
    file: str = field(default="", compare=False, repr=False, kw_only=True)

    def __post_init__(self) -> None:
        check_name("study", self.name)
        several = ("claims", "measures", "experiments", "axes", "over", "models", "assignments")
        make_tuples(self, f"study {self.name}", several)
        for axis in self.axes:
            if not isinstance(axis, Axis) or not axis.levels:
                raise UsageError(f"study {self.name}: axes must be experiments.Axis with levels, got {axis!r}")
            if len(set(axis.labels)) < len(axis.labels):
                raise UsageError(f"study {self.name}: axis {axis.name}: a level is there twice")


def make_tuples(declaration: object, where: str, fields: Iterable[str]) -> None:
    """Make tuples of the sequences in some fields of a frozen declaration; `UsageError` for a text there.

    Parameters
    ----------
    declaration
        A level, a study or a fit.
    where
        The beginning of the message.
    fields
        Names of the fields.
    """
    for name in fields:
        values = getattr(declaration, name)
        if isinstance(values, str):
            raise UsageError(f"{where}: {name} must be a tuple, got {values!r}{of_one(values)}")
        object.__setattr__(declaration, name, tuple(values))


def names() -> tuple[str, ...]:
    """Return the names of the studies that ship."""
    return tuple(importlib.import_module("experiments.studies").NAMES)


def fits() -> tuple[str, ...]:
    """Return the names of the fits that ship."""
    return tuple(importlib.import_module("experiments.studies").FITS)


def shipped(name: str, attribute: str = "STUDY") -> Any:
    """Return the ``STUDY`` or the ``FIT`` that ships under a name; `UsageError` where there is none."""
    known = names() if attribute == "STUDY" else fits()
    if name not in known:
        raise UsageError(f"unknown {attribute.lower()} '{name}'{nearest(name, known, ' (', ')')}: {', '.join(known)}")
    return getattr(importlib.import_module(f"experiments.studies.{name.replace('-', '_')}"), attribute)


def called(name: str) -> Study | None:
    """Return the study that ships under a name, or that a user's file declares as ``STUDY``; ``None`` without one.

    Files of models and experiments are looked for beside the user's file.
    """
    if "," in name or not is_file(name):
        return shipped(name) if name in names() else None
    path = Path(name)
    if not declares(path, "STUDY"):
        return None
    study: Any = declared(path, "STUDY")
    if not isinstance(study, Study):
        raise UsageError(f"{path}: STUDY must be an experiments.Study, got a {type(study).__name__}")
    models = tuple(beside(path, model, f"STUDY.models[{index}]") for index, model in enumerate(study.models))
    folder = path.resolve().parent
    experiments = tuple(str(folder / name) if is_file(name) else name for name in study.experiments)
    return dataclasses.replace(study, models=models, experiments=experiments, file=str(path.resolve()))


def stored(folder: Path) -> dict[str, dict[str, Any]]:
    """Return the studies in a folder, or one level below: name -> the contents of its ``NAME.json``.

    Of several of a name that in the folder itself counts, or else the first.
    """
    found: dict[str, dict[str, Any]] = {}
    for path in (*sorted(folder.glob("*.json")), *sorted(folder.glob("*/*.json"))):
        document = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(document, dict) and document.get("study") == path.stem and "counts" in document:
            found.setdefault(path.stem, document)
    return found
