"""``--out`` where nothing can be written: one line that names the option, its value and why, before anything is run."""

from __future__ import annotations

import os
import re
import tempfile
import warnings
from pathlib import Path

import pytest
import typer.main

import experiments
from experiments.bench.cli import main
from experiments.bench.engine.errors import UsageError
from experiments.bench.store.places import check_file, check_folder

COMMANDS = {
    "run": ["speed"],
    "study": ["fidelity"],
    "map": ["general", "--over", "experiment.acceleration_cm_s2=10,17"],
    "reproduce": ["--quick"],
    "leaderboard": [],
    "tune": [],
    "fit": ["fit-ideal"],
    "train": [],
    "behave": ["still"],
    "rerun": ["there"],
    "firmware budget": [],
    "firmware loop": ["speed"],
    "firmware decode": ["serial.txt"],
    "video": ["there.rrd"],
    "import": ["log.csv"],
    "export": ["there", "--to", "csv"],
    "stimulus": ["grating"],
}
"""Every command with ``--out`` -> what it needs to get that far. ``doctor`` tells of the folder as a finding."""
NOBODY = 65534
ENDINGS = {"video": ".mp4", "stimulus": ".avi"}


def with_out(command=None, name=""):
    """The names of all commands that have the option."""
    command = command or typer.main.get_command(main.app)
    names = {name} if any("--out" in parameter.opts for parameter in command.params) else set()
    for sub_name, sub in getattr(command, "commands", {}).items():
        names |= with_out(sub, f"{name} {sub_name}".strip())
    return names


def test_every_command_with_the_option_is_tried_here():
    assert with_out() == {*COMMANDS, "doctor"}


@pytest.mark.parametrize("name", COMMANDS)
def test_an_impossible_place_is_one_line_that_names_the_option(name, tmp_path, monkeypatch):
    if name in ("train", "fit"):
        pytest.importorskip({"train": "stable_baselines3", "fit": "optuna"}[name])
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    (tmp_path / "there").mkdir()
    before = sorted(tmp_path.rglob("*"))
    places = {f"file/out{ENDINGS.get(name, '')}": "file is a file, not a folder"}
    if Path("/proc/self").is_dir():
        places[f"/proc/none/out{ENDINGS.get(name, '')}"] = r"/proc/none cannot be made \(No such file or directory\)"
    for place, why in places.items():
        with pytest.raises(UsageError, match=rf"^--out {place}: \S*{why}$") as told:
            main.command([*name.split(), *COMMANDS[name], "--out", place])
        assert "\n" not in str(told.value)
    assert sorted(tmp_path.rglob("*")) == before, "nothing is left"


def test_the_python_function_names_its_argument(tmp_path):
    (tmp_path / "file").write_text("")
    place = tmp_path / "file" / "out"
    with pytest.raises(UsageError, match=rf"^out={re.escape(str(place))}: .* is a file, not a folder$"):
        experiments.run("speed", out=place)


def test_the_exit_status_is_2(colias):
    (colias.folder / "file").write_text("")
    done = colias("run", "speed", "--out", "file/out")
    assert (done.returncode, done.stderr) == (2, "colias: --out file/out: file is a file, not a folder\n")


def refused(folder):
    """What `check_folder` says in a process without root's rights; empty where it says nothing."""
    reader, writer = os.pipe()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # of fork beside threads: the child calls nothing of theirs
        child = os.fork()
    if child == 0:
        message = ""
        try:
            if os.geteuid() == 0:
                os.setgid(NOBODY)
                os.setuid(NOBODY)
            check_folder(folder, f"--out {folder}")
        except BaseException as error:
            message = str(error)
        finally:
            os.write(writer, message.encode())
            os._exit(0)
    os.waitpid(child, 0)
    os.close(writer)
    with os.fdopen(reader) as stream:
        return stream.read()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_no_permission_is_told():
    with tempfile.TemporaryDirectory() as name:
        locked = Path(name).resolve()
        if not all(parent.stat().st_mode & 0o001 for parent in locked.parents):
            pytest.skip("another user comes to no folder for temporary files")
        locked.chmod(0o555)
        for out in (locked / "out", locked):
            told = refused(out)
            assert told.startswith(f"--out {out}: {locked}/") and told.endswith("cannot be made (Permission denied)")
        locked.chmod(0o777)
        assert refused(locked / "a" / "out") == "" and not list(locked.iterdir())


def test_what_can_be_written_is_left_as_it_is(tmp_path):
    (tmp_path / "kept").write_text("kept")
    for folder in (tmp_path, tmp_path / "a" / "b"):
        check_folder(folder, "--out x")
        check_file(folder / "clip.avi", "--out x")
    assert [path.name for path in tmp_path.rglob("*")] == ["kept"]


def test_a_name_that_no_file_can_have_is_told_before_the_work(tmp_path):
    with pytest.raises(UsageError, match=r"^--out long: .* cannot be made \(File name too long\)$"):
        check_file(tmp_path / ("x" * 300), "--out long")
