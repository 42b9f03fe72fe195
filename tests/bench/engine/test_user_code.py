"""What a user's model does to the process, to its frame or to our streams costs nobody else anything."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

import colias_sim  # noqa: F401 - registers the envs
from dsnn.frames import frozen
from experiments.bench.cli import main as cli
from experiments.bench.engine.model_runner import ModelRunner
from experiments.bench.engine.models import choose, load_model
from experiments.bench.engine.user_code import apart
from experiments.bench.leaderboard.timing import time_models
from experiments.bench.reproduction import report, reproduce
from experiments.bench.reproduction.plan import QUICK
from experiments.wiring import build
from tests.helpers import user_files

TOP = "import ctypes, os, sys\nimport cv2\nimport numpy as np\n"


def write_model(place: Path, name: str, step: str, top: str = "") -> str:
    """The README's model called ``name``, which does ``step`` at every frame; its path."""
    text = user_files.MODEL.replace('"gradient"', f'"{name}"')
    text = text.replace("        down, right", f"        {step}\n        down, right")
    path = place / f"{name}.py"
    path.write_text(f"{TOP}{text.replace('from __future__ import annotations', '')}\n{top}\n")
    return str(path)


@pytest.fixture
def deaf() -> Iterator[None]:
    """Ctrl-C is taken otherwise than by Python, as in workers and commands."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def hearing() -> Iterator[None]:
    """Ctrl-C is taken by Python's own handler, also where the tests were started in the background, deaf to it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


MEDDLES = {
    "folder": "os.chdir('/')",
    "errors": "np.seterr(all='raise')",
    "threads": "cv2.setNumThreads(2)",
    "optimized": "cv2.setUseOptimized(False)",
    "stream": "sys.stdout = open(os.devnull, 'w')",
}


def process() -> tuple[Any, ...]:
    return os.getcwd(), np.geterr(), cv2.getNumThreads(), cv2.useOptimized(), sys.stdin, sys.stdout, sys.stderr  # noqa: PTH109


def seen_by_a_runner(path: str) -> None:
    runner = ModelRunner(choose(path), (24, 32))
    assert runner.see(np.zeros((24, 32), np.uint8)) is not None, runner.trouble


def seen_in_an_env(path: str) -> None:
    model = build(path, (24, 32))
    model.reset()
    model.step(np.zeros((24, 32), np.uint8))


def timed(path: str) -> None:
    assert time_models([choose(path)], (24, 32))


@pytest.mark.filterwarnings("ignore::ResourceWarning")
@pytest.mark.parametrize("what", MEDDLES)
@pytest.mark.parametrize("show", [seen_by_a_runner, seen_in_an_env, timed], ids=lambda show: show.__name__)
def test_what_a_model_changes_of_the_process_is_put_back(show: Callable[[str], None], what, tmp_path):
    before = process()
    show(write_model(tmp_path, f"steps-{what}", MEDDLES[what]))
    assert process() == before
    show(write_model(tmp_path, f"imports-{what}", "pass", top=MEDDLES[what]))
    assert process() == before


def test_a_folder_that_is_gone_is_no_trouble(tmp_path, monkeypatch):
    place = tmp_path / "gone"
    place.mkdir()
    monkeypatch.chdir(place)
    place.rmdir()
    assert apart(lambda: 3) == 3


def test_a_frame_has_a_shape_and_type_of_its_own_for_each():
    luma = np.arange(6, dtype=np.uint8).reshape(2, 3)
    first = frozen(luma)
    second = frozen(first)
    second.shape = (-1,)
    second.dtype = np.int8
    assert (first.shape, first.dtype) == ((2, 3), np.uint8) and not second.flags.writeable


def test_ctrl_c_while_a_file_is_imported_is_the_person_s(hearing, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        load_model(str(path))


@pytest.mark.parametrize("raises", ["KeyboardInterrupt", "BaseException", "SystemExit"])
def test_whatever_a_model_raises_costs_the_others_no_timing(raises, deaf, tmp_path):
    path = write_model(tmp_path, f"odd-{raises}", f"raise {raises}")
    assert set(time_models([choose("emd"), choose(path)], (24, 32))) == {"emd"}


@pytest.mark.parametrize("failed", [False, True])
def test_a_reproduction_says_by_its_status_whether_trials_failed(failed, monkeypatch, tmp_path):
    failures = [SimpleNamespace(model="odd")] if failed else []
    reproduction = reproduce.Reproduction(
        folder=tmp_path, scale=QUICK, seed=0, claims=[], pooled={},
        runs=[(None, SimpleNamespace(failures=failures))], offline=[], sensitivity=None, behaviours=[],
        own_claims=[], failures={"replicates": []}, description={}, readings=[],
    )  # fmt: skip
    monkeypatch.setattr(reproduce, "reproduce", lambda *_: reproduction)
    monkeypatch.setattr(report, "write", lambda _: tmp_path)
    assert cli.command(["reproduce", "--quick", "--quiet", "--out", str(tmp_path)]) == int(failed)


def test_a_closed_output_is_one_line(colias):
    write_model(colias.folder, "shut", "sys.stdout.close()")
    small = ("--set", "plain.rows=48", "--set", "plain.columns=64")
    done = colias("play", "plain", *small, "--no-view", "--model", "shut.py", "--record", "seen.rrd")
    assert (done.returncode, done.stderr) == (2, "colias: standard output: I/O operation on closed file.\n")


@pytest.mark.parametrize("method", ["step", "__init__", "reset"])
def test_sys_exit_in_a_model_of_an_env_does_not_end_the_program(method):
    class Leaves:
        def __init__(self, shape=None):
            if method == "__init__":
                sys.exit(0)

        def step(self, frame):
            sys.exit(0)

        def reset(self):
            sys.exit(0)

    with pytest.raises(RuntimeError, match="SystemExit: 0"):
        model = build(Leaves, (72, 99))
        model.reset() if method == "reset" else model.step(np.zeros((72, 99), np.uint8))
