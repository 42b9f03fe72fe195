"""A run of any kind as its folder has it: tables, verdicts, recordings, figure; and what a kind of run is."""

from __future__ import annotations

import dataclasses
import datetime
import html
import io
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import polars as pl

from experiments.base.errors import UsageError, short
from experiments.base.files import NAME, read_json
from experiments.declare.conditions import Condition
from experiments.declare.experiment import WHOLE
from experiments.judge.controls import COLUMNS as CONTROL_COLUMNS
from experiments.judge.tests import SUMMARY
from experiments.judge.verdict import Verdict, verdicts
from experiments.kinds.tables import KINDS, kind_of
from experiments.settings import parameters
from experiments.settings.models import counted_channel
from experiments.show.excitation import without_parts
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import BEGUN, KIND, THRESHOLDS, RunFolder, begun, has_tables, read_description, read_table
from experiments.store.plan import Plan, filled
from experiments.store.recordings import recordings_in
from experiments.store.tables import FAILURE, columns_of, table, without_controls
from experiments.store.workers import Workers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DEEPEST = 3
"""Levels of folders that are looked through for runs."""
COMPARISONS = columns_of(Condition) | {
    "model": str, "against": str, "n": int, "mean_difference": float, "rank_biserial": float, "test": str, "p": float,
    "p_holm": float,
}  # fmt: skip
NUMBERS = SUMMARY | COMPARISONS | CONTROL_COLUMNS | {"low": float, "high": float}
"""Types of columns that can be empty in every row of a CSV file."""
CLAIM_COLUMNS: dict[str, Any] = {
    "id": str, "model": str, "word": str, "count": str, "holds": int, "fails": int, "unjudged": int, "random": bool,
    "interval_low": float, "interval_high": float, "says": str, "source": str, "experiment": str, "outcome": str,
    "measured": str, "decided": str, "effect": str, "n": int, "trouble": str, "equal_terms": str, "provenance": str,
}  # fmt: skip
RUNS_COLUMNS: dict[str, Any] = {
    "run": str, "when": pl.Datetime("us", "UTC"), "experiment": str, "seed": int, "models": str, "changed": str,
    "done": int, "planned": int, "failures": int, "verdicts": str, "provenance": str, "trouble": str,
}  # fmt: skip


