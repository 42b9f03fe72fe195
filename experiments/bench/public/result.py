"""A run in its folder: its tables, verdicts, figure and recordings, read when they are asked for."""

from __future__ import annotations

import dataclasses
import datetime
import html
import json
import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.csv

from experiments.bench.engine.errors import UsageError
from experiments.bench.judging import stored
from experiments.bench.judging.verdict import Verdict
from experiments.bench.public import arguments
from experiments.bench.store import parameters, provenance
from experiments.bench.store.description import BEGUN, read_description, short
from experiments.bench.store.files import read_parquet
from experiments.bench.store.places import regular
from experiments.bench.store.rows import Failure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COUNTED = ("trial", "seed", "attempts")
CLAIM_SCHEMA = pa.schema(
    {
        **dict.fromkeys(("id", "model", "word", "count"), pa.string()),
        **dict.fromkeys(("holds", "fails", "unjudged"), pa.int64()),
        "random": pa.bool_(),
        **dict.fromkeys(("interval_low", "interval_high"), pa.float64()),
        **dict.fromkeys(("says", "source", "experiment", "outcome", "measured", "decided", "effect"), pa.string()),
        "n": pa.int64(),
        "trouble": pa.string(),
        "provenance": pa.string(),
    }
)
FAILURE_SCHEMA = pa.schema(
    {field.name: pa.int64() if field.name in _COUNTED else pa.string() for field in dataclasses.fields(Failure)}
)


