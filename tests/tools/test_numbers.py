"""The measured figures of README.md and docs/ are those of docs/results.json, of the design that the code has now."""

import contextlib
import copy
import dataclasses
import functools
import io
import json
import math
import re
import subprocess
import sys
from pathlib import Path

import polars as pl
import pytest

from experiments import Check
from experiments.bench import leaderboard
from experiments.bench.footage import claims as footage_claims
from experiments.bench.reproduce import FULL, QUICK, USUAL, design, planned
from experiments.bench.sources.robot_claims import paper_claims
from experiments.bench.stats import tests as statistics
from experiments.bench.stats.claim import PAPER, claim_ids, words
from experiments.bench.stats.count import SIGNS, Count
from experiments.bench.stats.stored import document, plain
from experiments.bench.stats.verdict import Outcome, Verdict
from experiments.bench.store.description import to_json
from experiments.bench.store.files import rows_hash
from experiments.bench.studies.counts import FORM
from experiments.bench.tune import FAMILIES
from experiments.studies.fidelity import EYE, WHEELS
from tests.helpers.chapters import PAGES as EVERY_PAGE
from tools.numbers import CELLS, PAGES, RESULTS, ROOT, STALE, SUMMARY, blocks, main, renewed, stale, unfit

CLAIMS = paper_claims()

MARKED = re.compile(r"<!-- measured: .*?<!-- end of measured -->", re.DOTALL)


def results():
    return json.loads(RESULTS.read_text())


@functools.cache
def described(scale):
    return json.loads(to_json(design(planned(scale, 0))))


@pytest.mark.parametrize("page", PAGES)
def test_a_page_says_what_was_measured(page):
    text, parts = (ROOT / page).read_text(), blocks(results())
    assert text == renewed(page, text, {name: parts[name] for name in PAGES[page]}), "run 'make numbers'"
    assert len(MARKED.findall(text)) == len(PAGES[page])


def test_every_measured_part_has_a_page():
    assert {name for names in PAGES.values() for name in names} == set(blocks(results()))
    marked = {str(page.relative_to(ROOT)) for page in EVERY_PAGE if MARKED.search(page.read_text())}
    assert marked == set(PAGES)


def test_figures_of_another_design_say_so_and_are_no_release():
    """Other replicates, repeats or frames, another parameter or bound: the figures are of something else."""
    measured = results()
    marked = [STALE in blocks(measured)[name] for name in ("summary", "claims")]
    assert marked == [stale(measured)] * 2
    fresh = copy.deepcopy(measured)
    fresh["design"] = {name: described(USUAL)[name] for name in ("seed", "scale", "digest")}
    fresh |= {"rows": {"speed": "hash"}, "measured_with": {**measured["measured_with"], "commit": "abc"}}
    assert not stale(fresh) and not unfit(fresh) and STALE not in blocks(fresh)["summary"]
    changed = copy.deepcopy(fresh)
    changed["design"]["scale"]["repeats"] -= 1
    assert stale(changed) and "of another design" in unfit(changed)
    assert "nobody can check out" in unfit(fresh | {"measured_with": {"commit": "abc-dirty"}})
    assert "no hash of their rows" in unfit(fresh | {"rows": {}})


def test_the_hash_of_rows_is_of_what_they_say_and_not_of_the_time_they_took(tmp_path):
    def written(name, **columns):
        pl.DataFrame({"spikes": [1, 2], "wall_s": [0.1, 0.2]} | columns).write_parquet(tmp_path / name)
        return rows_hash(tmp_path / name)

    first = written("a")
    assert written("b", wall_s=[9.0, 9.0]) == first != written("c", spikes=[1, 3])


def test_a_release_is_refused_while_figures_are_stale():
    done = called("--check")
    why = unfit(results())
    assert (done.returncode, done.stderr) == ((2, f"numbers: {why}\n") if why else (0, ""))


def rows_of(table):
    return [row for row in table.splitlines() if row.startswith("| ")][1:]


