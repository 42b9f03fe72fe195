"""The infos of many envs: packed for a pipe, and merged as in Gymnasium's vector envs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby
from typing import Any

import numpy as np
import numpy.typing as npt

InfoRow = tuple[int, dict[str, Any]]
"""The number of an env, and one of its infos."""
InfoTable = tuple[tuple[str, ...], list[int], list[tuple[Any, ...]]]
"""Infos with the same keys: the keys, the numbers of the envs, and a row of values for each."""


def pack_infos(rows: Iterable[InfoRow]) -> list[InfoTable]:
    """Group neighbouring infos with the same keys into tables, so that the keys are sent once.

    Parameters
    ----------
    rows
        The infos, in order.

    Returns
    -------
    list of InfoTable
        The same infos, in the same order.
    """
    groups = groupby(rows, key=lambda row: tuple(row[1]))
    return [
        (keys, *map(list, zip(*((index, tuple(info.values())) for index, info in members), strict=True)))  # type: ignore[misc]
        for keys, members in groups
    ]


def merge_infos(tables: Sequence[InfoTable], count: int) -> dict[str, Any]:
    """Merge the infos of all envs into one dict, equal to that of `gymnasium.vector.SyncVectorEnv`.

    Parameters
    ----------
    tables
        The infos, packed.
    count
        The number of envs.

    Returns
    -------
    dict
        For each key an array (count, ...), and as ``_key`` a mask, (count,) bool, of the envs that have it. The entry
        of a dict is such a dict.
    """
    if len({keys for keys, _, _ in tables}) == 1:
        merged = _merge_columns(tables, count)
        if merged is not None:
            return merged
    infos: dict[str, Any] = {}
    for keys, indices, rows in tables:
        for index, values in zip(indices, rows, strict=True):
            _add(infos, dict(zip(keys, values, strict=True)), index, count)
    return infos


def _merge_columns(tables: Sequence[InfoTable], count: int) -> dict[str, Any] | None:
    """Merge plain numbers, one of each key from each env, in a tenth of the time; ``None`` for other infos."""
    indices = [index for _, some, _ in tables for index in some]
    rows = [row for _, _, some in tables for row in some]
    if indices != list(range(count)):
        return None
    infos: dict[str, Any] = {}
    for key, column in zip(tables[0][0], zip(*rows, strict=True), strict=True):
        (kind, *others) = {type(value) for value in column}
        if others or kind not in (float, bool, int):
            return None
        infos[key], infos[f"_{key}"] = np.array(column, kind), np.ones(count, np.bool_)
    return infos


def _add(infos: dict[str, Any], info: dict[str, Any], index: int, count: int) -> None:
    """Add the info of env ``index`` to the merged ``infos``, by the rules of Gymnasium's vector envs."""
    for key, value in info.items():
        if isinstance(value, dict) and key != "final_obs":
            infos.setdefault(key, {})
            _add(infos[key], value, index, count)
        else:
            if key not in infos:
                infos[key] = _empty(key, value, count)
            infos[key][index] = value
        infos.setdefault(f"_{key}", np.zeros(count, np.bool_))[index] = True


def _empty(key: str, value: Any, count: int) -> npt.NDArray[Any]:
    """Return the array of a key, of the type of its first value; objects unless that is a number or an array."""
    if key != "final_obs":
        if type(value) in (int, float, bool) or isinstance(value, np.number):
            return np.zeros(count, type(value))
        if isinstance(value, np.ndarray):
            return np.zeros((count, *value.shape), value.dtype)
    return np.full(count, None, dtype=object)
