"""A run of any kind as Python has it: its record, its summary, its verdicts and its figure."""

from __future__ import annotations

import dataclasses
import html
import json
import os
from functools import cached_property
from typing import TYPE_CHECKING

import pyarrow as pa

from experiments.bench.engine.errors import UsageError
from experiments.bench.judging.verdict import Verdict
from experiments.bench.public import arguments
from experiments.bench.store.description import short
from experiments.bench.store.kinds import CLIPS
from experiments.bench.store.places import regular
from experiments.bench.store.record import Record
from experiments.bench.store.rows import Failure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COUNTED = (
    "n", "replicates", "replicates_held", "replicates_failed", "replicates_vacuous", "replicates_untestable",
    "replicates_untested", "trial", "seed", "attempts",
)  # fmt: skip
_WORDS = {"holds": ("holds", "hold"), "fails": ("fails", "fail"), "vacuous": ("vacuous", "vacuous"),
          "untestable": ("untestable", "untestable"), "untested": ("untested", "untested")}  # fmt: skip


def _schema(kind: type) -> pa.Schema:
    fields = [field.name for field in dataclasses.fields(kind)]
    return pa.schema({name: pa.int64() if name in _COUNTED else pa.string() for name in fields})


CLAIM_SCHEMA, FAILURE_SCHEMA = _schema(Verdict), _schema(Failure)


@dataclasses.dataclass(frozen=True, repr=False)
class Run(Record):
    """A run of any kind, finished or not, as its files say; made by `run` and `load`.

    The tables are `pyarrow.Table` objects: ``run.trials.to_pandas()`` needs pandas, which is not installed with this
    project, and ``run.trials.to_pylist()`` gives plain rows. Each is read once, when it is first asked for.

    Attributes
    ----------
    folder
        Where its files are.
    description
        ``experiment.json``: every parameter, the seed, and what computed it. Empty of a whole that says nothing of
        itself, such as the leaderboard of an older version, and of footage.
    kind
        What kind of run it is. Where something makes no sense of a kind, it raises `UsageError`.
    """

    @cached_property
    def summary(self) -> pa.Table:
        """A row per model, condition (or clip) and quantity: n, mean, sd, median, 95 % interval of the mean.

        Of other kinds the table that sums up the run: ``scores.csv`` of episodes, ``leaderboard.csv``, ``map.csv``.

        Raises
        ------
        UsageError
            A run of that kind has no summary, or has not come to it.
        """
        from experiments.bench.public.summary import of_clips, read  # not before: a listing needs no statistics

        return of_clips(self.trials) if self.kind is CLIPS else read(self)

    @cached_property
    def claims(self) -> pa.Table:
        """A row per claim, and with the robot per model: id, says, verdict, measured, decided, ...; see `Verdict`."""
        return self._listed("claims.json", CLAIM_SCHEMA)

    @cached_property
    def failures(self) -> pa.Table:
        """A row per trial that failed: trial, model, condition, seed, reason.

        Where a model failed in a trial, or its recording could not be written, ``model`` says so.
        """
        return self._listed("failures.json", FAILURE_SCHEMA)

    @property
    def verdicts(self) -> str:
        """How many claims came to each verdict: ``3 hold, 1 fails``; empty if none was judged."""
        found = self.claims["verdict"].to_pylist()
        counts = {word: found.count(word) for word in _WORDS}
        return ", ".join(f"{count} {_WORDS[word][count != 1]}" for word, count in counts.items() if count)

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

        return draw(self)

    def _listed(self, name: str, schema: pa.Schema) -> pa.Table:
        path = self.folder / name
        if not path.exists():
            return schema.empty_table()
        try:
            return pa.Table.from_pylist(json.loads(regular(path).read_text(encoding="utf-8")), schema)
        except Exception as error:  # what is not a list of objects can make the library raise anything
            raise UsageError(f"{self.folder}: {name} cannot be read ({short(error)})") from None

    def __str__(self) -> str:
        changed, verdicts = (f"{said}; " if said else "" for said in (self.changed, self.verdicts))
        done = f"{self.done} of {self.planned} trials"
        seed = "" if self.seed is None else f", seed {self.seed}"
        return f"{self.folder}: {self.name}{seed}; {changed}{verdicts}{done}"

    def __repr__(self) -> str:
        return f"<Run {self}>"

    def _repr_html_(self) -> str:
        rows = [(each["id"], each["model"], each["verdict"], each["says"]) for each in self.claims.to_pylist()]
        cells = "".join(f"<tr>{''.join(f'<td>{html.escape(str(cell))}</td>' for cell in row)}</tr>" for row in rows)
        return f"<p>{html.escape(str(self))}</p><table>{cells}</table>"


def load(folder: str | os.PathLike[str]) -> Run:
    """Read a run that is in a folder already.

    Parameters
    ----------
    folder
        As a command or `run` left it, whole or interrupted, of any kind: trials, clips, tuning curves, episodes, a
        map, a leaderboard, a sweep, a reproduction or a part of one, a training, an imported log. Of footage, the file
        that ``colias watch`` wrote: a table or a recording.

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
    return Run.read(arguments.folder("folder", folder))