def test_the_summary_counts_every_claim_and_has_ten_rows():
    """A claim that fails or was not judged has a row of its own, or is counted in one."""
    rows = rows_of(blocks(results())["summary"])
    assert len(rows) == len(SUMMARY) + 2 == 10
    ideal = [row.split(" | ")[1] for row in rows]
    for sign, kind in SIGNS.items():
        counted = sum(int(number) for cell in ideal[len(SUMMARY) :] for number in re.findall(rf"{kind} (\d+)", cell))
        alone = sum(cell.startswith(kind) for cell in ideal[: len(SUMMARY)])
        assert counted + alone == sum(Count(**claim["count"]).kind == sign for claim in results()["claims"])


def test_the_results_page_has_every_claim_with_its_verdict_count_and_bound():
    measured = results()
    claims = [*measured["claims"], *measured["behaviours"]]
    rows = rows_of(blocks(measured)["claims"])
    assert len(rows) == len(claims) == len(claim_ids())
    for row, claim in zip(rows, claims, strict=True):
        count, (_, verdict, decided) = Count(**claim["count"]), row.strip("| ").split(" | ")
        assert f"({claim['id']})" in row and verdict.startswith(SIGNS[count.kind])
        if count.random and count.judged and not count.half:
            assert f"{count.holds} of {count.judged}" in verdict
        assert claim["outcome"]["decided"].replace("|", r"\|") in decided


def test_the_first_experiments_numbers_are_those_of_the_claim():
    (claim,) = [claim for claim in results()["claims"] if claim["id"] == "C15"]
    means = dict(re.findall(r"(\d+) cm/s: ([\d.]+)", claim["outcome"]["measured"]))
    shown = re.findall(r"([\d.]+)(?: spikes)? at (\d+) cm/s", (ROOT / "README.md").read_text())
    assert {speed: float(number) for number, speed in shown} == {speed: float(mean) for speed, mean in means.items()}


def test_every_claim_has_a_figure_and_every_scale_a_design():
    if not stale(results()):
        assert [claim["id"] for claim in results()["claims"]] == list(claim_ids(PAPER))
    assert len({described(scale)["digest"] for scale in (QUICK, USUAL, FULL)}) == 3


def verdict_of(claim, *outcomes):
    return Verdict.of((claim, "it turns", "ours"), outcomes)


CHECK = Check("|VS| <up> to 0.1", 0.1, 0.2, "below")


@pytest.fixture
def run(tmp_path):
    """A folder such as ``colias reproduce`` leaves, with made-up numbers, and a README."""
    folder = tmp_path / "run"
    (folder / "behave-optomotor").mkdir(parents=True)
    files = {
        "design": {"seed": 3, "scale": {"repeats": 7, "episodes": 2, "steps": 90}, "digest": "d",
                   "versions": {"numpy": "2"}},
        "claims": document([
            verdict_of("C1", Outcome("holds", "m", decided="|VS| 0.1 (needs below 0.2)", checks=(CHECK,)),
                 Outcome("fails", "m", checks=(dataclasses.replace(CHECK, reading=0.3),)),
                 Outcome("holds", "m", checks=(dataclasses.replace(CHECK, reading=math.nan),)), Outcome.unjudged("m")),
            verdict_of("C2", Outcome.unjudged("needs more; measured: 4")),
        ]),
        "pooled": {"C13": plain(Outcome("fails", "m", n=60, broken=1))},
        "behaviours": document([verdict_of("B3", Outcome("fails", "0.2 [0.1, 0.3]", decided="0.1 (needs above 0.5)"))]),
    }  # fmt: skip
    for name, value in files.items():
        (folder / f"{name}.json").write_text(to_json(value))
    (folder / "behave-optomotor" / "scores.csv").write_text(
        '"env","behaviour","measure","episodes","value","ci_low","ci_high"\n'
        '"colias_sim/Optomotor-v0","still","optomotor gain",2,0.25,nan,nan\n'
        '"colias_sim/Optomotor-v0","still","free distance (m)",2,inf,0.5,inf\n'
        '"colias_sim/Optomotor-v0","still","return",2,9,8,10\n'
    )
    for page, names in PAGES.items():
        (tmp_path / page).parent.mkdir(exist_ok=True)
        markers = [f"<!-- measured: {name} -->\nold\n<!-- end of measured -->" for name in names]
        (tmp_path / page).write_text("before\n" + "\nbetween\n".join(markers) + "\nafter\n")
    return folder


