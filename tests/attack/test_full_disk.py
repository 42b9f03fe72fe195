"""Small disks, mounted: every command ends, nothing cut has a final name, and no row is lost for its recording.

Where nothing may be mounted these are skipped. tests/bench/store/test_full_disk.py has the same laws on small files.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pyarrow.parquet as pq
import pytest
from PIL import Image

from experiments.bench.engine.errors import UsageError
from experiments.bench.store.pictures import pictures
from tests.attack.commands import film
from tests.attack.interrupts import JOBS, Job, furnish, unreadable
from tests.attack.judging import expect_none
from tests.attack.processes import Ended, colias
from tests.attack.scale import FULL
from tests.helpers.disks import small_disk, whole_recording

pytestmark = pytest.mark.attack

PAGE = 4096
FRAMES = 300
TRIES = 18
"""With a full TMPDIR: of so many, 4 did not end."""


def wrong(ended: Ended, folder: Path, legal: tuple[int, ...] = (0, 1, 2)) -> list[str]:
    """Everything about a command's end and its files that is never right."""
    faults = [f"says {word!r}: {ended.err[-300:]}" for word in ended.crashes()]
    if ended.status is None:
        return [*faults, "does not end"]
    if ended.status not in legal:
        faults.append(f"exit status {ended.status}: {ended.err[-300:]}")
    if ended.status and "MB are free in " not in ended.err:
        faults.append(f"does not name the disk: {ended.err[-300:]}")
    return [*faults, *(f"left a process: {left}" for left in ended.left), *unreadable(folder), *cut(folder)]


def cut(folder: Path) -> Iterator[str]:
    """Recordings, pictures and videos that are not whole, though they have their names."""
    for path in folder.rglob("*"):
        whole = True
        if path.suffix == ".rrd":
            whole = whole_recording(path)
        elif path.suffix == ".svg":
            whole = path.read_bytes().rstrip().endswith(b"</svg>")
        elif path.suffix == ".png":
            try:
                np.asarray(Image.open(path))
            except OSError:
                whole = False
        if not whole:
            yield f"{path.name} is cut"


def frames(recording: Path) -> int:
    """How many frames can be read of a recording of footage."""
    try:
        return len(pictures(recording)["picture"])
    except UsageError:
        return 0


