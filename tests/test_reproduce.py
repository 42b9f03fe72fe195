"""The reproduction as a user runs it, with a model and an experiment of their own, and its page in a browser."""

import dataclasses
import json
import re
import shutil
import subprocess

import pyarrow.parquet as pq
import pytest

from experiments.bench import registry
from experiments.bench.core.verdict import claim_texts
from experiments.bench.reproduction import claims as paper_claims
from experiments.bench.reproduction import robustness
from tests.chapters import titled
from tests.conftest import Colias

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    """``colias reproduce --quick`` with the examples of docs/, pasted."""
    colias = Colias(tmp_path_factory.mktemp("reproduce"), timeout_s=1200)  # minutes, on one core
    for name in ("my_experiment.py", "my_model.py"):
        (colias.folder / name).write_text(titled(name))
    own = ("--model", "my_model.py", "--experiment", "my_experiment.py")
    done = colias("reproduce", "--quick", "--out", "out", *own)
    assert done.returncode == 0, done.stderr
    return colias, done


def test_every_claim_is_answered(reproduced):
    colias, done = reproduced
    claims = json.loads((colias.folder / "out" / "claims.json").read_text())
    assert [claim["id"] for claim in claims] == list(claim_texts())
    left_out = {"C7", "C8", "C9", "C10", "C11", "C12", "C24", "C26"}
    judged = [claim for claim in claims if claim["id"] not in left_out]
    assert all(claim["verdict"] == "untested" for claim in claims if claim["id"] in left_out)
    assert "--quick" in claims[6]["measured"]
    assert all(claim["verdict"] in ("holds", "fails") and claim["n"] > 0 for claim in judged)
    at_seeds = [claim for claim in judged if claim["id"] in robustness.ROBOT_CLAIMS]
    assert all(0 <= claim["seeds_holding"] <= claim["seeds"] == 2 for claim in at_seeds)
    assert all(claim["pooled"].startswith(("holds: ", "fails: ")) for claim in at_seeds)
    assert all(claim["tried"] for claim in at_seeds if claim["seeds_holding"] < 2 or claim["verdict"] == "fails")
    assert all(claim["decided"] for claim in judged), "the number that decided stands beside every verdict"
    assert not any(claim["decided"] for claim in claims if claim["verdict"] == "untested")
    assert "colias watch" in claims[11]["measured"] and claims[11]["verdict"] == "untested"
    assert {"says", "measured"} <= claims[0].keys()
    own = json.loads((colias.folder / "out" / "behaviours.json").read_text())
    assert [(claim["id"], claim["verdict"]) for claim in own] == [(f"B{i}", "untested") for i in range(1, 5)]
    assert "C20" in done.stdout and "report.html" in done.stdout
    assert "not judged: C7, C8, C9, C10, C11, C12, C24, C26" in done.stdout
    page = (colias.folder / "out" / "report.html").read_text()
    assert "C7, C8, C9, C10, C11, C12, C24, C26, B1, B2, B3, B4. Each says below" in page
    assert "Nothing was moved in this run" in page


def test_the_looming_detectors_see_the_approaches(reproduced):
    colias, _ = reproduced
    trials = pq.read_table(colias.folder / "out" / "angular-approach" / "trials.parquet").to_pylist()
    assert {row["model"] for row in trials} == {"dsnn", "dsn2017", "gradient", "lgmd1", "lgmd2"}
    assert all(row["peak_looming"] > 0.5 for row in trials if row["model"].startswith("lgmd"))


def test_own_model_and_experiment_are_in_the_report(reproduced):
    colias, _ = reproduced
    page = (colias.folder / "out" / "report.html").read_text()
    assert 'id="my_experiment"' in page and ">gradient<" in page
    trials = pq.read_table(colias.folder / "out" / "my_experiment" / "trials.parquet")
    assert set(trials["model"].to_pylist()) == {"dsnn", "dsn2017", "gradient"}
    rightward = [row for row in trials.to_pylist() if row["model"] == "gradient"]
    assert all(row["peak_hs"] > -row["trough_hs"] for row in rightward), "the example knows right from left"


def test_the_page_needs_nothing_from_outside(reproduced):
    colias, _ = reproduced
    folder = colias.folder / "out"
    page = (folder / "report.html").read_text()
    for target in re.findall(r'(?:src|href)="([^"]*)"', page):
        inside = target.startswith(("data:", "#"))
        assert inside or (folder / target).is_file(), target
    assert "@import" not in page and "url(" not in page
    anchors = set(re.findall(r'id="([^"]*)"', page))
    assert {t[1:] for t in re.findall(r'href="(#[^"]*)"', page)} <= anchors


def test_again_in_the_same_folder_runs_nothing(reproduced):
    colias, _ = reproduced
    before = (colias.folder / "out" / "seeds" / "trials.parquet").read_bytes()
    own = ("--model", "my_model.py", "--experiment", "my_experiment.py")
    done = colias("reproduce", "--quick", "--out", "out", *own)
    assert done.returncode == 0
    assert "other seeds: 210 trials, on 1 worker; 210 of them done already" in done.stderr
    assert (colias.folder / "out" / "seeds" / "trials.parquet").read_bytes() == before
    other = colias("reproduce", "--quick", "--out", "out", *own, "--seed", "3")
    assert (other.returncode, other.stderr.splitlines()[-1].count("seed is 0 there and 3 now")) == (2, 1)