def called(*arguments):
    """Do what ``python -m tools.numbers`` does, in this process."""
    status, out, err = 0, io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), pytest.MonkeyPatch.context() as patch:
        patch.setattr(sys, "argv", ["numbers", *map(str, arguments)])
        try:
            main()
        except SystemExit as end:
            status = end.code
    return subprocess.CompletedProcess(arguments, status, out.getvalue(), err.getvalue())


def take(run):
    return called(run, "--root", run.parent)


def pages(run):
    return {page: (run.parent / page).read_text() for page in PAGES}


def test_the_command_takes_figures_over(run):
    done = take(run)
    assert (done.returncode, done.stderr) == (0, "")
    texts = pages(run)
    for text in texts.values():
        assert text.startswith("before\n") and text.endswith("\nafter\n") and "\nold\n" not in text
    readme, home, claims, means, behaviours = texts.values()
    summary = f"2 claims with an ideal camera: {SIGNS['counted']} 1 with too few replicates, {SIGNS['unjudged']} 1 not"
    assert summary in readme and summary in home
    counted = "1 of 2 claims held in some: C1; 1 was not judged: C2"
    assert f"{counted}. A replicate has 7" in claims
    c1 = rf"(C1): {words('C1').says}. | # held in 2 of 3 | \|VS\| 0.1 (needs below 0.2) |"
    assert c1 in claims
    assert f"{SIGNS['unjudged']} not judged (what it needs was not shown) | needs more |" in claims
    assert "- half wave rectified F: all claims" in means
    assert "Over 2 episodes of at most 3 s each, at seeds 3 to 4" in behaviours
    assert (
        "| Optomotor | `still` | optomotor gain 0.25; free distance (m) inf (0.5 .. inf); return 9 (8 .. 10) |"
        in behaviours
    )
    assert "- B3 failed: it turns. Measured: 0.2 [0.1, 0.3]. Decided by: 0.1 (needs above 0.5)." in behaviours
    kept = json.loads((run.parent / "docs" / "results.json").read_text())
    assert kept["design"]["digest"] == "d" and {"commit", "numpy"} <= set(kept["measured_with"])
    assert take(run).returncode == 0 and pages(run) == texts, "again changes nothing"


@pytest.mark.parametrize(
    "missing", ["design.json", "pooled.json", "claims.json", "behaviours.json", "behave-optomotor/scores.csv"]
)
def test_an_unfinished_run_is_refused(run, missing):
    (run / missing).unlink()
    before = pages(run)
    done = take(run)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert Path(missing).name in done.stderr
    assert pages(run) == before and not (run.parent / "docs" / "results.json").exists()


@pytest.mark.parametrize("page", PAGES)
def test_a_page_without_markers_is_refused(run, page):
    (run.parent / page).write_text("nothing measured\n")
    before = pages(run)
    done = take(run)
    assert done.returncode == 2 and page in done.stderr and f"<!-- measured: {PAGES[page][0]} -->" in done.stderr
    assert pages(run) == before and not (run.parent / "docs" / "results.json").exists()


SETTINGS = {
    "C13": {"5", "100", "20", "17", "0.9", "1"},
    "C19": {"-15", "0", "15", "10", "100", "0.9", "1"},
    "C21": {"99", "72"},
    "C25": {"50", "100"},
    "C29": {"1", "6", "10"},
    "C30": {"6"},
    "C6": set(),
    "C7": {"2017", "0.01"},
    "C9": {"40", "60", "120"},
    "C23": {"0.9", "1", "4"},
    "C26": {"4", "8"},
    "B2": {"10", "22"},
    "C28": {"50", "160", "22", "110", "70", "120", "0.9", "200", "150", "140", "1.4", "80"},
}
"""What a claim's `tried` may say in figures: what was set, never what was measured."""