@pytest.fixture(scope="module")
def footage(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """A folder with a film, and the size of its recording."""
    folder = tmp_path_factory.mktemp("footage")
    film(folder / "film.avi", FRAMES)
    ended = colias(folder, ["watch", "film.avi", "--no-view", "--record", "out.rrd"])
    assert ended.status == 0, ended
    size = (folder / "out.rrd").stat().st_size
    (folder / "out.rrd").unlink()
    return folder, size


def test_a_watched_film_is_recorded_whole_or_the_command_fails(footage, tmp_path):
    """The last pages hold the footer alone: a disk that is full there cut it, and the exit status was 0."""
    folder, size = footage
    pages = -(-size // PAGE)
    counts = {1, 2, pages // 3, pages // 2, *range(pages - 4, pages + 4)} if not FULL else range(1, pages + 8)
    faults = []
    for count in sorted(counts):
        with small_disk(tmp_path / "disk", count * PAGE) as disk:
            out = disk / "out.rrd"
            ended = colias(folder, ["watch", "film.avi", "--no-view", "--record", str(out)], timeout_s=60)
            disk_faults = wrong(ended, disk, (0, 1))
            if ended.status == 0 and not out.exists():
                disk_faults.append("exit status 0 without a recording")
            if out.exists():
                disk_faults += [] if ended.status == 0 else ["a name in spite of a failure"]
                disk_faults += [] if frames(out) == FRAMES else ["frames are missing"]
            if ended.status == 0 and count <= pages // 2:
                disk_faults.append("exit status 0 where there is no room")
            faults += [f"{count} of {pages} pages: {fault}" for fault in disk_faults]
    expect_none(faults)


RUN = ("run", "tiny.py", "--repeats", "2", "-q")


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, int]:
    """A run with all the room it needs, and the size of its largest recording."""
    folder = tmp_path_factory.mktemp("whole")
    furnish(folder)
    ended = colias(folder, [*RUN, "--workers", "2", "--out", "out"])
    assert ended.status == 0, ended
    return folder, max(path.stat().st_size for path in (folder / "out" / "recordings").iterdir())


def rows(run: Path) -> list[dict[str, Any]]:
    trials = pq.read_table(run / "trials.parquet").to_pylist() if (run / "trials.parquet").exists() else []
    return [{name: value for name, value in row.items() if name not in ("wall_s", "code")} for row in trials]


@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_full_folder_for_temporary_files_costs_no_trial_and_no_time(workers, whole, tmp_path):
    faults = []
    for number in range(TRIES if workers == "0" or FULL else 2):
        folder = tmp_path / f"{number}"
        folder.mkdir()
        furnish(folder)
        with small_disk(tmp_path / "tmp", (1 + number) * 4 * PAGE) as temporary:
            (temporary / "full").write_bytes(bytes((1 + number) * 4 * PAGE - 2 * PAGE))
            environment = {"TMPDIR": str(temporary)}
            words = [*RUN, "--workers", workers, "--out", "out"]
            ended = colias(folder, words, environment=environment, timeout_s=90)
            try_faults = wrong(ended, folder, (0,))
            if rows(folder / "out") != rows(whole[0] / "out"):
                try_faults.append("other rows")
            if len(list((folder / "out" / "recordings").glob("*.rrd"))) != len(rows(folder / "out")):
                try_faults.append("recordings are missing")
        shutil.rmtree(folder)
        faults += [f"try {number}: {fault}" for fault in try_faults]
    expect_none(faults)


@pytest.mark.parametrize("workers", ["0", "2"])
def test_a_run_on_a_small_disk_loses_no_row_for_a_recording(workers, whole, tmp_path):
    """And with more room it is gone on with, to the same rows."""
    folder, size = whole
    faults = []
    spaces = [4 * PAGE, 30 * PAGE, size + 10 * PAGE, 2**21 + 2 * size]
    spaces += [10 * PAGE, size // 2, 3 * size] if FULL else []
    for space in spaces:
        with small_disk(tmp_path / "disk", space) as disk:
            run = [*RUN, "--workers", workers]
            ended = colias(folder, [*run, "--out", str(disk / "out")], timeout_s=90)
            disk_faults = wrong(ended, disk)
            done = rows(disk / "out")
            if ended.status == 1 and done != rows(folder / "out"):
                disk_faults.append("rows were lost")
            if ended.status == 0:
                disk_faults.append("there is room for everything: a larger run is needed")
            stopped = re.search(r"stopped after (\d+) of", ended.err)
            if stopped and int(stopped[1]) != len(done):
                disk_faults.append(f"says {stopped[0]!r}, and {len(done)} trials are there")
            subprocess.run(["mount", "-o", f"remount,size={2**26}", str(disk)], check=True)
            again = colias(folder, [*run, "--out", str(disk / "out")], timeout_s=90)
            disk_faults += [f"gone on with: {fault}" for fault in wrong(again, disk, (0,))]
            if rows(disk / "out") != rows(folder / "out"):
                disk_faults.append("gone on with: other rows")
            if len(list((disk / "out" / "recordings").glob("*.rrd"))) != len(rows(folder / "out")):
                disk_faults.append("gone on with: recordings are missing")
            faults += [f"{space} bytes: {fault}" for fault in disk_faults]
    expect_none(faults)


OTHERS = ("run-clips", "map", "tune", "behave", "play", "stimulus", *(("leaderboard", "reproduce") if FULL else ()))


@pytest.mark.parametrize("job", [job for job in JOBS if job.name in OTHERS], ids=lambda job: job.name)
def test_every_command_ends_on_a_full_disk(job: Job, tmp_path):
    """It says where there is no room, and what it leaves is whole."""
    furnish(tmp_path)
    faults = []
    for pages in (1, 8, 24, 64) if FULL else (1, 24):
        with small_disk(tmp_path / "disk", pages * PAGE) as disk:
            words = [f"disk/{word}" if word.startswith("out") else word for word in job.words]
            ended = colias(tmp_path, words, timeout_s=300)
            disk_faults = wrong(ended, disk)
            lines = [line for line in ended.err.splitlines() if not line.startswith("cluttered: frames: ")]
            if job.name in ("play", "stimulus") and ended.status and len(lines) != 1:
                disk_faults.append(f"says more than a line: {ended.err[-300:]}")
            if ended.status == 0:
                disk_faults += [f"exit status 0 without {name}" for name in job.makes if not (disk / name).exists()]
            for video in disk.glob("*.avi"):
                count = 0
                capture = cv2.VideoCapture(str(video))
                while capture.grab():
                    count += 1
                truth = video.with_suffix(".csv")
                told = truth.read_text().splitlines() if truth.exists() else []
                disk_faults += [] if count == len(told) - 1 else [f"{video.name} has {count} frames"]
            faults += [f"{pages} pages: {fault}" for fault in disk_faults]
    expect_none(faults)
