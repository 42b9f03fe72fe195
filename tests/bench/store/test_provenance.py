"""What run.json tells of what computed a run: every library that does, and what drew the frames."""

import json
import os
import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import polars as pl
import pytest

import hatch_build
from colias_sim import reference
from experiments.bench.run import provenance
from tests.conftest import Colias

ROOT = Path(__file__).parents[3]
COMPUTE_NOTHING = {
    "matplotlib": "figures", "typer": "the command line", "rich": "the terminal", "jinja2": "the report's page",
    "filelock": "keeps two runs apart", "loky": "keeps worker processes",
    "packaging": "compares versions for colias doctor", "pyopengl": "asks OpenGL for its name",
    "cffi": "hands arrays to the network in C", "lazy-loader": "imports public names when they are asked for",
}  # fmt: skip
RUN = ("run", "speed", "--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--no-recordings", "--workers", "0")


def test_every_dependency_that_computes_is_noted():
    dependencies = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    depends = {re.split(r"[<>=\[ ]", line)[0] for line in dependencies}
    assert depends <= {*provenance.LIBRARIES, *COMPUTE_NOTHING}
    assert not depends & set(COMPUTE_NOTHING) & set(provenance.LIBRARIES)
    assert "unknown" not in provenance.versions().values()


def test_a_checkout_that_belongs_to_another_user_keeps_its_commit(tmp_path, monkeypatch):
    git = shutil.which("git")
    if git is None or not (ROOT / ".git").exists():
        pytest.skip("not a checkout")
    commit = subprocess.run([git, "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True, check=True).stdout
    (tmp_path / "git").write_text(f'#!/bin/sh\nGIT_TEST_ASSUME_DIFFERENT_OWNER=1 exec {git} "$@"\n')
    (tmp_path / "git").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert subprocess.run(["git", "-C", ROOT, "status"], capture_output=True, check=False).returncode, (
        "git distrusts it"
    )
    assert provenance.checkout.__wrapped__()[0] == commit.strip()
    assert hatch_build._git(str(ROOT), "rev-parse", "HEAD") == commit.strip()


def described(folder: Path) -> dict:
    return json.loads((folder / "run.json").read_text())


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The folder of a run; it is not written to."""
    colias = Colias(tmp_path_factory.mktemp("finished"))
    assert colias(*RUN, "--out", "out", "-q").returncode == 0
    return colias.folder / "out"


@pytest.fixture
def out(finished, colias):
    """A copy of it."""
    return shutil.copytree(finished, colias.folder / "out")


def test_what_drew_is_noted_and_refuses_nothing(colias, out):
    """The same run, begun where something else draws other pixels."""
    first = described(out)
    (drew,), (pixels,) = first["renderers"], first["reference_frames"]
    assert re.fullmatch(r".+, OpenGL \d.+, by (egl|osmesa|glfw|cgl)", drew)
    assert pixels == reference.digest(reference.reference_frame())
    rows = pl.read_parquet(out / "trials.parquet")
    other = {"renderers": ["another"], "reference_frames": ["0123456789ab"]}
    (out / "run.json").write_text(json.dumps(first | other))
    rows.slice(1).write_parquet(out / "trials.parquet")
    again = colias(*RUN, "--out", "out", "-q")
    assert again.returncode == 0
    assert "pixels that differ" in again.stderr and f"reference frames 0123456789ab, {pixels}" in again.stderr
    went_on = {name: described(out)[name] for name in ("ended", "command")}
    both = {"renderers": ["another", drew], "reference_frames": ["0123456789ab", pixels]}
    assert described(out) == first | both | went_on
    now = pl.read_parquet(out / "trials.parquet")
    assert now.drop(["wall_s"]).equals(rows.drop(["wall_s"])), "the code that marks the rows too"


def test_a_run_that_draws_nothing_notes_nothing(colias):
    short = ("--repeats", "1", "--only", "--model", "emd", "--no-recordings", "--workers", "0")
    done = colias("run", "clean", *short, "--out", "out", "-q")
    assert done.returncode == 0, done.stderr
    assert "renderers" not in described(colias.folder / "out")
