"""Results of a job in a run's folder: rows of a declared type, frames, failures; and functions that group rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypedDict, get_args, get_type_hints

from experiments.bench.run.user_code import traced

if TYPE_CHECKING:
    import polars as pl

MOST_LISTED = 10
"""Numbers of trials in a message."""

RECORDING = "(recording)"
"""Label in place of the model in the failure of a trial's recording. No model's label has parentheses."""

OBSERVER = "observer"
"""The robot that sees and, in an env, behaves: today's only value of the column ``robot``."""


class JobRow(TypedDict):
    """The columns that every row of a ``trials.parquet`` begins with."""

    experiment: str
    trial: int
    """The job's number in the run."""
    repeat: int
    seed: int
    """Seed of all its random draws."""
    model: str
    """Label of the vision model, or name of the behaviour, that answered."""


class ModelRow(TypedDict):
    """Spike counts of one vision model in a trial or a clip. A count is null where the channel does not spike."""

    spikes: int | None
    """Accumulated count of HS, or of looming where no direction is declared."""
    hs_spikes: int | None
    vs_spikes: int | None
    looming_spikes: int | None


class FrameRow(TypedDict):
    """The columns that every row of a ``frames.parquet`` begins with."""

    trial: int
    model: str
    frame: int
    """Number of the frame, from 0 up."""


class ResponseRow(TypedDict):
    """A `dsnn.ResponseSeries` at one frame."""

    hs: float
    vs: float
    hs_spikes: int
    vs_spikes: int
    looming: float
    looming_spikes: int
    azimuth: float


def schema_of(*rows: type) -> pl.Schema:
    """Return the columns of typed rows: one for each key of the ``rows``' types, in their order.

    A key declared again by a later type keeps its place.
    """
    import polars as pl  # not before: declarations of claims import this module

    columns: dict[str, type] = {}
    for row in rows:
        for name, kind in get_type_hints(row).items():
            kinds = [part for part in get_args(kind) or (kind,) if part is not type(None)]
            kind = str if isinstance(kinds[0], str) else kinds[0]  # of a Literal
            if kind in (int, float, str, bool):  # a condition has paths too, which are no columns
                columns[name] = kind
    return pl.Schema(columns)


def table(rows: Sequence[Mapping[str, Any]], schema: Mapping[str, Any]) -> pl.DataFrame:
    """Return rows as a table; what a row lacks is null there, and a value of another type than its column's raises."""
    import polars as pl  # not before: declarations of claims import this module

    return pl.DataFrame({name: [row.get(name) for row in rows] for name in schema}, schema)


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """The result of a job: rows ready for the tables, and the bytes of its recording."""

    index: int
    rows: tuple[dict[str, Any], ...]
    frames: pl.DataFrame
    recording: bytes | str | None
    """Bytes of an .rrd file, or why there is none; ``None`` where none is kept."""
    failures: tuple[Failure, ...] = ()
    """Failures of single models; the answers of the others are kept."""
    renderer: str = ""
    """Renderer of its frames (`colias_sim.gl.renderer`); empty where none were drawn."""
    pixels: str = ""
    """Hash of the reference frame where they were drawn (`colias_sim.reference`); empty where none were."""

    def __post_init__(self) -> None:
        for name, value in (item for row in self.rows for item in row.items()):
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"trial {self.index}: {name} must be a finite number, or None, got {value}")


@dataclass(frozen=True, slots=True)
class Failure:
    """A trial that could not be finished, or a ``model`` or a recording of one that otherwise was, and why."""

    trial: int
    model: str
    """Empty for a whole trial, `RECORDING` for its recording."""
    condition: str
    seed: int
    reason: str
    """The traceback of what was raised, or one line where an input was refused."""

    def __str__(self) -> str:
        what = f"{self.model} failed in trial {self.trial}" if self.model else f"trial {self.trial} failed"
        if self.model == RECORDING:
            what = f"trial {self.trial} has no recording"
        return f"{what} ({self.condition}): {self.reason}"


def in_words(failures: Iterable[Failure]) -> list[str]:
    """Return failures in words, those of one reason together."""
    alike: dict[tuple[str, str], list[Failure]] = {}
    for failure in failures:
        alike.setdefault((failure.model, failure.reason), []).append(failure)
    return [
        f"{first}\nThe same in {len(others)} more: {listed_trials(failure.trial for failure in others)}" if others
        else str(first)
        for first, *others in alike.values()
    ]  # fmt: skip


def recording_of(make: Callable[[], bytes]) -> bytes | str:
    """Make the recording of a trial, or say why there is none: the trial's rows do not go with it."""
    try:
        return make()
    except Exception as error:  # Rerun's, or too little memory
        return traced(error)


def recording_name(index: int) -> str:
    """File name of the recording of trial ``index``."""
    return f"trial-{index:04d}.rrd"


def group(rows: Iterable[Mapping[str, Any]], *keys: str) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """Return rows by the values of ``keys``, groups in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def known(value: float) -> float | None:
    """Return the value for a table: empty instead of NaN."""
    return None if math.isnan(value) else value


def mixture(rows: Iterable[Mapping[str, Any]]) -> str:
    """Say of how many trials each code computed the rows, if more than one did; otherwise empty."""
    trials: dict[str, set[int]] = {}
    for row in rows:
        if "code" in row:
            trials.setdefault(row["code"], set()).add(row["trial"])
    if len(trials) < 2:
        return ""
    counts = ", ".join(f"{code}: {len(indices)} trials" for code, indices in trials.items())
    return f"rows of {len(trials)} codes ({counts})"


def listed_trials(trials: Iterable[int]) -> str:
    """Return the numbers of trials in words, the first few of many."""
    numbers = sorted(trials)
    more = f" and {len(numbers) - MOST_LISTED} more" if len(numbers) > MOST_LISTED else ""
    return f"trials {', '.join(map(str, numbers[:MOST_LISTED]))}{more}"


COLUMN = "provenance"
MEASURED = "measured"
"""The robot measured everything: its own network answered."""
FRAMES_MEASURED = "frames measured, network simulated"
"""The robot's camera took the frames; a model of this bench answered to them."""
LOG_OF_SIMULATION = "log of a simulated run"
"""``colias firmware log`` wrote the log: nothing of it was measured."""
FRAMES_OF_SIMULATION = "frames from the log of a simulated run"


def origin(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return where rows come from, in words; empty: they are simulated."""
    return "; ".join(dict.fromkeys(row[COLUMN] for row in rows if row.get(COLUMN)))


def is_imported(row: Mapping[str, Any]) -> bool:
    """Return whether a row is from a log: of the stimulus's speed and path nothing is known then."""
    return bool(row.get(COLUMN))


def drawn_here(record: TrialRecord) -> TrialRecord:
    """Return a record that names what draws in this process, and the hash of its reference frame."""
    from colias_sim import gl  # not before: declarations of claims import this module
    from colias_sim.reference import reference_hash

    renderer = gl.renderer()  # empty before anything was drawn, as by a policy that senses the state
    return replace(record, renderer=renderer, pixels=reference_hash() if renderer else "")