@dataclasses.dataclass(frozen=True, repr=False)
class Run:
    """A run of any kind, finished or not, made by `run` and `load`.

    The tables are polars ``DataFrame`` objects, and are read when they are first asked for; ``to_pandas()`` needs
    pandas and PyArrow.

    Attributes
    ----------
    folder
        Where its files are.
    description
        ``run.json``: every parameter, the seed, and what computed it. Empty for a folder that only holds runs.

    Examples
    --------
    >>> from experiments import load
    >>> run = load("runs/speed-20260801-120000")
    >>> run.trials.group_by("speed_cm_s").agg(pl.col("spikes").mean())
    >>> run.claims.select("id", "count")
    """

    folder: Path
    description: Mapping[str, Any]

    @property
    def kind(self) -> str:
        """The kind of run: ``trials``, ``clips``, ``episodes``, ``sweep``, ...; ``whole`` for a folder of runs."""
        return str(self.description.get(KIND, "whole"))

    @cached_property
    def trials(self) -> pl.DataFrame:
        """A row per trial (or clip, or episode) and model; changed parameters have columns such as ``dsnn.n_con``.

        Raises
        ------
        UsageError
            No trial is finished, or the run is a whole of parts. The other tables raise it too.
        """
        return self._table("trials")

    @cached_property
    def frames(self) -> pl.DataFrame:
        """A row per frame and model."""
        return self._table("frames")

    @cached_property
    def summary(self) -> pl.DataFrame:
        """A row per model, condition (or clip) and quantity: n, mean, sd, median, 95 % interval of the mean.

        Of other kinds the table that sums up the run, as ``leaderboard.csv`` or ``counts.csv``.
        """
        return self._csv(kind_of(self.kind).summary if self.kind in KINDS else "summary.csv")

    @cached_property
    def comparisons(self) -> pl.DataFrame:
        """A row per condition and pair of models that saw the same trials: a paired test of their spikes.

        The condition's columns; ``model`` and ``against``; ``n`` trials; ``mean_difference``, spikes a trial of the
        first less those of the second; ``rank_biserial``, -1 to 1; ``test``; ``p``, and ``p_holm``, corrected for the
        number of rows. No rows where there is one model, or none of them spikes; only trials with the robot have it.
        """
        if "settings" in self.description and not (self.folder / "comparisons.csv").is_file():
            return pl.DataFrame(schema=pl.Schema(COMPARISONS))
        return self._csv("comparisons.csv")

    @cached_property
    def controls(self) -> pl.DataFrame:
        """Of a run with controls, a row per model and kind of response, as ``controls.csv`` has it; else no rows.

        ``response``: ``direction`` or ``looming``, of footage the channel; ``word``: ``sees``, ``wrong sign``,
        ``not judged`` or ``blind``, and ``says`` why; ``n`` pairs; ``shown``, ``frozen``, ``absent``, ``mirrored``,
        ``reversed`` and ``shuffled``: means over the trials; ``p``: the largest of its tests after Holm;
        ``detectable``: the difference that these pairs would show in 80 % of such runs.
        """
        there = (self.folder / "controls.csv").is_file()
        return self._csv("controls.csv") if there else table([], CONTROL_COLUMNS)

    @cached_property
    def anew(self) -> pl.DataFrame:
        """Of a fit, the settings judged again, a row for each and each claim, the winner's first."""
        return self._csv("anew.csv")

    @cached_property
    def fitted(self) -> Mapping[str, Any]:
        """Of a fit, its result, as ``fit.json`` has it; empty in other runs.

        ``winner``: the best setting as the search saw it. ``word``: the verdict on it: ``fitted``, ``not fitted``, or
        ``no word`` where too few replicates judged it again. ``share``: in how many settings of the even sample every
        claim is kept. ``luck``: the winner's slack in the search less that at fresh seeds. ``looks``: number of times
        that settings were judged at these. ``importance``: parameter -> its share of what varies in the slack.
        ``sentences``: all that in words.
        """
        return self._json("fit.json") or {}

    @cached_property
    def excitations(self) -> pl.DataFrame:
        """Excitation and inhibition in each condition and frame, as in ``excitation.csv``; no rows in other runs."""
        from experiments.show import excitation

        networks = {
            model["label"]: model["network"] for model in self.description.get("settings", {}).get("models", ())
        }
        if WHOLE not in networks or self.description["experiment"]["figure"] != "excitation":
            return pl.DataFrame()
        rows, frames = without_controls(self.trials).to_dicts(), without_controls(self.frames)
        return excitation.table(rows, frames, float(networks[WHOLE]["w_i"]))

    @cached_property
    def claims(self) -> pl.DataFrame:
        """A row per claim, and with the robot per model.

        ``id``, ``model``; ``word`` and ``count``: what all replicates came to; ``holds``, ``fails``, ``unjudged``: in
        how many replicates; ``random``: whether anything differs between them; ``interval_low``, ``interval_high``:
        the exact 95 % interval of the share in which it holds; ``says``, ``source``, ``experiment``; ``outcome``,
        ``measured``, ``decided``, ``effect``, ``n``: of the first replicate; ``trouble``; ``equal_terms``: the count
        with the models that it compares with on equal terms, empty without; ``provenance``: of the run.
        """
        rows = [_claim_row(verdict) | {"provenance": self.provenance} for verdict in self.verdicts]
        return table(rows, CLAIM_COLUMNS)

    @cached_property
    def outcomes(self) -> pl.DataFrame:
        """Of a sweep, a row for each point, model, claim and replicate, as ``outcomes.csv`` has it.

        ``verdict``, what ``decided``, what was ``measured``, and the ``slack`` in smallest differences.
        """
        return self._csv("outcomes.csv")

    @property
    def troubles(self) -> list[tuple[str, str]]:
        """Ids of claims whose judge, a user's own, went wrong, each with what it raised."""
        found = {verdict.id: verdict.trouble for verdict in self.verdicts if verdict.trouble}
        swept = self._json(f"{self.name}.json") if "axes" in self.description else {}
        return [*{**found, **(swept or {}).get("troubles", {})}.items()]

    @cached_property
    def failures(self) -> pl.DataFrame:
        """A row per trial, model in a trial, or recording that failed: trial, model, condition, seed, reason."""
        if self.whole:
            return pl.concat([table([], FAILURE), *(part.failures for part in self.parts)])
        return table(self._json("failures.json"), FAILURE)

    @property
    def recordings(self) -> list[Path]:
        """The paths of its Rerun recordings, in order of trial: ``colias view PATH`` shows one."""
        return recordings_in(self.folder)

    @cached_property
    def parts(self) -> list[Run]:
        """The runs in its folders, of a leaderboard, a fit or a reproduction; none of others."""
        return [load(folder) for folder in part_folders(self.folder)] if self.whole else []

    @property
    def name(self) -> str:
        """The experiment's name."""
        declared = self.description.get("experiment", self.kind)
        return str(declared["name"] if isinstance(declared, Mapping) else declared)

    @property
    def seed(self) -> int | None:
        """The seed of the whole run; ``None`` of a log and of a folder of runs."""
        return None if self.measured else self.description.get("seed")

    @property
    def planned(self) -> int:
        """Number of trials that the run is to have."""
        return sum(part.planned for part in self.parts) or int(self.description.get("trials", 0))

    @property
    def done(self) -> int:
        """Number of trials that are finished."""
        if self.whole:
            return sum(part.done for part in self.parts)
        return read_table(self.folder, "trials", ["trial"])["trial"].n_unique() if has_tables(self.folder) else 0

    @property
    def whole(self) -> bool:
        """Whether its folder holds runs, and no trials of its own."""
        return self.kind not in KINDS or bool(kind_of(self.kind).whole)

    @property
    def chapter(self) -> str:
        """The heading of such runs on a page; empty of those that no page has."""
        return str(kind_of(self.kind).chapter)

    @property
    def words(self) -> str:
        """What it shows, and what its robots did not do as planned, in a sentence or two."""
        return str(kind_of(self.kind).words(self))

    @property
    def measured(self) -> bool:
        """Whether its trials are a robot's, imported from a log."""
        return "measured" in self.description

    @property
    def thresholds(self) -> dict[str, float | None]:
        """The threshold of each model's counted channel, by label, as ``run.json`` has it."""
        return {label: levels.get(counted_channel(levels)) for label, levels in self.description[THRESHOLDS].items()}

    @property
    def begun(self) -> datetime.datetime | None:
        """The time at which it was begun, UTC; ``None`` of a folder that only holds runs."""
        return datetime.datetime.fromisoformat(self.description[BEGUN]) if BEGUN in self.description else None

    @property
    def models(self) -> list[str]:
        """The labels of its models, or of its behaviours."""
        listed = self.description.get("models") or self.description.get("settings", {}).get("models", ())
        behaviours = [Path(name).stem for name in self.description.get("behaviours", ())]
        return behaviours or [str(model["label"]) for model in listed]

    @property
    def changed(self) -> str:
        """The parameters that are not at their defaults: ``dsnn.n_con=6``; empty if none."""
        return parameters.in_words(self.description.get("changed") or {})

    @property
    def provenance(self) -> str:
        """The origin of its trials: ``simulated``, or of an imported log ``measured``, say."""
        return str(self.description.get("measured", {}).get("provenance", "simulated"))

    @cached_property
    def verdicts(self) -> list[Verdict]:
        """The verdicts behind `claims`, with every check that was made."""
        content = self._json("claims.json")
        return verdicts(content) if content else []

    def figure(self) -> Figure:
        """Draw the run's figure from its tables.

        Returns
        -------
        matplotlib.figure.Figure
            That of ``figure.svg``, to be changed or saved; a notebook shows it. Thresholds are those that the run has
            stored: no file of a model is run.

        Raises
        ------
        UsageError
            The run has no trials yet, or is of a kind whose figure is not drawn from its tables: a sweep, say.
        """
        draw = kind_of(self.kind).draw
        if isinstance(draw, str):
            raise UsageError(f"{self.folder}: {draw}")
        drawn: Figure = draw(self)
        setattr(drawn, "_repr_png_", lambda: _png(drawn))  # what notebooks look for  # noqa: B010
        return drawn

    def _table(self, name: str) -> pl.DataFrame:
        if self.whole:
            names = ", ".join(part.folder.name for part in self.parts) or "none"
            raise UsageError(f"{self.folder}: a {self.kind} has no table of {name} itself; its parts are: {names}")
        if not has_tables(self.folder):
            raise UsageError(f"{self.folder}: no {name}.parquet there: no trial of it is finished")
        return read_table(self.folder, name)

    def _csv(self, name: str) -> pl.DataFrame:
        path = self.folder / name
        if not path.is_file():
            raise UsageError(f"{self.folder}: no {name} there")
        header = pl.read_csv(path, n_rows=0, glob=False, raise_if_empty=False).columns
        types = pl.Schema({column: kind for column, kind in NUMBERS.items() if column in header})
        return pl.read_csv(path, schema_overrides=types, infer_schema_length=None, glob=False, raise_if_empty=False)

    def _json(self, name: str) -> Any:
        path = self.folder / name
        return read_json(path) if path.is_file() else []

    def __str__(self) -> str:
        changed, verdicts = (f"{text}; " if text else "" for text in (self.changed, _in_words(self.verdicts)))
        seed = "" if self.seed is None else f", seed {self.seed}"
        return f"{self.folder}: {self.name}{seed}; {changed}{verdicts}{self.done} of {self.planned} trials"

    def __repr__(self) -> str:
        return f"<Run {self}>"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(str(self))}</p>{self.claims.select('id', 'model', 'word', 'count')._repr_html_()}"