@dataclasses.dataclass(frozen=True, repr=False)
class Run:
    """A run of an experiment, finished or not, as its files say; made by `run` and `load`.

    The tables are `pyarrow.Table` objects: ``run.trials.to_pandas()`` needs pandas, which is not installed with this
    project, and ``run.trials.to_pylist()`` gives plain rows. Each is read once, when it is first asked for.

    Attributes
    ----------
    folder
        Where its files are.
    description
        ``experiment.json``: every parameter, the seed, and what computed it.
    """

    folder: Path
    description: Mapping[str, Any]

    def __getstate__(self) -> dict[str, Any]:
        return dict(self.__dict__)  # a table that another thread reads meanwhile would stop a copy

    @cached_property
    def trials(self) -> pa.Table:
        """A row per trial (or clip, or episode) and model; changed parameters have columns such as ``dsnn.n_con``.

        Raises
        ------
        UsageError
            No trial is finished, or the file cannot be read. The other tables raise it too.
        """
        return self._table("trials.parquet")

    @cached_property
    def frames(self) -> pa.Table:
        """A row per frame and model."""
        return self._table("frames.parquet")

    @cached_property
    def summary(self) -> pa.Table:
        """A row per model, condition (or clip) and quantity: n, mean, sd, median, 95 % interval of the mean."""
        from experiments.bench.public.summary import of_clips, read

        return of_clips(self.trials) if self.offline else read(self.folder)

    @cached_property
    def claims(self) -> pa.Table:
        """A row per claim, and with the robot per model.

        ``id``, ``model``; ``word`` and ``count``: what all replicates came to; ``holds``, ``fails``, ``unjudged``: in
        how many replicates; ``random``: whether anything differs between them; ``interval_low``, ``interval_high``:
        the exact 95 % interval of the share in which it holds; ``says``, ``source``, ``experiment``; ``outcome``,
        ``measured``, ``decided``, ``effect``, ``n``: of the first replicate; ``trouble``; ``provenance``: of the run.
        """
        rows = [_claim_row(verdict) | {"provenance": self.provenance} for verdict in self._verdicts]
        return pa.Table.from_pylist(rows, CLAIM_SCHEMA)

    @cached_property
    def failures(self) -> pa.Table:
        """A row per trial that failed: trial, model, condition, seed, reason.

        Where a model failed in a trial, or its recording could not be written, ``model`` says so.
        """
        try:
            return pa.Table.from_pylist(self._json("failures.json") or [], FAILURE_SCHEMA)
        except Exception as error:  # what is not a list of objects can make the library raise anything
            raise UsageError(f"{self.folder}: failures.json cannot be read ({short(error)})") from None

    @property
    def recordings(self) -> list[Path]:
        """The paths of its Rerun recordings, in order of trial: ``colias view PATH`` shows one."""
        return sorted((self.folder / "recordings").glob("*.rrd"))

    @property
    def name(self) -> str:
        """The experiment's name."""
        declared = self.description.get("experiment", "")
        return str(declared["name"] if isinstance(declared, Mapping) else declared)

    @property
    def seed(self) -> int | None:
        """The seed of the whole run; ``None`` of an imported log, whose trials have seeds of their own or none."""
        return None if "measured" in self.description else int(self.description["seed"])

    @property
    def planned(self) -> int:
        """Number of trials that the run is to have."""
        return int(self.description["trials"])

    @property
    def done(self) -> int:
        """Number of trials that are finished."""
        if not (self.folder / "trials.parquet").exists():
            return 0
        return len(self._table("trials.parquet", ["trial"])["trial"].unique())

    @property
    def begun(self) -> datetime.datetime | None:
        """When it was begun, UTC; ``None`` of a folder that a version before 0.3 made."""
        try:
            begun = datetime.datetime.fromisoformat(self.description[BEGUN])
        except (KeyError, TypeError, ValueError):
            return None
        return begun.astimezone(datetime.UTC) if begun.tzinfo else None

    @property
    def commit(self) -> str | None:
        """The commit that it was begun with, and whether there were changes; ``None`` outside a git checkout."""
        source = self.description.get("source")
        return provenance.commit(source) if isinstance(source, Mapping) else None

    @property
    def models(self) -> list[str]:
        """The labels of its models, or of its behaviours."""
        listed = self.description.get("models") or (self.description.get("settings") or {})
        listed = listed.get("models", ()) if isinstance(listed, Mapping) else listed
        return [str(model.get("label") or Path(model.get("behaviour", "")).stem) for model in listed]

    @property
    def changed(self) -> str:
        """The parameters that are not at their defaults: ``dsnn.n_con=6``; empty if none."""
        return parameters.said(self.description.get("changed") or {})

    @property
    def verdicts(self) -> str:
        """What claims came to, by their words, or by their counts without one: ``holds: C1, C2; held in 4 of 5: C5``.

        Where a run has several models, each claim that is about one of them names it. Empty if no claim was judged.
        """
        several = len({verdict.model for verdict in self._verdicts if verdict.model}) > 1
        labels: dict[str, list[str]] = {}
        for verdict in self._verdicts:
            model = f" ({verdict.model})" if several and verdict.model else ""
            count = verdict.count
            label = f"held in {count.label}" if count.kind == "counted" else count.label
            labels.setdefault(label, []).append(f"{verdict.id}{model}")
        return "; ".join(f"{label}: {', '.join(ids)}" for label, ids in labels.items())

    @cached_property
    def _verdicts(self) -> list[Verdict]:
        content = self._json("claims.json")
        try:
            return [] if content is None else stored.verdicts(content)
        except ValueError as error:
            raise UsageError(f"{self.folder}: claims.json cannot be read ({error})") from None

    @property
    def provenance(self) -> str:
        """Where its trials come from: ``simulated``, or of an imported log ``measured``, say."""
        measured = self.description.get("measured")
        return str(measured["provenance"]) if isinstance(measured, Mapping) else "simulated"

    @property
    def offline(self) -> bool:
        """Whether it is of clips that models were shown, not of the robot."""
        declared = self.description.get("experiment")
        return isinstance(declared, Mapping) and "clips" in declared

    def figure(self) -> Figure:
        """Draw the run's figure from its tables.

        Returns
        -------
        matplotlib.figure.Figure
            That of ``figure.svg``, to be changed or saved. It shows itself in a notebook, with or without
            ``%matplotlib inline``. Thresholds are those that the run has stored: no file of a model is run.

        Raises
        ------
        UsageError
            The run has no trials yet, or is of a kind whose figure is not drawn from its tables: episodes, say.
        """
        from experiments.bench.public.picture import draw  # not before: matplotlib takes its time to load

        return draw(self.folder, self.description, self.trials, self.frames)

    def _table(self, name: str, columns: list[str] | None = None) -> pa.Table:
        path = self.folder / name
        if not path.exists():
            raise UsageError(f"{self.folder}: no {name} there: no trial of it is finished")
        try:
            return read_parquet(path, columns)
        except Exception as error:  # bytes that are no table can make the library raise anything
            raise UsageError(f"{self.folder}: {name} cannot be read ({short(error)})") from None

    def _json(self, name: str) -> Any:
        """What a file holds; ``None`` where there is none."""
        path = self.folder / name
        if not path.exists():
            return None
        try:
            return json.loads(regular(path).read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            raise UsageError(f"{self.folder}: {name} cannot be read ({short(error)})") from None

    def __str__(self) -> str:
        changed, verdicts = (f"{said}; " if said else "" for said in (self.changed, self.verdicts))
        done = f"{self.done} of {self.planned} trials"
        seed = "" if self.seed is None else f", seed {self.seed}"
        return f"{self.folder}: {self.name}{seed}; {changed}{verdicts}{done}"

    def __repr__(self) -> str:
        return f"<Run {self}>"

    def _repr_html_(self) -> str:
        rows = [(each.id, each.model, each.count.word, str(each.count), each.says) for each in self._verdicts]
        cells = "".join(f"<tr>{''.join(f'<td>{html.escape(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
        return f"<p>{html.escape(str(self))}</p><table>{cells}</table>"


def _claim_row(verdict: Verdict) -> dict[str, Any]:
    count, outcome = verdict.count, verdict.outcome
    low, high = count.interval or (None, None)
    return {
        "id": verdict.id, "model": verdict.model, "word": count.word, "count": str(count), "holds": count.holds,
        "fails": count.fails, "unjudged": sum(count.unjudged.values()), "random": count.random, "interval_low": low,
        "interval_high": high, "says": verdict.says, "source": verdict.source, "experiment": verdict.experiment,
        "outcome": outcome.verdict, "measured": outcome.measured, "decided": outcome.decided,
        "effect": outcome.effect, "n": outcome.n, "trouble": verdict.trouble,
    }  # fmt: skip


def load(folder: str | os.PathLike[str]) -> Run:
    """Read a run that is in a folder already.

    Parameters
    ----------
    folder
        As ``colias run`` or `run` left it, whole or interrupted. Folders of ``colias behave`` and ``tune``, and the
        parts of a sweep or a reproduction, are runs too.

    Returns
    -------
    Run
        The run. Its tables are read when they are asked for.

    Raises
    ------
    UsageError
        There is no run, in one line. It is a ``ValueError``.

    Examples
    --------
    >>> from experiments import load
    >>> load("runs/speed-20260801-120000").trials.select(["speed_cm_s", "spikes"]).to_pylist()
    """
    path = arguments.folder("folder", folder)
    there = read_description(path)
    for name, kind in (("experiment", str | dict), ("seed", int), ("trials", int)):
        if not isinstance(there.get(name), kind):
            raise UsageError(f"{path}: experiment.json cannot be read (it has no {name} of a run)")
    return Run(path, there)
