"""The README's measured figures are those of docs/results.json, which is of the design that the code has now."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from experiments.bench import footage_claims, leaderboard_trials, statistics
from experiments.bench.claims import LEAST, OF_EVERY_TRIAL
from experiments.bench.description import to_json
from experiments.bench.paper import claim_texts, tried
from experiments.bench.reproduce_plan import QUICK, USUAL, design, planned
from experiments.bench.tuning import families
from tools.numbers import README, RESULTS, ROOT, blocks, renewed

MARKED = re.compile(r"<!-- measured: .*?<!-- end of measured -->", re.DOTALL)


def results():
    return json.loads(RESULTS.read_text())


def described(scale):
    return json.loads(to_json(design(planned(scale, 0))))


def test_the_readme_says_what_was_measured():
    text = README.read_text()
    assert text == renewed(text, blocks(results())), "run 'make numbers'"
    assert len(MARKED.findall(text)) == len(blocks(results())) == 2


def test_what_was_measured_is_of_the_design_that_the_code_has():
    """Another number of seeds, repeats or frames, another parameter or bound: the figures are of something else."""
    now = described(USUAL)
    assert results()["design"] == {name: now[name] for name in ("seed", "scale", "digest")}, "run 'make numbers'"
    assert [claim["id"] for claim in results()["claims"]] == list(claim_texts())
    assert described(QUICK)["digest"] != now["digest"]


@pytest.fixture
def run(tmp_path):
    """A folder such as ``colias reproduce`` leaves, with made-up numbers, and a README."""
    folder = tmp_path / "run"
    (folder / "behave-optomotor").mkdir(parents=True)
    files = {
        "design": {"seed": 3, "scale": {"repeats": 7, "seed_repeats": 6, "episodes": 2, "steps": 90}, "digest": "d",
                   "versions": {"numpy": "2"}},
        "claims": [
            {"id": "C1", "verdict": "holds", "seeds_holding": 2, "seeds": 3, "seeds_untested": 1,
             "decided": "|VS| 0.1 (needs below 0.2)", "measured": "m"},
            {"id": "C2", "verdict": "untested", "seeds_holding": None, "seeds": None, "seeds_untested": None,
             "decided": "", "measured": "needs more; measured: 4"},
        ],
        "behaviours": [{"id": "B3", "says": "it turns", "verdict": "fails", "decided": "0.1 (needs above 0.5)",
                        "measured": "0.2 [0.1, 0.3]"}],
    }  # fmt: skip
    for name, value in files.items():
        (folder / f"{name}.json").write_text(json.dumps(value))
    (folder / "behave-optomotor" / "scores.csv").write_text(
        '"env","behaviour","measure","episodes","value","ci_low","ci_high"\n'
        '"colias_sim/Optomotor-v0","still","optomotor gain",2,0.25,nan,nan\n'
        '"colias_sim/Optomotor-v0","still","free distance (m)",2,inf,0.5,inf\n'
        '"colias_sim/Optomotor-v0","still","return",2,9,8,10\n'
    )
    markers = [f"<!-- measured: {name} -->\nold\n<!-- end of measured -->" for name in ("claims", "behaviours")]
    (tmp_path / "README.md").write_text("before\n" + "\nbetween\n".join(markers) + "\nafter\n")
    return folder


def take(run):
    command = [sys.executable, "-m", "tools.numbers", str(run), "--results", str(run.parent / "results.json"),
               "--readme", str(run.parent / "README.md")]  # fmt: skip
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=False)


def test_the_command_takes_figures_over(run):
    done = take(run)
    assert (done.returncode, done.stderr) == (0, "")
    text = (run.parent / "README.md").read_text()
    assert (
        text.startswith("before\n") and "\nbetween\n" in text and text.endswith("\nafter\n") and "\nold\n" not in text
    )
    assert "Of the 2 claims 1 hold at seed 3; C2 is untested (7 repeats" in text
    assert r"| C1 | holds | 2 of 3, 1 untested | \|VS\| 0.1 (needs below 0.2) |" in text
    assert "| C2 | untested |  | needs more |" in text
    assert "Over 2 episodes of at most 3 s each, at seeds 3 to 4" in text
    assert "| Optomotor | `still` | optomotor gain 0.25; free distance (m) inf (0.5 .. inf) |" in text
    assert "- B3 fails: it turns. Measured: 0.2 [0.1, 0.3]. Decided by: 0.1 (needs above 0.5)." in text
    kept = json.loads((run.parent / "results.json").read_text())
    assert kept["design"]["digest"] == "d" and {"commit", "numpy"} <= set(kept["measured_with"])
    assert take(run).returncode == 0 and (run.parent / "README.md").read_text() == text, "again changes nothing"


@pytest.mark.parametrize("missing", ["design.json", "claims.json", "behaviours.json", "behave-optomotor/scores.csv"])
def test_an_unfinished_run_is_refused(run, missing):
    (run / missing).unlink()
    before = (run.parent / "README.md").read_text()
    done = take(run)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert Path(missing).name in done.stderr
    assert (run.parent / "README.md").read_text() == before and not (run.parent / "results.json").exists()


def test_a_readme_without_markers_is_refused(run):
    (run.parent / "README.md").write_text("nothing measured\n")
    done = take(run)
    assert done.returncode == 2 and "<!-- measured: claims -->" in done.stderr
    assert not (run.parent / "results.json").exists()


SETTINGS = {
    "C13": {"5", "100", "20", "17", "0.9", "1"},
    "C19": {"-15", "0", "15", "10", "100", "0.9", "1"},
    "C21": {"99", "72"},
    "C6": set(),
    "C7": {"2017", "10"},
    "B2": {"10", "22"},
}
"""What `tried.toml` may say in figures: what was set, never what was measured."""


def test_what_was_tried_quotes_no_measured_figure():
    for claim, text in tried().items():
        plain = re.sub(r"\b(C|LGMD|B)\d+|cm/s2", "", text)
        figures = set(re.findall(r"(?<![\w.])-?\d+(?:\.\d+)?", plain))
        assert figures <= SETTINGS[claim], (claim, figures - SETTINGS[claim])


def test_the_readme_s_prose_quotes_no_measured_interval():
    prose = re.sub(r"```.*?```", "", MARKED.sub("", README.read_text()), flags=re.DOTALL)
    assert not re.findall(r"\(-?[\d.]+ \.\. -?[\d.]+\)|\bof 20 seeds|\d times as|processor time", prose)


def test_the_readme_s_figures_of_design_are_those_of_the_code():
    prose = MARKED.sub("", README.read_text())
    plain, clutter = leaderboard_trials.clip_experiments(["dsnn"])
    robot = len(leaderboard_trials.ROBOT.design.conditions()) * leaderboard_trials.REPEATS
    alone = sum(dict(clip.changes).get("object") == "absent" or clip.stimulus == "foliage" for clip in clutter.clips)
    means, every = ({LEAST[claim] for claim in LEAST if (claim in OF_EVERY_TRIAL) == of} for of in (False, True))
    (least,), (most,) = means, every
    assert USUAL.steps == 30 * 30
    for said in (
        f"the same {robot} robot trials",
        f"the same {len(plain.clips) * plain.repeats + len(clutter.clips) * clutter.repeats} clips",
        f"; {alone * clutter.repeats} of background alone",
        f"every model, {sum(len(family.probes) for family in families(()))} clips",
        f"the robot's again at {USUAL.seeds} seeds",
        f"at {USUAL.episodes} seeds, for half a minute each",
        f"at least {least} trials of each condition, or {most} if it is about every single trial",
        f"passes T in {footage_claims.LEAST_SECONDS} separate seconds",
        f"of {statistics.PERMUTATIONS} permutations",
        f"of a mean of fewer than {statistics.LEAST_FOR_BOOTSTRAP} trials it is Student's",
    ):
        assert said in prose, said