def load(folder: str | os.PathLike[str]) -> Run:
    """Read a run that is in a folder already.

    Parameters
    ----------
    folder
        As a command or `run` left it, whole or interrupted, of any kind: trials, clips, tuning curves, episodes, a
        leaderboard, a sweep, a reproduction or a part of one, a training, an imported log.

    Returns
    -------
    Run
        The run. Its tables are read when they are asked for.

    Raises
    ------
    UsageError
        There is no run, or another version made it, in one line. It is a ``ValueError``.

    Examples
    --------
    >>> import polars as pl
    >>> from experiments import load
    >>> load("runs/speed-20260801-120000").trials.group_by("speed_cm_s").agg(pl.col("spikes").mean())
    """
    place = Path(folder)
    if not begun(place) and place.is_dir() and next(part_folders(place), None) is not None:
        return Run(place, {})
    description = read_description(place)
    made_by, here = description["versions"]["colias-sim"], provenance.versions()["colias-sim"]
    if made_by.split(".")[:2] != here.split(".")[:2]:
        raise UsageError(f"{place}: colias-sim {made_by} made this run and reads it; this is colias-sim {here}")
    return Run(place, description)


def runs(folder: str | os.PathLike[str] = "runs") -> pl.DataFrame:
    """List the runs in a folder, oldest first.

    Parameters
    ----------
    folder
        Where runs are, or one run. All folders in it are looked through.

    Returns
    -------
    polars.DataFrame
        ``run``: its folder. ``when``: when it was begun. ``experiment``, ``seed``, ``models``: what ran. ``changed``:
        the parameters that are not at their defaults. ``done`` of ``planned`` trials are finished, ``failures`` are
        listed. ``verdicts``: what claims came to, ``holds: C1, C2; 4 of 5: C5``. ``provenance``:
        ``simulated``, or of an imported log ``measured``, say. ``trouble``: why a
        folder cannot be read, in one line; otherwise null.

    Raises
    ------
    UsageError
        There is no such folder.

    Examples
    --------
    >>> import experiments
    >>> experiments.runs("runs").select("run", "changed", "verdicts")
    """
    path = Path(folder)
    if not path.is_dir():
        raise UsageError(f"{path}: no such folder")
    return table([_runs_row(place.parent) for place in path.rglob(NAME)], RUNS_COLUMNS).sort("when", "run")


