"""Data that name files of code, in every field, to every command that reads them: none is run, as nobody named it.

A folder is handed over, a log, a policy, a folder to work in. Only what stands on the command line is run.
"""

from __future__ import annotations

import contextlib
import csv
import json
import shutil
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import experiments
from experiments.bench.cli import main
from experiments.bench.closed_loop import policy_file
from experiments.bench.reproduction.page.stored import stored
from tests.attack.canaries import MARK, marks, plant, plant_modules, tampered
from tests.attack.commands import CLIPS, EXPERIMENT, film
from tests.attack.folders import KINDS
from tests.attack.folders import copied as copied_folder
from tests.attack.processes import python
from tests.attack.scale import some

pytestmark = pytest.mark.attack
RunOf = Callable[[str], tuple[Path, dict[str, Any]]]
VERSIONS = 60
"""Versions of a description; in the full attack all there are."""
POLICY = Path(experiments.__file__).parent / "policies" / "optomotor-policy.npz"


@pytest.fixture
def evil(tmp_path: Path) -> Path:
    """A canary that data name, beside nothing else."""
    (path,) = plant(tmp_path / "evil", "evil.py")
    return path


@contextlib.contextmanager
def whatever() -> Iterator[None]:
    """What a command says of such data is the matter of other attacks."""
    with contextlib.suppress(Exception, SystemExit):
        yield


def colias(*words: object) -> None:
    with whatever():
        main.command([str(word) for word in words])


def read_as_object(folder: Path) -> None:
    """All that `experiments.load` gives."""
    run: Any = None
    with whatever():
        run = experiments.load(folder)
    for name in ("trials", "frames", "summary", "claims", "failures", "recordings", "name", "seed", "planned", "done",
                 "models", "changed", "verdicts", "provenance", "offline"):  # fmt: skip
        with whatever():
            getattr(run, name)
    with whatever():
        str(run), run._repr_html_()
    with whatever():
        run.figure()


def read_by_commands(folder: Path, kind: str) -> None:
    """All commands that take a run's folder, short of those that open windows."""
    experiment = {"robot": "tiny.py", "clips": "clips.py"}.get(kind, "speed")
    colias("runs", folder.parent)
    colias("compare", folder, folder.parent / "other")
    colias("compare", folder.parent / "other", folder)
    for to in ("log", "csv", "npz", "mat"):
        colias("export", folder, "--to", to, "--out", folder.parent / "exported", "--force", "-q")
    colias("export", folder, "--frames", folder.parent / "pictures", "--force", "-q")
    colias(*KINDS[kind].words, "--out", folder)
    colias("run", experiment, "--dry-run", "--out", folder)
    colias("view", folder)
    with whatever():
        stored(folder.parent)


@pytest.fixture
def copied(run_of: RunOf, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Path]:
    """A copy of a run of a kind, in whose folder one works."""

    def of(kind: str) -> Path:
        folder, _ = run_of(kind)
        place = copied_folder(folder, tmp_path / "work")
        monkeypatch.chdir(place)
        return place / "out"

    return of


def test_a_canary_that_is_named_leaves_its_mark(evil: Path, tmp_path: Path):
    """That the others can fail."""
    colias("check", evil)
    assert marks(tmp_path) == ["evil"]


@pytest.mark.parametrize("kind", KINDS)
def test_no_field_of_a_description_is_run(kind: str, copied: Callable[[str], Path], evil: Path, tmp_path: Path):
    """Each text, name and empty place in turn; readers as objects each time, commands at a part of them."""
    folder = copied(kind)
    versions = list(tampered(folder / "experiment.json", str(evil)))
    assert len(versions) > 20
    chosen = some(versions, VERSIONS)
    for number, text in enumerate(chosen):
        (folder / "experiment.json").write_text(text)
        read_as_object(folder)
        if number % 12 == 0:
            read_by_commands(folder, kind)
        assert marks(tmp_path) == [], text


@pytest.mark.parametrize("kind", ["robot", "clips"])
def test_models_and_files_of_a_description_are_not_run(kind, copied, evil: Path, tmp_path: Path):
    """The fields that name code, with each spelling of a path, to every reader."""
    folder = copied(kind)
    there = json.loads((folder / "experiment.json").read_text())
    for source in (str(evil), "../evil/evil.py", f"{evil}:gain=1", str(evil.with_suffix(""))):
        for model in there["settings"]["models"] if kind == "robot" else there["models"]:
            model["source"] = source
        for files in ({source: "0" * 64}, {}):
            for thresholds in (there.get("thresholds"), None, {"dsnn": source}, source):
                version = {**there, "files": files, "thresholds": thresholds}
                (folder / "experiment.json").write_text(json.dumps(version))
                read_as_object(folder)
                read_by_commands(folder, kind)
                assert marks(tmp_path) == [], version


@pytest.mark.parametrize("kind", KINDS)
def test_no_cell_of_a_table_is_run(kind: str, copied: Callable[[str], Path], evil: Path, tmp_path: Path):
    folder = copied(kind)
    for name in ("trials.parquet", "frames.parquet"):
        whole = pq.read_table(folder / name)
        for index, field in enumerate(whole.schema):
            if field.type == pa.string():
                column = pa.array([str(evil)] * whole.num_rows)
                pq.write_table(whole.set_column(index, field, column), folder / name)
                read_as_object(folder)
                read_by_commands(folder, kind)
                assert marks(tmp_path) == [], (name, field.name)
        pq.write_table(whole, folder / name)


