"""Pictures and tables of docs/ are of the runs that docs/sources.json notes, and a changed one is refused."""

import json

import pytest
from matplotlib.figure import Figure

import experiments
from experiments.bench.engine.batch import Enough, first
from experiments.bench.store.files import drawn_from, read_parquet
from tools.sources import ROOT, SOURCES, Stale, contents, difference, main, noted, unfit, unrecorded

TABLE = "<!-- table: fast -->\n| a |\n|---|\n| 1 |\n<!-- end of table -->\n"
COMMAND = ["run", "speed", "--repeats", "1", "--seed", "3", "--set", "experiment.speeds_cm_s=20"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of four crossings, as its command leaves it."""
    from experiments.bench.cli.main import command

    folder = tmp_path_factory.mktemp("runs") / "fast"
    assert command([*COMMAND, "--out", str(folder), "--workers", "0", "--quiet"]) == 0
    description = json.loads((folder / "experiment.json").read_text())
    description["source"] |= {"commit": "abc123abc123", "dirty": False}  # as of a clean checkout
    (folder / "experiment.json").write_text(json.dumps(description))
    return folder


@pytest.fixture
def docs(run, tmp_path):
    """The folder of a page with a table, and a picture, both of the run."""
    (tmp_path / "docs").mkdir()
    Figure().savefig(tmp_path / "docs" / "fast.png", metadata={"Source": drawn_from(run)})
    (tmp_path / "docs" / "page.md").write_text(TABLE)
    assert main(["--root", str(tmp_path), "take", str(run), "fast.png", "page.md#fast"]) == 0
    return tmp_path


def sources(root):
    return json.loads((root / SOURCES).read_text())


def test_every_picture_and_table_of_the_documentation_is_of_a_run_that_is_noted():
    assert unfit(sources(ROOT), ROOT) == ""
    for name, source in sources(ROOT).items():
        assert source["command"] and len(source["rows"]) == 64 and source["shows"], name
        assert set(source["commit"]) <= set("0123456789abcdef"), name


def test_what_was_just_taken_is_fit_and_repeats(docs, capsys):
    assert main(["--root", str(docs), "check"]) == 0
    assert "fast: trial 0 is equal" in capsys.readouterr().err


@pytest.mark.parametrize(
    "change, told",
    [
        (lambda docs: (docs / "fast.png").unlink(), "does not show fast.png"),
        (lambda docs: Figure().savefig(docs / "fast.png"), "fast.png was changed"),
        (lambda docs: Figure().savefig(docs / "new.png"), "notes no run of new.png"),
        (lambda docs: (docs / "page.md").write_text(TABLE.replace("1", "2")), "#fast was changed"),
    ],
    ids=["gone", "another picture", "a picture of no run", "an edited table"],
)  # fmt: skip
def test_what_is_shown_and_is_not_of_its_run_is_refused(docs, change, told):
    change(docs / "docs")
    assert told in unfit(sources(docs), docs)


@pytest.mark.parametrize(
    "text, heads",
    [
        ("text\n| a | b |\n|---|---|\n| x | 0.5 |\n| y | -1 |\n", ["| a | b |"]),
        ("<!-- no rows: a plan -->\n| a | b |\n|---|---|\n| x | 0.5 |\n", []),
        ("<!-- table: t -->\n| a | b |\n|---|---|\n| x | 0.5 |\n<!-- end of table -->\n", []),
        ("\n| a | b |\n|---|---|\n| x | a word |\n", []),
    ],
    ids=["of no run", "says why", "of a run", "of words"],
)
def test_a_table_of_numbers_is_of_a_run_or_says_why_not(text, heads):
    assert unrecorded(text) == heads


def test_a_run_that_comes_out_otherwise_now_is_refused(docs, tmp_path, capsys):
    """Another seed, as another network would, gives another first trial; so does a number edited in the notes."""
    source = sources(docs)["fast"]
    other = source | {"command": [word if word != "3" else "4" for word in source["command"]]}
    assert "of trial 0 is" in difference(other, tmp_path / "other")
    notes = sources(docs)
    notes["fast"]["first"]["peak_hs"][0] += 1e-12
    (docs / SOURCES).write_text(json.dumps(notes))
    assert main(["--root", str(docs), "check"]) == 2
    assert "peak_hs of trial 0 is" in capsys.readouterr().err
    assert "refused now" in difference(source | {"command": ["run", "spead"]}, tmp_path / "none")


def test_a_run_of_changed_code_is_not_taken(run, docs):
    file = run / "experiment.json"
    before = file.read_text()
    try:
        file.write_text(before.replace('"dirty": false', '"dirty": true'))
        with pytest.raises(Stale, match="nobody can check out"):
            noted(run, ["page.md#fast"], docs)
    finally:
        file.write_text(before)
    with pytest.raises(Stale, match=r"does not show other\.png"):
        noted(run, ["other.png"], docs)
    assert list(contents(docs)) == ["fast.png", "page.md#fast"]


def test_a_batch_is_cut_after_its_first_jobs_and_keeps_them(tmp_path):
    fast = {"experiment.speeds_cm_s": "20"}
    with first(2), pytest.raises(Enough, match="2 of 3 trials"):
        experiments.run("speed", repeats=3, settings=fast, out=tmp_path / "cut", workers=0, quiet=True)
    assert set(read_parquet(tmp_path / "cut" / "trials.parquet")["trial"].to_pylist()) == {0, 1}
