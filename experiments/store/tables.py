"""Results of a trial: rows of declared columns, frames, failures; and functions that group rows."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import TYPE_CHECKING, Any, get_args, get_type_hints

from experiments.base.user_code import traced
from experiments.settings.models import OF_CONTROL, without_control

if TYPE_CHECKING:
    import polars as pl

RECORDING = "(recording)"
"""Label in place of the model in the failure of a trial's recording. No model's label has parentheses."""

OBSERVER = "observer"
"""The robot that sees and, in an env, behaves: today's only value of the column ``robot``."""


JOB: Mapping[str, type] = {"experiment": str, "trial": int, "repeat": int, "seed": int, "model": str}
"""The columns that every row of a ``trials.parquet`` begins with: ``trial`` is the job's number in the run, ``seed``
that of all its random draws, ``model`` the label of the vision model, or the name of the behaviour, that responded."""
COUNTS: Mapping[str, type] = dict.fromkeys(("spikes", "hs_spikes", "vs_spikes", "looming_spikes"), int)
"""Spike counts of a model in a trial or a clip, null where the channel does not spike; ``spikes`` are those of HS, or
of looming where no direction is declared."""
PEAKS: Mapping[str, type] = dict.fromkeys(("peak_hs", "trough_hs", "peak_vs", "trough_vs", "peak_looming"), float)
"""The largest and the least potentials of a model in a trial: see `peaks`."""
FRAME: Mapping[str, type] = {"trial": int, "model": str, "frame": int}
"""The columns that every row of a ``frames.parquet`` begins with; frames are numbered from 0 up."""
RESPONSES: Mapping[str, type] = {"hs": float, "vs": float, "hs_spikes": int, "vs_spikes": int, "looming": float,
                                 "looming_spikes": int, "azimuth": float, "target": float,
                                 "elevation": float, "target_direction": float}  # fmt: skip
"""A `dsnn.ResponseSeries` at one frame."""


def columns_of(*kinds: type) -> dict[str, type]:
    """Return the fields of dataclasses that a table can have, with their types, in their order."""
    columns: dict[str, type] = {}
    for kind in kinds:
        for name, hint in get_type_hints(kind).items():
            given = next(part for part in get_args(hint) or (hint,) if part is not type(None))
            given = str if isinstance(given, str) else given  # of a Literal
            if given in (int, float, str, bool):  # a condition has paths too, which are no columns
                columns[name] = given
    return columns


def peaks(frames: pl.DataFrame) -> dict[str, float]:
    """Return the columns `PEAKS` of a model's frames."""
    highest = {f"peak_{channel}": float(frames[channel].to_numpy().max()) for channel in ("hs", "vs", "looming")}
    return highest | {f"trough_{channel}": float(frames[channel].to_numpy().min()) for channel in ("hs", "vs")}


def table(rows: Sequence[Mapping[str, Any]], schema: Mapping[str, Any]) -> pl.DataFrame:
    """Return rows as a table; missing values are null, and a value of another type than its column's raises."""
    import polars as pl  # not before: declarations of claims import this module

    return pl.DataFrame({name: [row.get(name) for row in rows] for name in schema}, schema)


@cache
def cpu_features() -> str:
    """Return the features of this machine's CPU by which OpenCV chooses its code, as do NumPy and the C library.

    With other features sums have another order, and products are contracted into them or not: last bits differ.
    """
    import cv2  # not before: declarations of claims import this module

    listed = cv2.getCPUFeaturesLine().replace("*", "").split()
    return " ".join(name for name in listed if not name.endswith("?"))  # the mark of those that the CPU lacks


@dataclass(frozen=True, slots=True)
class TrialRecord:
    """The result of a job: rows ready for the tables, and the bytes of its recording."""

    index: int
    rows: tuple[dict[str, Any], ...]
    frames: pl.DataFrame
    recording: bytes | str | None
    """Bytes of an .rrd file, or why there is none; ``None`` where none was asked for."""
    troubles: Mapping[str, str] = field(default_factory=dict)
    """Model that failed -> the traceback of what it raised; the rows of the others are there."""
    renderer: str = ""
    """Renderer of its frames (`colias_sim.gl.renderer`); empty where none were drawn."""
    pixels: str = ""
    """Hash of the reference frame where they were drawn (`colias_sim.reference`); empty where none were."""
    cpu: str = field(default_factory=cpu_features)
    """Features of the CPU that computed it (`cpu_features`)."""

    def __post_init__(self) -> None:
        for name, value in (item for row in self.rows for item in row.items()):
            if isinstance(value, float) and not math.isfinite(value):
                raise ValueError(f"trial {self.index}: {name} must be a finite number, or None, got {value}")


FAILURE: Mapping[str, type] = {"trial": int, "model": str, "condition": str, "seed": int, "reason": str}
"""Columns of what failed: a trial, a model in it, or its recording. ``model`` is empty for a whole trial, `RECORDING`
for its recording; ``reason`` is a traceback, or one line where an input was refused."""


def in_words(failures: Iterable[Mapping[str, Any]]) -> list[str]:
    """Return rows of `FAILURE` as texts, grouped by their reason, those of a model with those of its controls."""
    texts = []
    rows = [{**row, "shown": without_control(row["model"])} for row in failures]
    for (_, reason), (first, *others) in group(rows, "shown", "reason").items():
        trial, model = first["trial"], first["model"]
        if model == RECORDING:
            what = f"trial {trial} has no recording"
        elif model:
            what = f"{model} failed in trial {trial}"
        else:
            what = f"trial {trial} failed"
        more = f"\nThe same in {len(others)} more" if others else ""
        texts.append(f"{what} ({first['condition']}): {reason}{more}")
    return texts


def recording_of(make: Callable[[], bytes]) -> bytes | str:
    """Make the recording of a trial, or return the traceback; the trial's rows are not lost with it."""
    try:
        return make()
    except Exception as error:  # Rerun's, or too little memory
        return traced(error)


def group(rows: Iterable[Mapping[str, Any]], *keys: str) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """Return rows by the values of ``keys``, groups in order of first appearance."""
    groups: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def finite(value: float) -> float | None:
    """Return the value for a table: null instead of NaN."""
    return None if math.isnan(value) else value


COLUMN = "provenance"
"""Column that says where rows of a robot's log come from; simulated rows have none."""


def origin(rows: Sequence[Mapping[str, Any]]) -> str:
    """Return where rows come from; empty if they are simulated."""
    return "; ".join(dict.fromkeys(row[COLUMN] for row in rows if row.get(COLUMN)))


def is_imported(row: Mapping[str, Any]) -> bool:
    """Return whether a row is from a log: of the stimulus's speed and path nothing is known then."""
    return bool(row.get(COLUMN))


def without_controls(table: pl.DataFrame, shown: str = "model") -> pl.DataFrame:
    """Return the rows of models that were shown a trial as it was: claims, figures and ranks are about these.

    ``shown`` is the column of their labels.
    """
    return table.filter(~table[shown].str.contains(OF_CONTROL))


def drawn_here(record: TrialRecord) -> TrialRecord:
    """Return a record that names what draws in this process, and the hash of its reference frame."""
    from colias_sim import gl  # not before: declarations of claims import this module
    from colias_sim.reference import reference_hash

    renderer = gl.renderer()  # empty before anything was drawn, as by a policy that senses the state
    return replace(record, renderer=renderer, pixels=reference_hash() if renderer else "")
