"""The infos of many envs: packed for a pipe, and in the form that Gymnasium's vector envs give."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np

from colias_sim.envs.hosting import Row

Group = tuple[tuple[str, ...], list[int], list[tuple[Any, ...]]]
"""Infos that have the same keys, as a table: keys, the envs' numbers, a row of values for each."""
Add = Callable[[dict[str, Any], dict[str, Any], int], dict[str, Any]]
"""`gymnasium.vector.VectorEnv._add_info`."""


def packed(rows: Iterable[Row]) -> list[Group]:
    """Neighbours of the same keys together: the keys are sent once."""
    groups = groupby(rows, key=lambda row: tuple(row[1]))
    return [
        (keys, *map(list, zip(*((index, tuple(info.values())) for index, info in members), strict=True)))  # type: ignore[misc]
        for keys, members in groups
    ]


def merged(groups: Sequence[Group], count: int, add: Add) -> dict[str, Any]:
    """One dict for all of ``count`` envs: a key has an array, and as ``_key`` a mask of who has it."""
    if len({keys for keys, _, _ in groups}) == 1:
        table = _as_columns(groups, count)
        if table is not None:
            return table
    infos: dict[str, Any] = {}
    for keys, indices, rows in groups:
        for index, values in zip(indices, rows, strict=True):
            infos = add(infos, dict(zip(keys, values, strict=True)), index)
    return infos


def _as_columns(groups: Sequence[Group], count: int) -> dict[str, Any] | None:
    """What `Add` makes of plain numbers, one of each key from each env, in a tenth of its time; else ``None``."""
    indices = [index for _, some, _ in groups for index in some]
    rows = [row for _, _, some in groups for row in some]
    if indices != list(range(count)):
        return None
    infos: dict[str, Any] = {}
    for key, column in zip(groups[0][0], zip(*rows, strict=True), strict=True):
        (kind, *others) = {type(value) for value in column}
        if others or kind not in (float, bool, int):
            return None
        infos[key], infos[f"_{key}"] = np.array(column, kind), np.ones(count, np.bool_)
    return infos