def part_folders(folder: Path, levels: int = DEEPEST) -> Iterator[Path]:
    """Yield the folders of the runs in a folder, down to so many levels, but not those inside of runs."""
    for path in sorted(path for path in folder.iterdir() if path.is_dir() and not path.name.startswith(".")):
        if begun(path):
            yield path
        elif levels > 1:
            yield from part_folders(path, levels - 1)


def _runs_row(folder: Path) -> dict[str, Any]:
    try:
        run = load(folder)
    except UsageError as error:
        return {"run": str(folder), "trouble": str(error)}
    except Exception as error:  # whatever is in a file of that name: the other runs are listed
        why = f"{type(error).__name__}: {short(error)}"
        return {"run": str(folder), "trouble": f"{folder}: cannot be read as a run ({why}); move it away"}
    return {
        "run": str(folder), "when": run.begun, "experiment": run.name, "seed": run.seed,
        "models": ", ".join(run.models), "changed": run.changed, "planned": run.planned, "done": run.done,
        "failures": run.failures.height, "verdicts": _in_words(run.verdicts), "provenance": run.provenance,
    }  # fmt: skip


def _in_words(verdicts: Sequence[Verdict]) -> str:
    """Say what claims came to, by word, or by count without one: ``holds: C1, C2; 4 of 5: C5``; empty without any."""
    labels: dict[str, list[str]] = {}
    several = len({verdict.model for verdict in verdicts}) > 1
    for verdict in verdicts:
        name = f"{verdict.id} {verdict.model}".rstrip() if several else verdict.id
        labels.setdefault(verdict.count.label, []).append(name)
    return "; ".join(f"{label}: {', '.join(dict.fromkeys(ids))}" for label, ids in labels.items())


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


