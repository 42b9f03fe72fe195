"""Users' own files: an edit counts in the same process, and the record tells what was run."""

import hashlib
import importlib
import json
import pickle
import subprocess
import sys

import pytest

import experiments
from experiments import UsageError
from experiments.base.user_code import declared
from tests.helpers.answering import write_model

EXPERIMENT = """
from experiments import Claim, Clip, OfflineExperiment, Outcome

SMALL = {{"motion": "rightward", "rows": 24, "columns": 32, "width": 6.0, "height": 8.0, "speed": 90.0}}
CLAIM = Claim(on="clips", id="mine", says="so", judge=lambda clips, threshold: Outcome("holds", "{word}"),
              models={{"own"}})
EXPERIMENT = OfflineExperiment("mine", "one clip", [Clip("{clip}", "plain", SMALL)], ["{model}"], claims=(CLAIM,))
"""


def write(folder, *, value, clip="light", word="so", model="own.py"):
    """Write a model whose potential is a value of its helper's, and an experiment with it."""
    (folder / "helper.py").write_text(f"VALUE = {value}\n")
    write_model(folder, "own", "Response(helper.VALUE)", imports="import helper")
    (folder / "mine.py").write_text(EXPERIMENT.format(clip=clip, word=word, model=model))


def run(folder, out):
    return experiments.run(folder / "mine.py", out=folder / out, quiet=True, recordings=False, workers=0)


def answer(finished):
    (row,) = finished.trials.to_dicts()
    return row["peak_hs"], row["clip"], finished.claims["measured"][0]


def test_an_edit_counts_in_the_same_process_and_is_on_the_record(tmp_path):
    """Of the experiment and of a module that the model imports; one that comes back is what it was."""
    versions = ((0.125, "before", "first"), (0.375, "after", "second"), (0.125, "before", "first"))
    for number, (value, clip, word) in enumerate(versions):
        write(tmp_path, value=value, clip=clip, word=word)
        finished = run(tmp_path, f"out{number}")
        assert answer(finished) == (value, clip, word)
        noted = json.loads((finished.folder / "run.json").read_text())["files"]
        files = [tmp_path / name for name in ("helper.py", "own.py", "mine.py")]
        assert noted == {str(path): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
    write(tmp_path, value=0.125, clip="before", word="third")
    with pytest.raises(UsageError, match=r"mine\.py"):
        run(tmp_path, "out2")


def test_a_model_s_path_is_relative_to_the_file_that_has_it(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    write(tmp_path, value=0.25)
    assert answer(run(tmp_path, "out"))[0] == 0.25
    write(tmp_path, value=0.25, model="nowhere/own.py")
    with pytest.raises(UsageError, match=r"mine\.py: EXPERIMENT\.models\[0\]: .*nowhere/own\.py: no such file"):
        run(tmp_path, "again")


IN_THE_WAY = ("queue.py", "random.py", "types.py", "experiments/__init__.py", "scenes.py", "dsnn.py",
              "colias_sim/__init__.py", "loky.py", "numpy/notes.txt")  # fmt: skip
"""Names that Python, this project or a library has too."""
MANY = """
import enum, random, types

import experiments, numpy
from dsnn.frames import luma
from lib.part import value

import helper

assert random.random() < 1 and types.ModuleType and experiments.Clip and numpy.pi
"""


def test_a_file_that_is_called_as_a_module_of_python_s_is_in_nobody_s_way(tmp_path, monkeypatch):
    """Not in a worker, whose interpreter begins in the current folder; a folder without __init__.py is a package."""
    write(tmp_path, value=0.5)
    for name in IN_THE_WAY:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("raise RuntimeError('nobody has named this file')\n")
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "part.py").write_text("import helper\ndef value():\n    import late\n    return late.VALUE\n")
    (tmp_path / "late.py").write_text("from helper import VALUE\n")
    write_model(tmp_path, "own", "Response(value())", imports=MANY)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    before = [*sys.modules]
    finished = experiments.run(tmp_path / "mine.py", out="out", quiet=True, recordings=False, workers=1)
    assert finished.failures.is_empty() and answer(finished)[0] == 0.5
    assert not {"helper", "late", "lib.part"} & ({*sys.modules} - {*before})


def test_a_caller_s_own_modules_stay_and_two_folders_may_have_one_of_one_name(tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path])
    for name, value in (("one", 1), ("two", 2)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "helper_of_mine.py").write_text(f"class Kind:\n    value = {value}\n")
        lazy = "def ask():\n    import helper_of_mine\n    return helper_of_mine.Kind"
        (tmp_path / name / "own.py").write_text(f"from helper_of_mine import Kind\n{lazy}\nASK, KIND = ask, Kind\n")
    monkeypatch.syspath_prepend(tmp_path / "one")
    callers = importlib.import_module("helper_of_mine")
    asked = [declared(tmp_path / name / "own.py", "ASK") for name in ("one", "two", "one")]
    assert [ask().value for ask in asked] == [1, 2, 1]
    assert sys.modules["helper_of_mine"] is callers is not sys.modules[asked[0]().__module__]
    assert type(pickle.loads(pickle.dumps(callers.Kind()))) is callers.Kind
    assert sys.path[0] == str(tmp_path / "one"), "a user's folder hides nothing"
    monkeypatch.delitem(sys.modules, "helper_of_mine")


def test_a_type_of_a_users_file_reaches_another_process(tmp_path, monkeypatch):
    """As the value of a parameter does."""
    (tmp_path / "own.py").write_text("from kinds import Kind\nKIND = Kind.FAST\n")
    (tmp_path / "kinds.py").write_text("import enum\n\n\nclass Kind(enum.Enum):\n    FAST = 7\n")
    path = pickle.dumps(declared(tmp_path / "own.py", "KIND"))
    read = "import pickle, sys, experiments.base.user_code; print(pickle.loads(sys.stdin.buffer.read()).value)"
    printed = subprocess.run([sys.executable, "-c", read], input=path, capture_output=True, check=True).stdout
    assert printed == b"7\n"


def test_a_file_that_exits_is_named(tmp_path):
    write(tmp_path, value=0.5)
    write_model(tmp_path, "own", "Response(0.25)", imports="sys.exit(3)")
    with pytest.raises(UsageError, match=r"own\.py: sys\.exit\(3\)"):
        run(tmp_path, "out")
