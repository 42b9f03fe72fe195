"""A run of any kind as Python has it: its record, its summary, its verdicts and its figure."""

from __future__ import annotations

import dataclasses
import html
import json
import os
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from experiments.bench.stats import stored
from experiments.bench.stats.verdict import Verdict
from experiments.bench.store.record import Record
from experiments.bench.store.rows import Failure, schema_of, table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CLAIM_SCHEMA = pl.Schema(
    {
        **dict.fromkeys(("id", "model", "word", "count"), str),
        **dict.fromkeys(("holds", "fails", "unjudged"), int),
        "random": bool,
        **dict.fromkeys(("interval_low", "interval_high"), float),
        **dict.fromkeys(("says", "source", "experiment", "outcome", "measured", "decided", "effect"), str),
        "n": int,
        "trouble": str,
        "equal_terms": str,
        "provenance": str,
    }
)


@dataclasses.dataclass(frozen=True, repr=False)
class Run(Record):
    """A run of any kind, finished or not, as its files say; made by `run` and `load`.

    The tables are polars ``DataFrame`` objects, and are read when they are first asked for. ``run.trials.to_dicts()``
    gives plain rows; ``run.trials.to_pandas()`` needs pandas and PyArrow, and this project installs no pandas.

    Attributes
    ----------
    folder
        Where its files are.
    description
        ``run.json``: every parameter, the seed, and what computed it. Empty of a folder that only
        holds runs, and of footage.
    kind
        What kind of run it is. Where something makes no sense of a kind, it raises `UsageError`.
    """

    @cached_property
    def summary(self) -> pl.DataFrame:
        """A row per model, condition (or clip) and quantity: n, mean, sd, median, 95 % interval of the mean.

        Of episodes a row per behaviour and measure. Of other kinds the table that sums up the run: ``leaderboard.csv``,
        ``counts.csv``.

        Raises
        ------
        UsageError
            A run of that kind has no summary, or has none yet.
        """
        from experiments.bench.public.summary import read  # not before: a listing needs no statistics

        return read(self)

    def frames_with_conditions(self) -> pl.DataFrame:
        """Join the rows of frames with what their trials showed.

        Returns
        -------
        polars.DataFrame
            A row per frame and model: the columns of ``frames``, then those of ``trials`` that they lack.

        Examples
        --------
        >>> import experiments
        >>> frames = experiments.load("runs/speed").frames_with_conditions()  # doctest: +SKIP
        >>> frames.group_by("speed_cm_s").agg(pl.col("hs").max())  # doctest: +SKIP
        """
        shared = {"trial", "model"}
        more = [name for name in self.trials.columns if name in shared or name not in self.frames.columns]
        return self.frames.join(self.trials.select(more), on=sorted(shared), how="left")

    @cached_property
    def comparisons(self) -> pl.DataFrame:
        """A row per condition and pair of models that saw the same trials: a paired test of their spikes.

        The condition's columns; ``model`` and ``against``; ``n`` trials; ``mean_difference``, spikes a trial of the
        first less those of the second; ``rank_biserial``, its rank-biserial correlation, -1 to 1; ``test``; ``p``, and
        ``p_holm``, corrected for the number of rows. No rows where there is one model, or none of them spikes.
        `compare` tests two runs in the same way.

        Raises
        ------
        UsageError
            It is no run of trials with the robot, or ``comparisons.csv`` cannot be read.
        """
        from experiments.bench.public.summary import comparisons  # not before: a listing needs no statistics

        return comparisons(self)

    @cached_property
    def claims(self) -> pl.DataFrame:
        """A row per claim, and with the robot per model.

        ``id``, ``model``; ``word`` and ``count``: what all replicates came to; ``holds``, ``fails``, ``unjudged``: in
        how many replicates; ``random``: whether anything differs between them; ``interval_low``, ``interval_high``:
        the exact 95 % interval of the share in which it holds; ``says``, ``source``, ``experiment``; ``outcome``,
        ``measured``, ``decided``, ``effect``, ``n``: of the first replicate; ``trouble``; ``equal_terms``: the count
        with the models that it compares with on equal terms, empty without; ``provenance``: of the run.
        """
        rows = [_claim_row(verdict) | {"provenance": self.provenance} for verdict in self._verdicts]
        return table(rows, CLAIM_SCHEMA)

    @cached_property
    def failures(self) -> pl.DataFrame:
        """A row per trial that failed: trial, model, condition, seed, reason.

        Where a model failed in a trial, or its recording could not be written, ``model`` says so.

        """
        return table(self._json("failures.json") or [], schema_of(Failure))

    @property
    def verdicts(self) -> str:
        """Say what claims came to, by word, or by count without one: ``holds: C1, C2; held in 4 of 5: C5``.

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
        return [] if content is None else stored.verdicts(content)

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
            The run has no trials yet, or is of a kind whose figure is not drawn from its tables: a sweep, say.
        """
        from experiments.bench.public.picture import draw  # not before: matplotlib takes its time to load

        return draw(self)

    def _json(self, name: str) -> Any:
        """Read what a file holds; ``None`` where there is none."""
        path = self.folder / name
        if not path.exists():
            return None
        return json.loads(path.read_text(encoding="utf-8"))

    def __str__(self) -> str:
        changed, verdicts = (f"{text}; " if text else "" for text in (self.changed, self.verdicts))
        done = f"{self.done} of {self.planned} trials"
        seed = "" if self.seed is None else f", seed {self.seed}"
        return f"{self.folder}: {self.name}{seed}; {changed}{verdicts}{done}"

    def __repr__(self) -> str:
        return f"<Run {self}>"

    def _repr_html_(self) -> str:
        rows = [
            (verdict.id, verdict.model, verdict.count.word, str(verdict.count), verdict.says)
            for verdict in self._verdicts
        ]
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
        "equal_terms": str(verdict.equal) if verdict.equal else "",
    }  # fmt: skip


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
    >>> import polars as pl
    >>> from experiments import load
    >>> load("runs/speed-20260801-120000").trials.group_by("speed_cm_s").agg(pl.col("spikes").mean())
    """
    return Run.read(Path(folder))
