"""Users' own files in one process: helpers of one name keep apart, an edit counts, the record tells what was run."""

from __future__ import annotations

import enum
import importlib
import pickle
import sys
import threading
from pathlib import Path

import pytest

import experiments
from experiments import UsageError
from tests.helpers.user_trees import experiment, hashes, model, peaks, run, sha


@pytest.mark.parametrize("order", [("v1", "v2"), ("v2", "v1")])
@pytest.mark.parametrize("workers", [0, 1])
def test_helpers_of_one_name_are_each_their_own_folder_s(order, workers, tmp_path):
    values = {"v1": 0.125, "v2": 0.25}
    models = {name: model(tmp_path / name / "mod.py", "helper.VALUE", "import helper") for name in values}
    for name, value in values.items():
        (tmp_path / name / "helper.py").write_text(f"VALUE = {value}\n")
    (tmp_path / "helper.py").write_text("CLIP = 'of the experiment'\n")
    file = experiment(tmp_path / "mine.py", clip="helper.CLIP", imports="import helper")
    clip_run = run(file, tmp_path / "out", models=[models[name] for name in order], workers=workers)
    assert {name: peaks(clip_run)[name] for name in values} == values
    assert clip_run.trials["clip"][0].as_py() == "of the experiment"
    folders = [tmp_path, *(tmp_path / name for name in values)]
    assert {path: digest for path, digest in hashes(clip_run).items() if path.endswith("helper.py")} == {
        str(folder / "helper.py"): sha(folder / "helper.py") for folder in folders
    }


def test_two_files_of_one_name_are_each_executed_once(tmp_path):
    log = tmp_path / "log"
    for name in ("a", "b"):
        model(tmp_path / name / "model.py", imports=f"with open({str(log)!r}, 'a') as log: log.write('{name}')")
    model_files = [tmp_path / "a" / "model.py", tmp_path / "b" / "model.py"]
    assert set(peaks(run(experiment(tmp_path / "mine.py"), tmp_path / "out", models=model_files))) == {"dsnn", "a", "b"}
    run(tmp_path / "mine.py", tmp_path / "again", models=model_files)
    assert sorted(log.read_text()) == ["a", "b"]


IMPORTS = {
    "a package beside": ("import lib.inner", "lib.inner.VALUE"),
    "from a package": ("from lib import inner as there", "there.VALUE"),
    "of a package's name alone": ("import lib.inner as there", "there.VALUE"),
    "of its parts among themselves": ("from lib.outer import VALUE", "VALUE"),
    "a folder without __init__": ("from bare.inner import VALUE", "VALUE"),
    "a star": ("from lib.inner import *", "VALUE"),
    "a name of an installed package": ("import rich", "rich.VALUE"),
}


@pytest.mark.parametrize("form", IMPORTS)
def test_every_form_of_import(form, tmp_path):
    imports, value = IMPORTS[form]
    for name, number in (("v1", 0.125), ("v2", 0.25)):
        folder = tmp_path / name
        for package in ("lib", "bare"):
            (folder / package).mkdir(parents=True)
            (folder / package / "inner.py").write_text(f"from helper import VALUE\nNAME = {number}\n")
        (folder / "lib" / "__init__.py").write_text("")
        (folder / "lib" / "outer.py").write_text("from . import inner\nfrom .inner import VALUE\n")
        (folder / "helper.py").write_text(f"import rich\nVALUE = {number}\n")
        (folder / "rich.py").write_text(f"VALUE = {number}\n")
        model(folder / "mod.py", value, imports)
    model_files = [tmp_path / name / "mod.py" for name in ("v1", "v2")]
    clip_run = run(experiment(tmp_path / "mine.py"), tmp_path / "out", models=model_files)
    assert (peaks(clip_run)["v1"], peaks(clip_run)["v2"]) == (0.125, 0.25)


