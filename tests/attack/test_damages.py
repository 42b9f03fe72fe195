"""Going on with damaged folders: one line and nothing touched, or the tables of the whole run.

A hundred damages; with COLIAS_ATTACK_FULL=1 all there are.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from tests.attack.damages import DAMAGES, Damage
from tests.attack.folders import KINDS, copied, go_on, problems, state, tables
from tests.attack.judging import expect_none
from tests.attack.scale import FULL, some

pytestmark = pytest.mark.attack
SHARES = {"robot": 86, "clips": 14}
"""How many of each kind; in the full attack all, and those of other kinds, whose runs take the longest to make."""
SHOWN = [
    damage
    for kind in KINDS
    for damage in some([damage for damage in DAMAGES if damage.kind == kind], SHARES.get(kind, 0))
]
RunOf = Callable[[str], tuple[Path, dict[str, Any]]]


def test_there_are_enough_of_them():
    names = [(damage.kind, damage.name) for damage in DAMAGES]
    assert len(set(names)) == len(names) >= len(SHOWN) >= 100
    assert sum("flipped" in name for _, name in names) >= 30


@pytest.mark.parametrize("damage", SHOWN, ids=lambda damage: f"{damage.kind}-{damage.name}")
def test_a_damaged_folder_is_refused_or_mended(damage: Damage, run_of: RunOf, tmp_path):
    folder, whole = run_of(damage.kind)
    expect_none(problems(damage, folder, tmp_path / "work", whole))


@pytest.mark.parametrize("kind", KINDS if FULL else SHARES)
def test_a_whole_folder_is_gone_on_with(kind, run_of: RunOf, tmp_path):
    """The measure of all others: without damage the same command ends with 0, and leaves what was there."""
    folder, whole = run_of(kind)
    faults = problems(Damage("none", kind, lambda scene: None), folder, tmp_path / "work", whole)
    expect_none(faults)
    ended = go_on(tmp_path / "work", kind)
    assert (ended.status, ended.err) == (0, "")


@pytest.mark.skipif(os.geteuid() == 0, reason="nothing is read-only to root")
def test_a_folder_that_is_read_only_is_one_line(run_of: RunOf, tmp_path):
    folder, _ = run_of("robot")
    copied(folder, tmp_path / "work")
    out = tmp_path / "work" / "out"
    (out / "trials.parquet").unlink()
    for path in (out / "recordings", out):
        path.chmod(0o555)
    before = state(out)
    try:
        ended = go_on(tmp_path / "work", "robot")
        assert ended.status == 2 and ended.err.count("\n") == 1, ended
        assert state(out) == before
    finally:
        for path in (out, out / "recordings"):
            path.chmod(0o755)


def test_two_tables_of_one_run_are_equal(run_of: RunOf):
    """That tables are compared at all: another seed has others."""
    folder, whole = run_of("robot")
    assert tables(folder / "out") == whole != tables(folder / "other")