def test_what_was_tried_quotes_no_measured_figure():
    for claim, text in ((claim, words(claim).tried) for claim in claim_ids()):
        plain = re.sub(r"\b(C|LGMD|B)\d+|cm/s2", "", text)
        figures = set(re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", plain))
        assert figures <= SETTINGS.get(claim, set()), (claim, figures - SETTINGS.get(claim, set()))


def test_a_cause_is_one_line_and_quotes_no_measured_figure():
    """Every claim of which it is told what was tried has one."""
    causes = {claim: words(claim).cause for claim in claim_ids() if words(claim).cause}
    assert set(causes) == {claim for claim in claim_ids() if words(claim).tried}
    for claim, text in causes.items():
        assert len(text) <= 120 and "\n" not in text and text.endswith("."), claim
        plain = re.sub(r"\b(C|LGMD|B)\d+|cm/s2|model of 2017", "", text)
        figures = set(re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", plain))
        assert figures <= SETTINGS.get(claim, set()), (claim, figures - SETTINGS.get(claim, set()))


def prose():
    """All pages without what is measured, each run of blanks and line ends as one blank."""
    return " ".join(" ".join(MARKED.sub("", page.read_text()) for page in EVERY_PAGE).split())


def test_prose_quotes_no_measured_interval():
    prose = re.sub(r"```.*?```", "", " ".join(MARKED.sub("", page.read_text()) for page in EVERY_PAGE), flags=re.DOTALL)
    assert not re.findall(r"\(-?[\d.]+ \.\. -?[\d.]+\)|\bof 20 seeds|\d times as|processor time", prose)


def test_the_figures_of_design_in_prose_are_those_of_the_code():
    text = prose()
    plain, clutter = leaderboard.clip_experiments(leaderboard.DIRECTION, ["dsnn"])
    robot = len(leaderboard.ROBOT.design.conditions()) * leaderboard.REPEATS
    alone = sum(dict(clip.changes).get("object") == "absent" or clip.stimulus == "foliage" for clip in clutter.clips)
    means, every = ({claim.least for claim in CLAIMS.values() if claim.of_every_trial == of} for of in (False, True))
    (least,), (most,) = means, every
    assert USUAL.steps == 30 * 30
    for phrase in (
        f"the same {robot} robot trials",
        f"the same {len(plain.clips) * plain.repeats + len(clutter.clips) * clutter.repeats} clips",
        f"; {alone * clutter.repeats} of background alone",
        f"every model, {sum(len(family.probes) for family in FAMILIES.values())} clips",
        f"{USUAL.replicates} replicates (`--full`: {FULL.replicates} with the robot,"
        f" {FULL.offline_replicates} of clips)",
        f"{USUAL.repeats} repeats of each condition at one seed",
        f"at {USUAL.episodes} seeds, for half a minute each",
        f"at least {least} trials of each condition, or {most} if it is about every single trial",
        f"passes T in {footage_claims.LEAST_SECONDS} separate seconds",
        f"of {statistics.PERMUTATIONS} permutations",
        f"of a mean of {statistics.LEAST_FOR_INTERVAL} or {statistics.LEAST_FOR_BOOTSTRAP - 1} trials is Student's",
    ):
        assert phrase in text, phrase


def test_claims_about_the_robot_are_shown_under_each_camera_and_drive(run):
    """The study of eyes inside the folder gives the columns; all counts of a claim are then its own."""
    (run / "fidelity").mkdir()
    counts = [
        {"point": {EYE.name: eye, WHEELS.name: wheels}, "claim": "C14", "holds": holds, "fails": 20 - holds}
        for (eye, wheels), holds in zip(CELLS, (20, 20, 0, 0), strict=True)
    ]
    study = {"form": FORM, "study": "fidelity", "counts": counts}
    (run / "fidelity" / "fidelity.json").write_text(json.dumps(study))
    stored = json.loads((run / "claims.json").read_text())
    stored["claims"] += document([verdict_of("C14", *[Outcome("holds", "m")] * 40)])["claims"]
    (run / "claims.json").write_text(json.dumps(stored))
    assert take(run).returncode == 0
    texts, sign = pages(run), SIGNS["fails"]
    held, failed = f"{SIGNS['holds']} holds (40 of 40)", f"{sign} fails (0 of 20)"
    assert f"(C14) | {held} | {held.replace('40', '20')} | {failed} | {failed} |" in texts["docs/results.md"]
    assert f"| {SUMMARY['C14']} (C14) | {held} | {failed} |" in texts["README.md"]


def test_without_a_run_the_pages_alone_are_renewed(run):
    assert take(run).returncode == 0
    texts = pages(run)
    (run.parent / "README.md").write_text("<!-- measured: summary -->\nold\n<!-- end of measured -->\n")
    assert called("--root", run.parent).returncode == 0
    assert "\nold\n" not in pages(run)["README.md"] and pages(run)["docs/results.md"] == texts["docs/results.md"]