def whole_networks(run: Run) -> list[dict[str, Any]]:
    """Return the rows of a run's trials without models that are parts of another; none where all trials failed."""
    rows = without_controls(run.trials).to_dicts() if run.done else []
    return without_parts(rows) if run.description["experiment"]["figure"] == "excitation" else rows


def _png(drawn: Figure) -> bytes:
    from experiments.draw import style

    buffer = io.BytesIO()
    with style.look():
        drawn.savefig(buffer, format="png", dpi=110)
    return buffer.getvalue()


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of run: to run it, ``plan`` and ``work``; to read what is in a folder, ``draw`` and ``show``.

    Parameters
    ----------
    plan
        Makes the plan of what was asked. Raises `UsageError` for what cannot be run.
    work
        Does what a folder lacks of a plan, and writes verdicts, tables and figures there.
    draw
        Draws the figure of a run from its folder alone: no file of a model is run. A text says why there is none.
    show
        Prints what a run comes to, from its folder alone.
    renders
        Whether its trials are drawn by OpenGL, on workers; ``None``: its work starts these itself, or needs none.
    summary
        The table that sums up such a run.
    chapter
        Heading of such runs on a page; empty of those that no page has.
    words
        Says what a run shows, from its folder alone.
    whole
        Whether its folder holds runs, and no trials of its own.
    """

    plan: Callable[[Asked], Plan[Any]]
    work: Callable[[Plan[Any], Path, Workers], None]
    draw: Callable[[Run], Figure] | str
    show: Callable[[Run], None]
    renders: bool | None = True
    summary: str = "summary.csv"
    chapter: str = ""
    words: Callable[[Run], str] = str
    whole: bool = False


def concluding(conclude: Callable[[Plan[Any], RunFolder], None]) -> Callable[[Plan[Any], Path, Workers], None]:
    """Return the work of a kind whose trials all go into one folder: do them, then conclude."""

    def work(plan: Plan[Any], out: Path, pool: Workers) -> None:
        with filled(plan, out, pool) as folder:
            conclude(plan, folder)

    return work


def plan_of(asked: Asked) -> Plan[Any]:
    """Return the plan of what was asked, by its kind; `UsageError` for what cannot be run. Nothing is written."""
    kind: Kind = kind_of(asked.kind)
    return kind.plan(asked)


def perform(plan: Plan[Any], out: Path, pool: Workers) -> Run:
    """Do what a folder lacks of a run, and judge and draw it.

    Parameters
    ----------
    plan
        From `plan_of`.
    out
        The run's folder: a new one, or one that holds a part of this run.
    pool
        Where the trials are done.

    Returns
    -------
    Run
        The run as its files have it.

    Raises
    ------
    UsageError
        The folder holds another run.
    """
    kind: Kind = kind_of(plan.asked.kind)
    if kind.renders is None:
        kind.work(plan, out, pool)
    else:
        with pool.running(rendering=kind.renders):
            kind.work(plan, out, pool)
    return load(out)
