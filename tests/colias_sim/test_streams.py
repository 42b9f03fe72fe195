"""Standard streams that are closed, full or broken; memory that is limited; what is printed for people."""

from __future__ import annotations

import csv
import json
import os
import re
import resource
import subprocess
import sys
from functools import partial
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from experiments.bench.doctor import memory
from tests.helpers.processes import CLI, QUICK, start

ROOT = Path(__file__).parents[2]
COMMAND = " ".join((*CLI, "run", "speed", *QUICK))


def shell(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    environment = {k: v for k, v in os.environ.items() if "DISPLAY" not in k} | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        ["bash", "-c", script], cwd=folder, env=environment, capture_output=True, text=True, timeout=300, check=False
    )


def whole(folder: Path) -> bool:
    return pq.read_table(folder / "trials.parquet").num_rows == 1 and (folder / "figure.png").stat().st_size > 10_000


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&-", "<&- >&- 2>&-"])
def test_closed_streams_cost_nothing(tmp_path, closed):
    """Where all are, they are for a worker process too."""
    workers = 1 if closed.count("&-") > 1 else 0
    done = shell(tmp_path, f"{COMMAND} --workers {workers} {closed}")
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    assert whole(tmp_path / "out")


def test_a_full_output_is_one_line_more_and_loses_no_file(tmp_path):
    done = shell(tmp_path, f"{COMMAND} -q --set camera.fps=30; {CLI[0]} -m {CLI[2]} list > /dev/full")
    assert whole(tmp_path / "out")
    assert (done.returncode, done.stderr) == (2, "colias: standard output: No space left on device\n")


def test_a_pipe_nobody_reads_is_no_error_to_tell_of(tmp_path):
    done = shell(tmp_path, f"({CLI[0]} -m {CLI[2]} list; echo $? > status) | true; cat status")
    assert (done.stdout.strip(), done.stderr) in {("1", ""), ("0", "")}  # 0: it was written before the reader went