def test_an_import_inside_a_function_is_of_the_contents_at_the_beginning(tmp_path):
    helper = tmp_path / "own" / "helper.py"
    step = f"import helper, pathlib; pathlib.Path({str(helper)!r}).write_text('VALUE = 0.75')"
    model(tmp_path / "own" / "mod.py", "helper.VALUE", step=step)
    helper.write_text("VALUE = 0.25")
    began = sha(helper)
    clip_run = run(experiment(tmp_path / "mine.py"), tmp_path / "out", models=[tmp_path / "own" / "mod.py"])
    assert peaks(clip_run)["own"] == 0.25 and hashes(clip_run)[str(helper)] == began
    again = run(tmp_path / "mine.py", tmp_path / "again", models=[tmp_path / "own" / "mod.py"])
    assert peaks(again)["own"] == 0.75 and hashes(again)[str(helper)] == sha(helper) != began


def test_an_edit_counts_in_the_same_process(tmp_path):
    model_file = model(tmp_path / "own" / "mod.py", 0.125)
    file = experiment(tmp_path / "mine.py", "return Outcome('holds', 'the first')", "'before'")
    first = run(file, tmp_path / "first", models=[model_file])
    assert (peaks(first)["own"], first.claims["measured"][0].as_py()) == (0.125, "the first")
    began = hashes(first)

    model(model_file, 0.375)
    experiment(file, "return Outcome('fails', 'the second')", "'after'")
    second = run(file, tmp_path / "second", models=[model_file])
    assert (peaks(second)["own"], second.trials["clip"][0].as_py()) == (0.375, "after")
    assert second.claims["measured"][0].as_py() == "the second"
    assert (
        hashes(second) == {str(path): sha(path) for path in (model_file, file)}
        and hashes(second).keys() == began.keys()
    )

    experiment(file, "return Outcome('holds', 'the third')", "'after'")
    with pytest.raises(UsageError, match=r"mine\.py has changed"):
        run(file, tmp_path / "second", models=[model_file])
    third = run(file, tmp_path / "second", models=[model_file], other_code=True)
    assert third.claims["measured"][0].as_py() == "the third"


def test_an_edited_helper_counts_and_one_that_comes_back_is_what_it_was(tmp_path):
    model_file = model(tmp_path / "own" / "mod.py", "helper.VALUE", "import helper")
    file = experiment(tmp_path / "mine.py")
    for number, value in enumerate((0.125, 0.25, 0.125)):
        (tmp_path / "own" / "helper.py").write_text(f"VALUE = {value}\n")
        assert peaks(run(file, tmp_path / f"out{number}", models=[model_file]))["own"] == value


