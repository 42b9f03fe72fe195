"""SIGINT at moments of the first three seconds of every command: one quiet end, and nothing lost or left.

Thirty moments, each in one of the commands; with COLIAS_ATTACK_FULL=1 all thirty in each command, with
COLIAS_ATTACK_MOMENTS=N so many.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from tests.attack.interrupts import JOBS, Job, go_on, problems, share
from tests.attack.judging import expect_none
from tests.attack.scale import FULL

pytestmark = pytest.mark.attack

AT_ONCE = 6
"""Moments in one test, so that two workers share them."""


def _parts(job: Job) -> list[tuple[Job, int]]:
    if job.name == "view":  # its port is one for the machine
        return [(job, -1)]
    return [(job, first) for first in range(0, job.count(), AT_ONCE)]


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("shared")
    share(folder)
    return folder


@pytest.mark.parametrize(
    ("job", "first"), [part for job in JOBS for part in _parts(job)], ids=lambda v: v.name if isinstance(v, Job) else v
)
def test_an_interrupt_at_any_moment(job, first, shared, tmp_path):
    moments = job.moments() if first < 0 else job.moments()[first : first + AT_ONCE]
    faults = []
    for number, when in enumerate(moments):
        folder = tmp_path / f"{number}"
        folder.mkdir()
        for path in shared.iterdir():
            if path.is_file():
                os.link(path, folder / path.name) if path.suffix != ".py" else shutil.copy(path, folder)
        faults += problems(job, when, folder)
        if job.again and number == len(moments) // 2 and (FULL or job.name.startswith("run")):
            faults += go_on(job, folder)
    expect_none(faults)