@pytest.mark.parametrize("mb", [150, 600, 900])
def test_too_little_memory_is_one_line(tmp_path, mb):
    """It is told before a library is loaded: with 600 MB one of them ended in a segmentation fault, now and then."""
    limit = partial(resource.setrlimit, resource.RLIMIT_AS, (mb << 20, mb << 20))
    done = subprocess.run(
        [*CLI, "run", "speed", *QUICK, "-q"], cwd=tmp_path, capture_output=True, text=True, preexec_fn=limit,
        timeout=300, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith("colias: ") and f"{mb} MB of address space" in line and "it needs 1,200 MB" in line


def test_the_memory_asked_for_is_enough(tmp_path):
    limit = partial(resource.setrlimit, resource.RLIMIT_AS, (memory.LEAST_MB << 20, memory.LEAST_MB << 20))
    done = subprocess.run(
        [*CLI, "run", "speed", *QUICK, "-q"], cwd=tmp_path, capture_output=True, text=True, preexec_fn=limit,
        timeout=300, env=os.environ | {"PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")


def test_a_quiet_run_says_nothing_where_no_home_can_be_written(tmp_path):
    """Matplotlib would tell of its temporary folder."""
    environment = {"HOME": "/proc/nowhere", "MPLCONFIGDIR": "/proc/nowhere", "PYTHONPATH": str(ROOT)}
    process = start(tmp_path, *CLI, "run", "speed", *QUICK, "-q", **environment)
    assert process.communicate(timeout=200) == ("", "")
    assert process.returncode == 0


NOBODY = """
import os, pwd
def unknown(uid):
    raise KeyError(f"getpwuid(): uid not found: {uid}")
pwd.getpwuid = unknown
from experiments.bench.cli.entry import main
main()
"""


def test_a_user_without_a_home_gets_rows(tmp_path):
    """As in a container that is started with any number for a user."""
    environment = {name: value for name, value in os.environ.items() if name not in ("HOME", "XDG_CACHE_HOME")}
    command = [sys.executable, "-c", NOBODY, "run", "speed", *QUICK, "--workers", "0", "--out", "out", "-q"]
    done = subprocess.run(
        command, cwd=tmp_path, env=environment | {"PYTHONPATH": str(ROOT)}, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    assert pq.read_table(tmp_path / "out" / "trials.parquet").num_rows
    assert len(json.loads((tmp_path / "out" / "experiment.json").read_text())["reference_frames"][0]) == 12


def test_one_episode_has_no_interval_and_a_robot_at_rest_a_gain_of_0(colias):
    done = colias("behave", "optomotor", "--episodes", "1", "--out", "out", "--no-recordings", "--workers", "0")
    assert done.returncode == 0, done.stderr
    assert "nan" not in done.stdout and not re.search(r"\de-\d", done.stdout)
    with (colias.folder / "out" / "scores.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["ci_low"], row["ci_high"]) for row in rows} == {("", "")}
    still = colias("behave", "still", "--env", "Optomotor", "--episodes", "3", "--no-baselines", "--no-recordings",
                   "--out", "still", "--workers", "0")  # fmt: skip
    assert still.returncode == 0, still.stderr
    assert re.search(r"still +0 ", still.stdout), still.stdout
    assert pq.read_table(colias.folder / "still" / "trials.parquet")["optomotor_gain"].to_pylist() == [0.0] * 3


def test_one_repeat_leaves_empty_cells_in_a_map(colias):
    grid = ("--measure", "spikes", "--over", "dsnn.n_con=4,8")
    done = colias("map", "speed", *QUICK[:4], *grid, "--out", "out", "--workers", "0")
    assert done.returncode == 0, done.stderr
    with (colias.folder / "out" / "counts.csv").open() as file:
        assert {(row["n"], row["ci_low"], row["ci_high"]) for row in csv.DictReader(file)} == {("1", "", "")}


def test_a_run_says_its_size_at_once_and_the_time_left_by_its_first_trials(tmp_path):
    command = (*CLI, "run", "speed", "--set", "experiment.speeds_cm_s=20,30", "--repeats", "200")
    process = start(tmp_path, *command, "--no-recordings", "--workers", "1", PYTHONPATH=str(ROOT))
    assert process.stderr is not None
    first, second = process.stderr.readline(), process.stderr.readline()
    process.kill()
    process.communicate(timeout=20)
    assert re.fullmatch(r"speed: 400 trials, about [\d,]+ frames, on 1 worker, into runs/speed-\d+-\d+\n", first)
    assert re.fullmatch(r"about \d+ (s|min) left, by the first 2 trials\n", second), second


def test_the_time_left_goes_by_the_size_of_what_is_left():
    """Two workers, the first job of each not counted: it has the worker's start in it."""
    from experiments.bench.engine.terminal import Pace

    pace = Pace(whole=100.0, width=2)
    for size, now in ((10.0, 5.0), (10.0, 5.0), (4.0, 7.0)):
        pace.add(size, now)
    assert pace.left_s() is None
    pace.add(6.0, 9.0)
    assert pace.left_s() == pytest.approx(70.0 * 4.0 / 10.0)
    assert pace.said() == "about 28 s left"


def test_recordings_are_those_of_the_behaviour_itself(colias):
    done = colias("behave", "still", "--env", "Fixation", "--episodes", "2", "--out", "out", "--workers", "1")
    assert done.returncode == 0, done.stderr
    assert "; those of still are recorded" in done.stderr and "(the episodes of still)" in done.stdout
    rows = pq.read_table(colias.folder / "out" / "trials.parquet").to_pylist()
    recordings = {f"trial-{row['trial']:04d}.rrd" for row in rows if row["model"] == "still"}
    assert len(rows) > 2
    assert {path.name for path in (colias.folder / "out" / "recordings").iterdir()} == recordings


@pytest.mark.parametrize("display", [None, ":7654321"])
def test_a_viewer_without_a_screen_is_one_line(tmp_path, display):
    (tmp_path / "some.rrd").write_bytes(b"")
    given = {"DISPLAY": display} if display else {}
    process = start(tmp_path, *CLI, "view", "some.rrd", PYTHONPATH=str(ROOT), **given)
    _, errors = process.communicate(timeout=100)
    assert (process.returncode, errors.count("\n")) == (2, 1), errors
    assert "Rerun's viewer" in errors and "use --web" in errors and ".rs:" not in errors


def test_library_code_leaves_the_exit_to_the_command_line():
    """Only the modules of the command line know of its parser."""
    modules = ("robot.table", "robot.run", "training.evaluate", "reproduction.report", "leaderboard.run")
    code = f"import sys, {', '.join(f'experiments.bench.{name}' for name in modules)}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert "typer" not in done.stdout.split()
