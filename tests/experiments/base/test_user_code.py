"""Users' own files: an edit counts in the same process, and the record tells what was run."""

import hashlib
import json

import pytest

import experiments
from experiments import UsageError
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
    assert answer(run(tmp_path, "out2")) == (0.125, "before", "third"), "a claim is judged anew"


def test_a_model_s_path_is_relative_to_the_file_that_has_it(tmp_path, monkeypatch):
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    write(tmp_path, value=0.25)
    assert answer(run(tmp_path, "out"))[0] == 0.25
    write(tmp_path, value=0.25, model="nowhere/own.py")
    with pytest.raises(UsageError, match=r"mine\.py: EXPERIMENT\.models\[0\]: .*nowhere/own\.py: no such file"):
        run(tmp_path, "again")
