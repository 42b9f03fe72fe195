"""Users' own files: an edit counts in the same process, the record tells what was run, workers run the same."""

from __future__ import annotations

import enum
import pickle

import pytest

import experiments
from experiments import UsageError
from tests.helpers.user_trees import experiment, hashes, model, peaks, run, sha


@pytest.mark.parametrize("workers", [0, 1])
def test_two_models_of_one_name_have_each_its_own_helper_and_are_on_the_record(workers, tmp_path):
    values = {"v1": 0.125, "v2": 0.25}
    models = [model(tmp_path / name / "mod.py", "helper.VALUE", "import helper") for name in values]
    for name, value in values.items():
        (tmp_path / name / "helper.py").write_text(f"VALUE = {value}\n")
    file = experiment(tmp_path / "mine.py")
    finished = run(file, tmp_path / "out", models=models, workers=workers)
    assert {name: peaks(finished)[name] for name in values} == values
    files = [file, *models, *(tmp_path / name / "helper.py" for name in values)]
    assert hashes(finished) == {str(path): sha(path) for path in files}


def test_what_another_file_imported_is_not_on_the_record(tmp_path):
    """So a run begun in a notebook and one begun on the command line have equal records."""
    for name in ("one", "two"):
        (tmp_path / f"helper_{name}.py").write_text("VALUE = 0.5\n")
        model(tmp_path / f"{name}.py", f"helper_{name}.VALUE", f"import helper_{name}", name=name)
    file = experiment(tmp_path / "mine.py")
    run(file, tmp_path / "first", models=[tmp_path / "one.py"])
    finished = run(file, tmp_path / "second", models=[tmp_path / "two.py"])
    assert hashes(finished).keys() == {str(tmp_path / name) for name in ("mine.py", "two.py", "helper_two.py")}


def test_an_edit_counts_in_the_same_process(tmp_path):
    model_file = model(tmp_path / "own" / "mod.py", 0.125)
    file = experiment(tmp_path / "mine.py", "return Outcome('holds', 'the first')", "'before'")
    first = run(file, tmp_path / "first", models=[model_file])
    assert (peaks(first)["own"], first.claims["measured"][0]) == (0.125, "the first")
    began = hashes(first)

    model(model_file, 0.375)
    experiment(file, "return Outcome('fails', 'the second')", "'after'")
    second = run(file, tmp_path / "second", models=[model_file])
    assert (peaks(second)["own"], second.trials["clip"][0]) == (0.375, "after")
    assert second.claims["measured"][0] == "the second"
    assert (
        hashes(second) == {str(path): sha(path) for path in (model_file, file)}
        and hashes(second).keys() == began.keys()
    )

    experiment(file, "return Outcome('holds', 'the third')", "'after'")
    third = run(file, tmp_path / "second", models=[model_file])
    assert third.claims["measured"][0] == "the third"


def test_an_edited_helper_counts_and_one_that_comes_back_is_what_it_was(tmp_path):
    model_file = model(tmp_path / "own" / "mod.py", "helper.VALUE", "import helper")
    file = experiment(tmp_path / "mine.py")
    for number, value in enumerate((0.125, 0.25, 0.125)):
        (tmp_path / "own" / "helper.py").write_text(f"VALUE = {value}\n")
        assert peaks(run(file, tmp_path / f"out{number}", models=[model_file]))["own"] == value


def test_settings_of_a_user_s_own_kinds_cross_to_workers(tmp_path):
    kinds = "import enum\nclass Way(enum.StrEnum):\n    RIGHT = 'rightward'\nclass Speed(float):\n    pass"
    file = experiment(tmp_path / "mine.py", imports=kinds)
    file.write_text(file.read_text().replace('"rightward"', "Way.RIGHT").replace("90.0", "Speed(90.0)"))
    assert peaks(run(file, tmp_path / "a", workers=1)) == peaks(run(file, tmp_path / "b"))

    class Way(enum.StrEnum):
        TRANSLATION, RIGHTWARD = "translation", "rightward"

    condition = experiments.Condition(Way.TRANSLATION, Way.RIGHTWARD, speed_cm_s=6.0, distance_cm=8.0)
    assert pickle.loads(pickle.dumps(condition)) == condition  # no Way could be found by its name


def test_a_model_s_path_is_relative_to_the_file_that_has_it(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    model(tmp_path / "there" / "mod.py", 0.25)
    file = experiment(tmp_path / "mine.py", models="'there/mod.py:t_sp=0.5',", judged="there:t_sp=0.5")
    assert peaks(run(file, tmp_path / "out")) == {"there:t_sp=0.5": 0.25}
    experiment(file, models="'emd', 'nowhere/mod.py',")
    with pytest.raises(UsageError, match=r"mine\.py: EXPERIMENT\.models\[1\]: .*nowhere/mod\.py: no such file"):
        run(file, tmp_path / "again")


def test_a_judge_that_goes_wrong_at_one_seed_is_told(tmp_path, capsys):
    judge = "1 / 0 if clips['repeat'][0] else None; return Outcome('holds', 'so')"
    clip_run = run(experiment(tmp_path / "mine.py", judge, repeats=2), tmp_path / "out")
    assert clip_run.claims["outcome"].to_list() == ["holds"]
    assert "ZeroDivisionError" in capsys.readouterr().err