PROBE = """<!doctype html><title>waiting</title>
<iframe id="page" src="report.html" width="{width}" height="900"></iframe>
<script>
document.getElementById("page").onload = event => {{
  const page = event.target.contentDocument, body = page.documentElement;
  const pictures = [...page.images];
  document.title = JSON.stringify({{
    heading: page.querySelector("h1").innerText, overflow: body.scrollWidth - {width},
    pictures: pictures.length, drawn: pictures.filter(p => p.complete && p.naturalWidth > 0).length,
    claims: page.querySelectorAll(".claim").length,
  }});
}};
</script>"""


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'")
@pytest.mark.parametrize("width", [360, 1200])
def test_the_page_in_a_browser(reproduced, width, tmp_path):
    """In Chromium, without a network, as wide as a phone and as a desk: everything drawn, nothing sticks out."""
    colias, _ = reproduced
    probe = colias.folder / "out" / f"probe-{width}.html"
    probe.write_text(PROBE.format(width=width))
    command = [
        CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        "--host-resolver-rules=MAP * ~NOTFOUND", "--allow-file-access-from-files", f"--user-data-dir={tmp_path}",
        "--window-size=1300,1000", "--virtual-time-budget=20000", "--dump-dom", probe.as_uri(),
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    seen = json.loads(re.search(r"<title>(.*?)</title>", done.stdout).group(1).replace("&quot;", '"'))
    assert "claims hold" in seen["heading"]
    assert seen["overflow"] <= 0
    assert seen["claims"] == 21 + 4  # the paper's, and our own of behaviours
    assert seen["drawn"] == seen["pictures"] == 10 + 3


@pytest.mark.parametrize("name", ["seeds", "sensitivity", "speed"])
def test_an_experiment_s_name_that_is_taken_is_one_line(colias, name):
    text = titled("my_experiment.py").replace('"my_experiment"', f'"{name}"')
    (colias.folder / "mine.py").write_text(text)
    done = colias("reproduce", "--quick", "--experiment", "mine.py", "--out", "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert f"--experiment {name}: that name is taken" in done.stderr
    assert not (colias.folder / "out").exists()


def test_moves_change_what_they_name_and_nothing_else():
    """Each case of the sensitivity study differs from the defaults in its own parameter, and in no seed."""
    network, *apparatus = robustness.sensitivity_cases(1, 0)
    assert network.labels == ("dsnn", *robustness.NETWORK_MOVES)
    defaults = network.specs[0].settings
    for case, (name, changes) in zip(apparatus, robustness.APPARATUS_MOVES.items(), strict=True):
        assert case.name == name
        assert [s.seed for s in case.specs] == [s.seed for s in network.specs]
        assert len(case.specs[0].settings.models) == 1
        if not changes[0].startswith("experiment."):
            assert (case.specs[0].settings.camera, case.specs[0].settings.scene) != (defaults.camera, defaults.scene)
    base, *moved = defaults.models
    assert all(model.network != base.network for model in moved)


def test_a_claim_is_judged_on_the_trials_of_one_experiment_throughout():
    """Headline, other seeds and moves: the experiment that declares it, and no other one's trials."""
    where = robustness.judged_in()
    assert where["C13"] == where["C14"] == "general"
    for claim, name in where.items():
        assert claim in registry.load(name).claims
    assert set(robustness.ROBOT_CLAIMS) <= set(where)
    (case,) = robustness.seed_cases([0], 5)
    assert {spec.experiment for spec in case.specs} == set(robustness.PAPER)
    silent = {"spikes": 0, "peak_hs": 0.1, "trough_hs": -0.1, "path_error_mm": 0.1, "model": "dsnn"}
    rows = [
        {"trial": index, "experiment": spec.experiment, **dataclasses.asdict(spec.condition), **silent,
         "achieved_speed_cm_s": spec.condition.speed_cm_s}
        for index, spec in enumerate(case.specs)
    ]  # fmt: skip
    assert robustness.verdicts([case], rows)["0"]["C13"] == "holds"
    spiking = [row | {"spikes": 3 * (row["experiment"] == "angular-recession")} for row in rows]
    assert (
        robustness.verdicts([case], spiking)["0"]["C13"] == robustness.pooled([case], spiking)["C13"].verdict == "holds"
    )
    spiking = [row | {"spikes": 3 * (row["experiment"] == "general")} for row in rows]
    assert (
        robustness.verdicts([case], spiking)["0"]["C13"] == robustness.pooled([case], spiking)["C13"].verdict == "fails"
    )
    lost = [
        row
        for row in rows
        if row["trial"] != case.specs.index(next(s for s in case.specs if s.experiment == "general"))
    ]
    found = robustness.verdicts([case], lost)["0"]
    assert found["C13"] == found["C14"] == "untested" != found["C16"]


def test_a_claim_of_the_robot_that_no_experiment_declares_says_so(monkeypatch):
    """And not that it needs footage."""
    monkeypatch.setattr(robustness, "judged_in", dict)
    said = {claim.id: claim.measured for claim in paper_claims.verdicts([], [], {}, {}, "")}
    assert "footage" in said["C12"] and "footage" not in said["C15"]
    assert said["C15"] == "none of the experiments here declares this claim"


def test_a_case_with_a_trial_missing_is_untested():
    cases = robustness.seed_cases([0], 1)
    assert set(robustness.verdicts(cases, [])["0"].values()) == {"untested"}
