"""Results of the documentation are of runs that are noted, and what is not is refused."""

import contextlib
import dataclasses
import json
import re
import shutil

import pytest

from experiments.base.files import to_json
from experiments.declare.claim import claim_ids
from experiments.declare.outcome import Outcome
from experiments.judge.verdict import Count, count_columns, document, verdict_of
from experiments.kinds.registry import find_claim
from experiments.paper.page import QUICK
from tests.helpers.chapters import PAGES as CHAPTERS
from tools import results as tool
from tools.results import CELLS, RESULTS, ROOT, SOURCES, places, read, renewed, write

UNMEASURED = {"C32"}
"""Claims that were stated since the reproduction whose figures the pages have."""
TABLE = "<!-- table: fast -->\n| crossing | trials |\n|---|---|\n| rightward | 1 |\n<!-- end of table -->\n"
COMMAND = ["run", "speed", "--repeats", "1", "--seed", "3", "--set", "experiment.speeds_cm_s=20"]


def test_every_page_shows_what_was_measured_and_every_picture_and_table_is_of_a_run_that_is_noted():
    measured = read(ROOT / RESULTS)
    assert [claim["id"] for claim in measured["claims"]] == [claim for claim in claim_ids() if claim not in UNMEASURED]
    pages = renewed(ROOT, measured)
    assert pages and all(page.read_text() == text for page, text in pages.items())
    shown = {place: digest for source in read(ROOT / SOURCES).values() for place, digest in source["shows"].items()}
    assert shown == places(ROOT)


def test_the_first_experiment_s_numbers_are_those_of_the_claim():
    (claim,) = [claim for claim in read(ROOT / RESULTS)["claims"] if claim["id"] == "C15"]
    means = dict(re.findall(r"(\d+) cm/s: ([\d.]+)", claim["measured"]))
    shown = re.findall(r"([\d.]+)(?: spikes)? at (\d+) cm/s", (ROOT / "README.md").read_text())
    assert {speed: float(number) for number, speed in shown} == {speed: float(mean) for speed, mean in means.items()}


def test_claims_of_the_paper_and_our_own_are_apart():
    measured = read(ROOT / RESULTS)
    told = {part: set(re.findall(r"\*\* \((\w+)\):", part(measured))) for part in (tool.claims, tool.own)}
    assert told[tool.claims] == set(claim_ids("C")) - UNMEASURED and told[tool.own] == set(claim_ids("B"))


def test_a_table_of_numbers_is_of_a_run_or_says_why_it_is_of_none():
    """A table is one of numbers if more than a third of its cells begin with one."""
    for page in CHAPTERS:
        text = re.sub(r"<!-- (table|measured): .*?<!-- end of \w+ -->", "", page.read_text(), flags=re.DOTALL)
        for before, table in re.findall(r"([^\n]*)\n((?:\|[^\n]*\n)+)", text):
            cells = [cell.strip() for row in table.splitlines()[2:] for cell in row.strip("|").split("|")]
            numbers = sum(bool(re.match(r"[-+]?\d", cell)) for cell in cells)
            assert before.startswith("<!-- no rows: ") or numbers <= len(cells) / 3, (page.name, table)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A run of two crossings, as its command leaves it in a clean checkout."""
    from experiments.cli.main import command

    folder = tmp_path_factory.mktemp("runs") / "fast"
    assert command([*COMMAND, "--out", str(folder), "--workers", "0", "--quiet"]) == 0
    description = json.loads((folder / "run.json").read_text())
    description["source"] |= {"commit": "abc123abc123", "dirty": False}
    (folder / "run.json").write_text(json.dumps(description))
    return folder


@pytest.fixture
def docs(run, tmp_path, monkeypatch):
    """The folder of a page with a table of the run, and of a reproduction that has the code's design."""
    monkeypatch.setattr(tool, "plan_of", lambda asked: asked.seed)
    monkeypatch.setattr(tool, "design", lambda seed: {"digest": f"of seed {seed}"})
    (tmp_path / "docs").mkdir()
    (tmp_path / "README.md").touch()
    (tmp_path / "docs" / "page.md").write_text(TABLE)
    (tmp_path / SOURCES).write_text("{}")
    scale = json.loads(to_json(dataclasses.asdict(QUICK)))
    measured = {"design": {"seed": 0, "scale": scale, "digest": "of seed 0"}, "measured_with": {"commit": "abc"},
                "eyes": {"commit": "abc"}}  # fmt: skip
    (tmp_path / RESULTS).write_text(json.dumps(measured))
    tool.main(["take", str(run), "page.md#fast"], tmp_path)
    return tmp_path