@pytest.mark.parametrize("name", ["claims.json", "failures.json", "summary.csv"])
def test_nothing_in_other_files_of_a_run_is_run(name: str, copied: Callable[[str], Path], evil: Path, tmp_path: Path):
    folder = copied("robot")
    rows = [
        {
            "id": str(evil),
            "model": str(evil),
            "verdict": "holds",
            "says": str(evil),
            "source": str(evil),
            "measured": str(evil),
        }
    ]
    (folder / name).write_text(f"model,quantity\n{evil},{evil}\n" if name.endswith(".csv") else json.dumps(rows))
    read_as_object(folder)
    read_by_commands(folder, "robot")
    assert marks(tmp_path) == []


CELLS = ("{0}", "{0}:gain=1", "{0}@true", "{0}@frames", "../evil/evil.py", "./../evil/evil.py", "{0} ", "evil/evil")


@pytest.mark.parametrize("more", [(), ("--ran", "emd"), ("--model", "dsnn", "--frames", "frames")], ids=str)
def test_no_cell_of_a_log_is_run(more, copied: Callable[[str], Path], evil: Path, tmp_path: Path, capsys):
    folder = copied("robot")
    assert main.command(["export", str(folder), "--to", "log", "--out", "log", "-q"]) == 0
    shutil.copytree("log", "frames", dirs_exist_ok=True)
    with (Path("log") / "log.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert "model" in rows[0]
    for column in rows[0]:
        for cell in CELLS:
            with Path("evil.csv").open("w", newline="") as file:
                lines = csv.DictWriter(file, list(rows[0]))
                lines.writeheader()
                lines.writerows({**row, column: cell.format(evil)} if row["model"] == "dsnn" else row for row in rows)
            capsys.readouterr()
            colias("import", "evil.csv", "--experiment", "tiny.py", "--out", "imported", "-q", *more)
            assert marks(tmp_path) == [], (column, cell)
            assert not Path("imported").exists()


def test_no_field_of_a_policy_is_run(evil: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What a policy's file says of its env, its model and their arguments."""
    monkeypatch.chdir(tmp_path)
    with np.load(POLICY, allow_pickle=False) as file:
        arrays = dict(file)
    about = tmp_path / "about.json"
    about.write_text(str(arrays["about"]))
    versions = list(tampered(about, str(evil)))
    options = [{**json.loads(str(arrays["about"])), "options": {name: str(evil)}}
               for name in ("camera", "robot", "noise", "randomise", "model", "render_mode")]  # fmt: skip
    assert len(versions) > 5
    for text in (*versions, *map(json.dumps, options)):
        np.savez(tmp_path / "policy.npz", **{**arrays, "about": np.array(text)})
        with whatever():
            policy_file.load(tmp_path / "policy.npz").behaviour("policy")
        assert marks(tmp_path) == [], text
    for words in (("behave", "policy.npz", "--episodes", "1", "--workers", "0"), ("train", "--replay", "policy.npz")):
        colias(*words, "-q")
        assert marks(tmp_path) == [], words


COMMANDS = (
    ("doctor",),
    ("run", "named/tiny.py", "--workers", "1", "--out", "out", "-q"),
    ("run", "named/clips.py", "--workers", "2", "--out", "out", "-q"),
    ("tune", "--curve", "size", "--workers", "1", "--out", "out", "-q"),
    ("behave", "straight", "--episodes", "1", "--workers", "1", "--out", "out", "-q"),
    ("watch", "film.avi", "--no-view", "--table", "seen.parquet", "--record", "seen.rrd"),
    ("view", "made/out", "--web"),
    ("video", "made/out", "--out", "trial.png"),
    ("export", "made/out", "--to", "csv"),
    ("firmware", "check", "--no-trial"),
    ("firmware", "budget", "--compiler", "zig"),
    ("runs", "made"),
    ("list",),
    ("check", "emd"),
)


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: "-".join(words[:2]).replace("/", "-"))
def test_no_module_of_the_current_folder_is_run(words: tuple[str, ...], run_of: RunOf, folder: Path):
    """As the installed ``colias`` starts: ``python -m`` alone puts the current folder first, as its user asks."""
    shutil.copytree(run_of("robot")[0], folder / "made")
    (folder / "named").mkdir()
    (folder / "named" / "tiny.py").write_text(EXPERIMENT.format(repeats=1, speeds="(25,)"))
    (folder / "named" / "clips.py").write_text(CLIPS)
    film(folder / "film.avi", 30)
    plant_modules(folder)
    waits = words[0] == "view"
    script = folder.parent / "colias.py"
    script.write_text("from experiments.bench.cli.entry import main\n\nmain()\n")
    ended = python(folder, (str(script), *words), timeout_s=10.0 if waits else 150.0)
    assert marks(folder) == [], ended
    assert ended.crashes() == []
    assert waits or ended.status is not None, ended


def test_the_modules_are_there_to_be_run(folder: Path):
    """That the test above can fail: Python's own ways run them."""
    plant_modules(folder)
    python(folder, ("-c", "import random"))
    assert "random" in marks(folder) and MARK
    assert sys.flags.safe_path == 0