def test_a_name_from_elsewhere_means_one_file_in_a_process(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", [*sys.path])
    model_files = []
    for name in ("v1", "v2"):
        (tmp_path / name / "lib").mkdir(parents=True)
        (tmp_path / name / "lib" / "colias_elsewhere.py").write_text("VALUE = 0.5\n")
        path = str(tmp_path / name / "lib")
        model_files.append(
            model(tmp_path / name / "mod.py", imports=f"sys.path.insert(0, {path!r})\nimport colias_elsewhere")
        )
    file = experiment(tmp_path / "mine.py")
    assert str(tmp_path / "v1" / "lib" / "colias_elsewhere.py") in hashes(
        run(file, tmp_path / "a", models=model_files[:1])
    )
    with pytest.raises(UsageError, match=r"v2.mod\.py: import colias_elsewhere: this process has loaded .*v1.*v2"):
        run(file, tmp_path / "b", models=model_files)
    edited = tmp_path / "v1" / "lib" / "colias_elsewhere.py"
    edited.write_text("VALUE = 0.25\n")
    with pytest.raises(UsageError, match=r"colias_elsewhere\.py: was edited after this process imported it as"):
        run(file, tmp_path / "c", models=model_files[:1])


def test_import_module_finds_what_python_finds_or_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", [*sys.path])
    model_files = []
    for name, value in (("v1", 0.125), ("v2", 0.25)):
        path = str(tmp_path / name)
        loads = f"sys.path.append({path!r})\nimport importlib\nloaded = importlib.import_module('colias_dynamic')"
        model_files.append(model(tmp_path / name / "mod.py", "loaded.VALUE", loads))
        (tmp_path / name / "colias_dynamic.py").write_text(f"VALUE = {value}\n")
    file = experiment(tmp_path / "mine.py")
    first = run(file, tmp_path / "a", models=model_files[:1])
    helper = tmp_path / "v1" / "colias_dynamic.py"
    assert peaks(first)["v1"] == 0.125 and hashes(first)[str(helper)] == sha(helper)
    with pytest.raises(UsageError, match=r"v2.mod\.py: import colias_dynamic: this process has loaded .*v1.*v2"):
        run(file, tmp_path / "b", models=model_files)
    helper.write_text("VALUE = 0.75\n")
    with pytest.raises(UsageError, match=r"colias_dynamic\.py: was edited after this process imported it as"):
        run(file, tmp_path / "c", models=model_files[:1])


def test_a_call_of_import_counts_as_the_statement_does(tmp_path):
    model_file = model(tmp_path / "own" / "mod.py", "helper.VALUE", "helper = __import__('helper')")
    for value in (0.125, 0.25):
        (tmp_path / "own" / "helper.py").write_text(f"VALUE = {value}\n")
        clip_run = run(experiment(tmp_path / "mine.py"), tmp_path / str(value), models=[model_file])
        assert peaks(clip_run)["own"] == value and str(tmp_path / "own" / "helper.py") in hashes(clip_run)


@pytest.mark.parametrize("linked", [False, True])
def test_an_experiment_of_a_module_edited_since_its_import_is_refused(linked, tmp_path, monkeypatch):
    name = f"colias_notebook_{linked}".lower()
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    file = experiment(tmp_path / "real" / f"{name}.py", "return Outcome('holds', 'first')")
    monkeypatch.syspath_prepend(tmp_path / ("link" if linked else "real"))
    module = importlib.import_module(name)
    experiment(file, "return Outcome('holds', 'the second')")
    with pytest.raises(UsageError, match=rf"{name}\.py: was edited after this process imported it as {name}"):
        run(module.EXPERIMENT, tmp_path / "a")
    clip_run = run(importlib.reload(module).EXPERIMENT, tmp_path / "b")
    assert clip_run.claims["measured"].to_pylist() == ["the second"] and hashes(clip_run) == {str(file): sha(file)}
    experiment(file, "return Outcome('holds', 'the third one')")
    with pytest.raises(UsageError, match="was edited after"):
        run(module.EXPERIMENT, tmp_path / "c")


def test_a_helper_that_appears_after_the_file_was_read_is_not_taken_unrecorded(tmp_path):
    step = "import pathlib; pathlib.Path(__file__).with_name('rich.py').write_text('VALUE = 0.75'); import rich"
    model_file = model(tmp_path / "own" / "mod.py", "getattr(rich, 'VALUE', 0.25)", step=step)
    for name, value in (("a", 0.25), ("b", 0.75)):
        clip_run = run(experiment(tmp_path / "mine.py"), tmp_path / name, models=[model_file])
        assert peaks(clip_run)["own"] == value
        assert (str(tmp_path / "own" / "rich.py") in hashes(clip_run)) == (value == 0.75)


def test_a_worker_that_finds_another_helper_ends_the_run(tmp_path, monkeypatch):
    monkeypatch.setattr("sys.path", [*sys.path])
    model_file = model(tmp_path / "own" / "mod.py", "colias_moved.VALUE", "import colias_moved")
    for name, value in (("v1", 0.125), ("v2", 0.25)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "colias_moved.py").write_text(f"VALUE = {value}\n")
    file = experiment(tmp_path / "mine.py")
    sys.path.insert(0, str(tmp_path / "v1"))
    assert peaks(run(file, tmp_path / "a", models=[model_file]))["own"] == 0.125
    sys.path.insert(0, str(tmp_path / "v2"))  # this process has the first, and a new one would find the second
    with pytest.raises(UsageError, match=r"v2.colias_moved\.py: is loaded here, and was not where the run was begun"):
        run(file, tmp_path / "b", models=[model_file], workers=1)


def test_a_file_that_was_a_model_and_is_now_a_helper_may_be_edited_between(tmp_path):
    base = model(tmp_path / "own" / "base.py", 0.25)
    run(experiment(tmp_path / "mine.py"), tmp_path / "a", models=[base])
    model(base, 0.5)
    derived = model(tmp_path / "own" / "derived.py", 0.125, "import base", name="derived")
    clip_run = run(tmp_path / "mine.py", tmp_path / "b", models=[derived])
    assert peaks(clip_run)["derived"] == 0.125 and hashes(clip_run)[str(base)] == sha(base)


def test_settings_of_a_user_s_own_kinds_cross_to_workers(tmp_path):
    kinds = "import enum\nclass Way(enum.StrEnum):\n    RIGHT = 'rightward'\nclass Speed(float):\n    pass"
    file = experiment(tmp_path / "mine.py", imports=kinds)
    file.write_text(file.read_text().replace('"rightward"', "Way.RIGHT").replace("90.0", "Speed(90.0)"))
    assert peaks(run(file, tmp_path / "a", workers=1)) == peaks(run(file, tmp_path / "b"))

    class Way(enum.StrEnum):
        TRANSLATION, RIGHTWARD = "translation", "rightward"

    condition = experiments.Condition(Way.TRANSLATION, Way.RIGHTWARD, speed_cm_s=6.0, distance_cm=8.0)
    assert pickle.loads(pickle.dumps(condition)) == condition  # no Way could be found by its name


def test_threads_that_run_one_file_each_get_all_of_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    log = tmp_path / "log"
    model(
        tmp_path / "own" / "mod.py",
        0.25,
        f"import time\nwith open({str(log)!r}, 'a') as log: log.write('x')\ntime.sleep(0.2)",
    )
    file = experiment(
        tmp_path / "mine.py", imports="import time\ntime.sleep(0.2)", models="'own/mod.py',", judged="own"
    )
    answers: list[object] = []

    def go(out: Path | None) -> None:
        try:
            answers.append(peaks(run(file, out)))
        except BaseException as error:
            answers.append(error)

    outs = [None, None, tmp_path / "deep" / "er" / "a", tmp_path / "deep" / "er" / "b"]
    threads = [threading.Thread(target=go, args=(out,)) for out in outs]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert answers == [{"own": 0.25}] * 4
    assert log.read_text() == "x", "executed once"
    assert len(list((tmp_path / "runs").iterdir())) == 2


def test_a_model_s_path_is_relative_to_the_file_that_has_it(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    model(tmp_path / "there" / "mod.py", 0.25)
    file = experiment(tmp_path / "mine.py", models="'there/mod.py:t_sp=0.5',", judged="there:t_sp=0.5")
    assert peaks(run(file, tmp_path / "out")) == {"there:t_sp=0.5": 0.25}
    experiment(file, models="'emd', 'nowhere/mod.py',")
    with pytest.raises(UsageError, match=r"mine\.py: EXPERIMENT\.models\[1\]: .*nowhere/mod\.py: no such file"):
        run(file, tmp_path / "again")


def test_an_experiment_is_its_own_file_s_and_no_other_s(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    text = experiment(tmp_path / "a" / "mine.py").read_text().replace("claims=(", "claims=() and (")
    for name in ("a", "b"):  # data alone, and equal: an experiment as good as another
        (tmp_path / name / "mine.py").write_text(text)
        assert list(hashes(run(tmp_path / name / "mine.py", tmp_path / f"out-{name}"))) == [
            str(tmp_path / name / "mine.py")
        ]


def test_a_judge_that_goes_wrong_at_one_seed_is_told(tmp_path, capsys):
    judge = "import sys; sys.exit() if rows[0]['repeat'] else None; return Outcome('holds', 'so')"
    clip_run = run(experiment(tmp_path / "mine.py", judge, repeats=2), tmp_path / "out")
    assert clip_run.claims["outcome"].to_pylist() == ["holds"]
    assert 'mine.py", line 9' in capsys.readouterr().err


def test_what_a_judge_changes_of_its_rows_is_its_own(tmp_path):
    judge = "[row.clear() for row in rows]; rows.clear(); return Outcome('holds', 'so', n=1)"
    twice = experiment(tmp_path / "mine.py", judge).read_text()
    later = 'judge=lambda rows, _: Outcome("holds", str(len(rows[0]) > 5))'
    second = f'ClipClaim(id="again", says="as I say", {later}, models={{"dsnn"}}),)'
    (tmp_path / "mine.py").write_text(twice.replace('models={"dsnn"}),)', f'models={{"dsnn"}}), {second}'))
    clip_run = run(tmp_path / "mine.py", tmp_path / "out")
    assert clip_run.claims["measured"].to_pylist() == ["so", "True"]
    assert clip_run.trials.num_rows == 1 and (tmp_path / "out" / "figure.png").exists()