def changed(path, change):
    value = read(path)
    change(value)
    path.write_text(json.dumps(value))


@pytest.mark.parametrize("change, named", [
    (lambda docs: None, ""),
    (lambda docs: (docs / "docs/page.md").write_text(TABLE.replace("1 |", "2 |")), "#fast"),
    (lambda docs: (docs / "docs/page.md").write_text(""), "#fast"),
    (lambda docs: (docs / "docs/new.png").write_bytes(b"1"), "new.png"),
    (lambda docs: changed(docs / RESULTS, lambda value: value["design"].update(seed=1)), "design"),
    (lambda docs: changed(docs / RESULTS, lambda value: value["measured_with"].update(commit="a with changes")), "a "),
    (lambda docs: changed(docs / SOURCES, lambda value: value["fast"]["first"].update(peak_hs=0.5)), "peak_hs"),
    (lambda docs: changed(docs / SOURCES, lambda value: value["fast"]["first"].update(gone=0.5)), "gone"),
    (lambda docs: changed(docs / SOURCES, lambda value: value["fast"].update(
        command=value["fast"]["command"].replace("--seed 3", "--seed 4"))), "peak_hs"),
], ids=["as noted", "an edited table", "a table gone", "a picture of no run", "another design", "a changed tree",
        "another number", "a lost column", "another seed"])  # fmt: skip
def test_what_is_stale_is_refused(docs, change, named):
    change(docs)
    with pytest.raises(SystemExit, match=named) if named else contextlib.nullcontext():
        tool.check(docs)


def test_a_run_of_changed_code_or_without_a_place_is_not_taken(run, docs):
    text = (run / "run.json").read_text()
    try:
        (run / "run.json").write_text(text.replace('"dirty": false', '"dirty": true'))
        with pytest.raises(SystemExit, match="abc123abc123 with changes"):
            tool.note(run, ["page.md#fast"], docs)
    finally:
        (run / "run.json").write_text(text)
    with pytest.raises(SystemExit, match=r"other\.png"):
        tool.note(run, ["other.png"], docs)


def test_a_reproduction_is_taken_over(tmp_path):
    folder = tmp_path / "run"
    for name in ("run/behave-optomotor", "run/fidelity", "docs"):
        (tmp_path / name).mkdir(parents=True)
    held = Outcome("holds", "m")
    counts = [{"eye": eye, "wheels": wheels, "claim": "C14", **count_columns(Count(n, 20 - n))}
              for (eye, wheels), n in zip(CELLS, (20, 20, 0, 0), strict=True)]  # fmt: skip
    few = {"eye": "other", "wheels": "open loop", "claim": "C14", **count_columns(Count(5, 0))}
    study = {"study": "fidelity", "axes": {"eye": [], "wheels": []}, "replicates": 20, "counts": [*counts, few]}
    files = {
        "design": {"seed": 3, "scale": {"episodes": 2}, "digest": "d", "versions": {"numpy": "2"}},
        "claims": document([verdict_of(find_claim("C14", "robot"), [held] * 40)]), "behaviours": document([]),
        "fidelity/fidelity": study,
        "fidelity/run": {"source": {"commit": "abc123", "dirty": False}},
    }  # fmt: skip
    for name, value in files.items():
        (folder / f"{name}.json").write_text(to_json(value))
    score = "env,behaviour,measure,episodes,value,ci_low,ci_high\ncolias_sim/Optomotor-v0,still,gain,2,0.25,nan,nan\n"
    (folder / "behave-optomotor" / "summary.csv").write_text(score)
    (folder / "fidelity" / "trials.parquet").touch()
    write(tmp_path / RESULTS, {})
    (tmp_path / "README.md").touch()
    tool.main(["reproduction", str(folder)], tmp_path)
    shutil.rmtree(folder / "fidelity")
    tool.main(["reproduction", str(folder)], tmp_path)
    results = read(tmp_path / RESULTS)
    assert results["eyes"]["commit"] == "abc123", "the study of cameras stays"
    assert {row["eye"] for row in results["eyes"]["counts"]} == {eye for eye, _ in CELLS}, "of all replicates alone"
    assert [(one.holds, one.fails) for one in tool.counts(results)["C14"]] == [(40, 0), (20, 0), (0, 20), (0, 20)]
    assert [(score["behaviour"], float(score["value"])) for score in results["scores"]] == [("still", 0.25)]
