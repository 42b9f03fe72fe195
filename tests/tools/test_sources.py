"""Pictures and tables of docs/ are of the runs that docs/sources.json notes, and a changed one is refused."""

import json

import polars as pl
import pytest
from matplotlib.figure import Figure

import experiments
from experiments.bench.run.runs import Enough, first
from experiments.bench.store.files import TABLE as TABLE_FILE
from experiments.bench.store.files import drawn_from, read_parquet
from tools.sources import (
    ROOT,
    SOURCES,
    Stale,
    as_text,
    contents,
    difference,
    digest,
    first_trial,
    main,
    noted,
    unfit,
    unread,
    unrecorded,
)

HEAD = "| crossing | trials |\n|---|---|\n"
TABLE = f"<!-- table: fast -->\n{HEAD}| rightward | 1 |\n<!-- end of table -->\n"
COMMAND = ["run", "speed", "--repeats", "1", "--seed", "3", "--set", "experiment.speeds_cm_s=20"]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of four crossings, as its command leaves it."""
    from experiments.bench.cli.main import command

    folder = tmp_path_factory.mktemp("runs") / "fast"
    assert command([*COMMAND, "--out", str(folder), "--workers", "0", "--quiet"]) == 0
    description = json.loads((folder / "run.json").read_text())
    description["source"] |= {"commit": "abc123abc123", "dirty": False}  # as of a clean checkout
    (folder / "run.json").write_text(json.dumps(description))
    return folder


@pytest.fixture
def docs(run, tmp_path):
    """The folder of a page with a table, and a picture, both of the run."""
    (tmp_path / "docs").mkdir()
    Figure().savefig(tmp_path / "docs" / "fast.png", metadata={"Source": drawn_from([run / TABLE_FILE])})
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
        (lambda docs: (docs / "page.md").write_text(TABLE.replace("1 |", "2 |")), "#fast was changed"),
    ],
    ids=["gone", "another picture", "a picture of no run", "an edited table"],
)
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


def test_a_run_that_comes_out_otherwise_now_is_refused(docs, tmp_path):
    """Another seed, as another network would, gives another first trial."""
    source = sources(docs)["fast"]
    assert "peak_hs is" in difference(source | {"command": source["command"].replace("3", "4", 1)}, tmp_path / "other")
    assert "refused now" in difference(source | {"command": "run spead"}, tmp_path / "none")
    columns = source["first"] | {"columns": f"{source['first']['columns']} lost"}
    assert difference(source | {"first": columns}, tmp_path / "column") == "the column lost is gone"


@pytest.mark.parametrize("column", ["peak_hs", "spikes", "direction"])
def test_a_first_trial_with_another_value_in_any_column_is_refused(column, run, docs, capsys):
    """A few numbers are noted in full; the digest tells the others."""
    rows = first_trial(run / "trials.parquet")
    value = rows[column][0]
    other = value + "s" if isinstance(value, str) else value + (1e-12 if isinstance(value, float) else 1)
    changed = rows.with_columns(pl.lit(other, rows.schema[column]).alias(column))
    notes = sources(docs)
    notes["fast"]["first"] = digest(changed)
    (docs / SOURCES).write_text(json.dumps(notes))
    assert main(["--root", str(docs), "check"]) == 2
    assert "fast: trial 0 has other rows" in capsys.readouterr().err


@pytest.mark.parametrize(
    "row, missing",
    [
        ("| `dsnn`, 20 | 61.5 [59, 64.1] |", []),
        ("| `dsnn`, 20 | 61.6 [59, 64.1] |", ["61.6 of `dsnn`, 20"]),
        ("| `dsnn`, 20 | 61.5 [59.0, 64.1] |", ["59.0 of `dsnn`, 20"]),
        ("| `dsnn`, 10 | 61.5 |", ["61.5 of `dsnn`, 10"]),
        ("| `emd`, 20 | 61.5 |", ["61.5 of `emd`, 20"]),
        ("| `dsnn`, 20, peak_hs | 61.5 |", ["61.5 of `dsnn`, 20, peak_hs"]),
        ("| `dsnn`, 20, peak_hs | 86 % of `T = 0.2`, - |", []),
        ("| `dsnn`, 20, dark | 4 |", []),
        ("| `dsnn`, 20, dark | 61.5 |", ["61.5 of `dsnn`, 20, dark"]),
    ],
    ids=["rounded", "another number", "more digits", "another row", "no such row", "another quantity", "a share",
         "of the run that it names", "of another run"],
)  # fmt: skip
def test_a_number_of_a_table_stands_in_the_rows_of_its_runs(row, missing, tmp_path):
    head, runs = "model,speed,quantity,mean,low,high\n", [tmp_path / "in-light", tmp_path / "in-dark"]
    for run, rows in zip(
        runs,
        (
            "dsnn,20,spikes,61.4999,58.94,64.12\ndsnn,20,peak_hs,0.858,0.8,0.9\ndsnn,10,spikes,12,11,13\n",
            "dsnn,20,spikes,4,3,5\n",
        ),
        strict=True,
    ):
        run.mkdir()
        (run / "summary.csv").write_text(head + rows)
    assert unread(f"{HEAD}{row}\n", runs) == missing


def test_a_table_that_its_run_does_not_have_is_taken_by_hand_alone(run, docs, capsys):
    (docs / "docs" / "page.md").write_text(TABLE.replace("1 |", "77 |"))
    take = ["--root", str(docs), "take", str(run), "page.md#fast"]
    assert main(take) == 2
    assert "do not have 77 of rightward" in capsys.readouterr().err
    assert main([*take, "--by-hand"]) == 0
    assert sources(docs)["fast"]["by_hand"] == ["page.md#fast"] and unfit(sources(docs), docs) != ""  # of the picture
    assert main(["--root", str(docs), "take", str(run)]) == 2
    assert "legal is folders of runs, and places" in capsys.readouterr().err


def test_the_notes_are_json_of_short_records():
    text = (ROOT / SOURCES).read_text()
    assert text == as_text(json.loads(text)) and len(text.splitlines()) <= 9 * len(json.loads(text)) + 2


def test_a_run_of_changed_code_is_not_taken(run, docs):
    file = run / "run.json"
    before = file.read_text()
    try:
        file.write_text(before.replace('"dirty": false', '"dirty": true'))
        with pytest.raises(Stale, match="nobody can check out"):
            noted([run], ["page.md#fast"], docs)
    finally:
        file.write_text(before)
    with pytest.raises(Stale, match=r"does not show other\.png"):
        noted([run], ["other.png"], docs)
    assert list(contents(docs)) == ["fast.png", "page.md#fast"]


def test_a_batch_is_cut_after_its_first_jobs_and_keeps_them(tmp_path):
    fast = {"experiment.speeds_cm_s": "20"}
    with first(2), pytest.raises(Enough, match="2 of 3 trials"):
        experiments.run("speed", repeats=3, settings=fast, out=tmp_path / "cut", workers=0, quiet=True)
    assert set(read_parquet(tmp_path / "cut" / "trials.parquet")["trial"].to_list()) == {0, 1}
