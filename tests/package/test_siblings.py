"""A stranger's package of a name of ours: `colias_sim` says so when it is imported, and says nothing else."""

import subprocess
import sys

import pytest

HIDING = {
    "a package": ("experiments/__init__.py", "experiments"),
    "a file": ("experiments.py", "experiments"),
    "imported first": ("dsnn/__init__.py", "dsnn"),
    "of what it needs itself": ("scenes/__init__.py", "scenes"),
}


def python(folder, code, *options):
    command = [sys.executable, *options, "-c", code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)


@pytest.mark.parametrize("what", HIDING)
def test_a_stranger_that_hides_ours_is_named_once(what, tmp_path):
    file, name = HIDING[what]
    (tmp_path / file).parent.mkdir(exist_ok=True)
    (tmp_path / file).write_text("")
    first = f"import {name}; " if what == "imported first" else ""
    done = python(tmp_path, f"{first}import colias_sim; from colias_sim import config")
    warnings = [line for line in done.stderr.splitlines() if "RuntimeWarning" in line]
    assert len(warnings) == 1, done.stderr
    assert f"'import {name}' takes {tmp_path / file}" in warnings[0] and "rename it" in warnings[0]
    assert (done.returncode == 0) == (name != "scenes")


def test_a_folder_without_init_hides_nothing(tmp_path):
    """The import takes ours, and there is no warning: neither of a checkout nor of an installed wheel."""
    for name in ("experiments", "dsnn", "scenes"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "notes.txt").write_text("mine")
    done = python(tmp_path, "import colias_sim, experiments, dsnn; print(experiments.NAMES[0])", "-W", "error")
    assert (done.returncode, done.stdout, done.stderr) == (0, "general\n", "")
