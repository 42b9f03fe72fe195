"""The reproduction as a user runs it, with a model and an experiment of their own, and its page in a browser."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from experiments.bench import study
from tests.conftest import Colias

README = Path(__file__).parents[1] / "README.md"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


def example(name: str) -> str:
    return README.read_text().split(f"```python title={name}\n")[1].split("```")[0]


@pytest.fixture(scope="module")
def reproduced(tmp_path_factory):
    """``colias reproduce --quick`` with the README's examples, pasted."""
    colias = Colias(tmp_path_factory.mktemp("reproduce"))
    for name in ("my_experiment.py", "my_model.py"):
        (colias.folder / name).write_text(example(name))
    own = ("--model", "my_model.py", "--experiment", "my_experiment.py")
    done = colias("reproduce", "--quick", "--out", "out", *own)
    assert done.returncode == 0, done.stderr
    return colias, done


def test_every_claim_is_answered(reproduced):
    colias, done = reproduced
    claims = json.loads((colias.folder / "out" / "claims.json").read_text())
    assert [claim["id"] for claim in claims] == [f"C{i}" for i in range(1, 22)]
    judged = [claim for claim in claims if claim["id"] in study.ROBOT_CLAIMS]
    assert all(claim["verdict"] in ("holds", "fails") and claim["n"] > 0 for claim in judged)
    assert all(0 <= claim["seeds_holding"] <= claim["seeds"] == 2 for claim in judged)
    assert all(claim["verdict"] == "untested" for claim in claims if claim not in judged)
    assert {"says", "measured"} <= claims[0].keys()
    assert "C20" in done.stdout and "report.html" in done.stdout


def test_own_model_and_experiment_are_in_the_report(reproduced):
    colias, _ = reproduced
    page = (colias.folder / "out" / "report.html").read_text()
    assert 'id="my_experiment"' in page and ">gradient<" in page
    trials = pq.read_table(colias.folder / "out" / "my_experiment" / "trials.parquet")
    assert set(trials["model"].to_pylist()) == {"dsnn", "gradient"}
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
    assert "other seeds: 36 trials, 0 of them to do" in done.stderr
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
    assert seen["claims"] == 21
    assert seen["drawn"] == seen["pictures"] == 7


def test_moves_change_what_they_name_and_nothing_else():
    """Each case of the sensitivity study differs from the defaults in its own parameter, and in no seed."""
    network, *apparatus = study.sensitivity_cases(1, 0)
    assert network.labels == ("dsnn", *study.NETWORK_MOVES)
    defaults = network.specs[0].settings
    for case, (name, changes) in zip(apparatus, study.APPARATUS_MOVES.items(), strict=True):
        assert case.name == name
        assert [s.seed for s in case.specs] == [s.seed for s in network.specs]
        assert len(case.specs[0].settings.models) == 1
        if not changes[0].startswith("experiment."):
            assert (case.specs[0].settings.camera, case.specs[0].settings.scene) != (defaults.camera, defaults.scene)
    base, *moved = defaults.models
    assert all(model.network != base.network for model in moved)


def test_a_case_with_a_trial_missing_is_untested():
    cases = study.seed_cases([0], 1)
    assert set(study.verdicts(cases, [])["0"].values()) == {"untested"}


def test_sweeps_share_stimuli_and_tabulate_the_grid(tmp_path):
    import csv

    colias = Colias(tmp_path)
    quick = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "-q")
    over = ("--over", "dsnn.n_con=4,8", "--over", "camera.read_noise=0,0.64")
    done = colias("sweep", "speed", *quick, *over, "--out", "out")
    assert done.returncode == 0, done.stderr
    with (tmp_path / "out" / "sweep.csv").open() as file:
        rows = list(csv.DictReader(file))
    grid = {(row["dsnn.n_con"], row["camera.read_noise"], row["speed_cm_s"]) for row in rows}
    assert len(rows) == len(grid) == 8
    assert (tmp_path / "out" / "figure.svg").exists()
    alone = colias("run", "speed", *quick, "--set", "dsnn.n_con=4", "--no-recordings", "--out", "alone")
    assert alone.returncode == 0
    trials = pq.read_table(tmp_path / "alone" / "trials.parquet").to_pylist()
    mean = sum(row["spikes"] for row in trials if row["speed_cm_s"] == 20.0) / 2
    (point,) = [r for r in rows if (r["dsnn.n_con"], r["camera.read_noise"], r["speed_cm_s"]) == ("4", "0.64", "20")]
    assert float(point["spikes_mean"]) == mean


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--over", "dsnn.n_con"), "SECTION.NAME=VALUE"),
        (("--over", "dsnn.n_con=4,4"), "twice"),
        (("--over", "dsnn.n_kon=4,8"), "no parameter 'dsnn.n_kon'"),
        (("--over", "dsnn.n_con=4,99"), "from 1 to 64"),
        (("--over", "scene.arena=bright,brigth"), "nearest: bright"),
    ],
)
def test_wrong_grids_end_in_one_line(colias, arguments, says):
    done = colias("sweep", "speed", *arguments, "--out", "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert says in done.stderr
    assert not (colias.folder / "out").exists()


BROKEN_MODELS = {
    "MODEL = 3\n": "expected a dsnn.ModelEntry",
    "x = 1\n": "declares no MODEL",
    "import absent_module\n": "mine.py, line 1: ModuleNotFoundError",
}


@pytest.mark.parametrize("text", BROKEN_MODELS)
def test_a_broken_model_file_is_one_line(colias, text):
    (colias.folder / "mine.py").write_text(text)
    done = colias("run", "speed", "--model", "mine.py")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1), done.stderr
    assert BROKEN_MODELS[text] in done.stderr


def test_a_model_that_breaks_in_a_trial_fails_that_trial_alone(colias):
    """Reported with its reason; the others' rows are there, and the exit status says it."""
    text = example("my_model.py").replace(
        "        down, right",
        "        if now.mean() > 0 and frame[0, 0] % 2:\n            raise ValueError('odd')\n        down, right",
    )
    (colias.folder / "my_model.py").write_text(text)
    quick = ("--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "--no-recordings")
    done = colias("run", "speed", *quick, "--model", "my_model.py", "--out", "out")
    assert done.returncode == 1, done.stderr
    assert "ValueError: odd" in done.stderr and "Traceback" not in done.stderr
    failures = json.loads((colias.folder / "out" / "failures.json").read_text())
    assert len(failures) == 4 and failures[0]["reason"] == "ValueError: odd"
