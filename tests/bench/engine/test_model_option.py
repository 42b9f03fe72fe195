"""``--model`` shows a model beside the command's own, ``--only`` just those of ``--model``: one meaning everywhere."""

import csv
import json
import pickle
import re
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

from dsnn import MODELS
from experiments.bench import registry
from experiments.bench.cli.entry import run as main
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import ask
from experiments.bench.engine.settings import watchers
from experiments.bench.robot.plan import plan
from tests.helpers import user_files

QUICK = ("--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--workers", "0", "--no-recordings", "-q")
SMALL = ("--set", "plain.rows=40", "--set", "plain.columns=60", "--set", "plain.width=9", "--set", "plain.height=20")
COMPARED = [name for name in MODELS if name != "dsnn-reference"]


def models_of(folder, table="trials.parquet"):
    return list(dict.fromkeys(pq.read_table(folder / table)["model"].to_pylist()))


def csv_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def ran(colias, *arguments):
    done = colias(*arguments)
    assert done.returncode == 0, done.stderr
    return done


@pytest.fixture
def told(tmp_path, monkeypatch, capfd):
    """What ``colias`` says in this process, where starting another for each wrong use would take long."""

    def run(*arguments):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setenv("COLUMNS", "100")
        monkeypatch.setattr(sys, "argv", ["colias", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        printed, errors = capfd.readouterr()
        return ended.value.code, printed, errors

    return run


@pytest.fixture
def refused(told, tmp_path):
    """The one line that a wrong use ends in; nothing is made."""

    def run(*arguments):
        there = sorted(tmp_path.iterdir())
        status, printed, errors = told(*arguments)
        assert (status, printed, errors.count("\n")) == (2, "", 1), errors
        assert sorted(path for path in tmp_path.iterdir() if path.name != "__pycache__") == there
        return errors

    return run


# --- one meaning, on every command ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        ((), ["dsnn"]),
        (("--model", "emd"), ["dsnn", "emd"]),
        (("--model", "emd", "--model", "dsnn", "--model", "emd"), ["dsnn", "emd"]),
        (("--only", "--model", "emd"), ["emd"]),
    ],
)
def test_a_run_with_the_robot(colias, given, shown):
    ran(colias, "run", "speed", *QUICK, *given, "--out", "out")
    assert models_of(colias.folder / "out") == shown


OWN = """
from experiments.bench.clips.experiment import Clip, OfflineExperiment

SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
EXPERIMENT = OfflineExperiment("mine", "a small crossing", (Clip("right", "plain", SMALL),), ("dsnn", "emd"), ("C2",))
"""


@pytest.mark.parametrize(
    ("given", "shown"),
    [
        (("--model", "lgmd1", "--model", "emd"), ["dsnn", "emd", "lgmd1"]),
        (("--only", "--model", "lgmd1"), ["lgmd1"]),
    ],
)
def test_an_off_line_run(colias, given, shown):
    (colias.folder / "mine.py").write_text(OWN)
    ran(colias, "run", "mine.py", "--workers", "0", "--no-recordings", *given, "--out", "out")
    assert models_of(colias.folder / "out") == shown
    (claim,) = json.loads((colias.folder / "out" / "claims.json").read_text())["claims"]
    assert (claim["outcome"]["verdict"] == "not shown") == ("dsnn" not in shown)


@pytest.mark.parametrize(
    ("given", "shown"), [(("--model", "emd"), ["dsnn", "emd"]), (("--only", "--model", "emd"), ["emd"])]
)
def test_a_stimulus_and_footage(colias, given, shown):
    clip = ran(colias, "play", "plain", *SMALL, "--no-view", "--record", "clip.rrd", *given)
    assert [line.split()[0] for line in clip.stdout.splitlines()[:-1]] == shown
    ran(colias, "stimulus", "plain", *SMALL, "--out", "clip.avi")
    ran(colias, "watch", "clip.avi", "--no-view", "--size", "60x40", "--table", "out.parquet", *given)
    assert models_of(colias.folder, "out.parquet") == shown


def test_tune_and_leaderboard_add_too(colias):
    """``tune --model`` used to show that model alone, ``leaderboard --model`` all beside it."""
    (colias.folder / "my_model.py").write_text(user_files.MODEL)
    common = ("--model", "my_model.py", "--model", "emd", "--out", "out", "--workers", "0")
    ran(colias, "tune", "--curve", "size", *common)
    assert models_of(colias.folder / "out") == [*COMPARED, "gradient"]
    models = json.loads((colias.folder / "out" / "experiment.json").read_text())["models"]
    assert [model["label"] for model in models] == [*COMPARED, "gradient"]
    ran(colias, "tune", "--curve", "size", "--only", "--model", "emd", "--out", "alone", "--workers", "0")
    assert models_of(colias.folder / "alone") == ["emd"]


def test_parameters(colias):
    keys = {line.partition("=")[0] for line in ran(colias, "parameters", "--model", "emd").stdout.splitlines()}
    assert {"dsnn.n_con", "emd.log", "camera.fps"} <= keys
    keys = {
        line.partition("=")[0] for line in ran(colias, "parameters", "--only", "--model", "emd").stdout.splitlines()
    }
    assert {"emd.log", "camera.fps"} <= keys and "dsnn.n_con" not in keys


COMMANDS = {
    "run": ("run", "speed"), "off-line": ("run", "clean"),
    "tune": ("tune",), "leaderboard": ("leaderboard",), "play": ("play", "plain", "--no-view", "--record", "a.rrd"),
    "reproduce": ("reproduce", "--quick"), "parameters": ("parameters",),
}  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS)
def test_only_without_a_model_is_refused_in_one_line(refused, command):
    message = refused(*COMMANDS[command], "--only")
    assert message == "colias: --only: shows just the models of --model; name them by --model\n"


@pytest.mark.parametrize("command", ["run", "tune", "leaderboard", "watch", "play", "reproduce", "parameters"])
def test_every_help_has_the_same_words(told, command):
    status, printed, _ = told(command, "--help")
    words = " ".join(re.sub(r"[^\w\s.,:;='-]", " ", printed).split())
    assert status == 0
    assert "Show this model beside the command's own: a name or a .py file" in words
    assert "Show just the models of --model, none of the command's own." in words
    assert re.search(r"command's own models?[,\w\s]* (is|are) (dsnn|those registered)", words), "and names them"


def test_a_report_needs_the_model_that_its_claims_are_about(refused):
    message = refused("reproduce", "--quick", "--only", "--model", "emd", "--out", "out")
    assert "the claims are about dsnn: give --model dsnn too" in message


# --- one model under several settings ---------------------------------------------------------------------------------


def test_one_model_under_two_settings_is_paired(colias):
    """In worker processes too, to which models go as what made them."""
    (colias.folder / "my_model.py").write_text(user_files.MODEL)
    given = ("--model", "dsnn:n_con=4,tau_s=200,10", "--model", "my_model.py:gain=1e-9")
    common = ("--set", "experiment.speeds_cm_s=20", "--set", "dsnn.n_con=6", "--repeats", "3", "--no-recordings")
    done = ran(colias, "run", "speed", *common, *given, "--workers", "1", "--out", "out")
    labels = ["dsnn", "dsnn:n_con=4,tau_s=200,10", "gradient:gain=1e-9"]
    assert models_of(colias.folder / "out") == labels
    there = json.loads((colias.folder / "out" / "experiment.json").read_text())
    networks = {model["label"]: model["network"] for model in there["settings"]["models"]}
    assert [networks[label]["n_con"] for label in labels[:2]] == [6, 4], "--set is the family's; what is its own wins"
    assert networks[labels[1]]["tau_s"] == [200.0, 10.0] and networks[labels[2]]["gain"] == 1e-9
    assert list(there["files"]) == [str(colias.folder / "my_model.py")]
    pairs = csv_of(colias.folder / "out" / "comparisons.csv")
    assert {(row["model"], row["against"], row["n"]) for row in pairs} == {
        (labels[0], labels[1], "3"), (labels[0], labels[2], "3"), (labels[1], labels[2], "3"),
    }  # fmt: skip
    rows = pq.read_table(colias.folder / "out" / "trials.parquet").to_pylist()
    peaks = {label: max(row["peak_hs"] for row in rows if row["model"] == label) for label in labels}
    assert len(set(peaks.values())) == 3 and peaks[labels[2]] < 1e-3
    assert labels[1] in " ".join(done.stdout.split()) and labels[1] in (colias.folder / "out/figure.svg").read_text()
    again = colias("run", "speed", *common, *given, "--workers", "0", "--out", "out")
    assert again.returncode == 0 and "3 of them done already" in again.stderr
    given = (*given[:2], "--model", "my_model.py:gain=1", "--workers", "0")
    other = colias("run", "speed", *common, *given, "--out", "out")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1), other.stderr


def test_settings_work_on_clips_footage_and_curves(colias):
    (colias.folder / "mine.py").write_text(OWN)
    given = ("--model", "dsnn:w_i=1", "--model", "emd:log=false")
    ran(colias, "run", "mine.py", *given, "--workers", "0", "--out", "run")
    assert models_of(colias.folder / "run") == ["dsnn", "emd", "dsnn:w_i=1", "emd:log=false"]
    ran(colias, "stimulus", "plain", *SMALL, "--out", "clip.avi")
    ran(colias, "watch", "clip.avi", "--no-view", "--size", "60x40", "--table", "out.csv", *given)
    assert {row["model"] for row in csv_of(colias.folder / "out.csv")} == {"dsnn", "dsnn:w_i=1", "emd:log=false"}
    ran(colias, "tune", "--curve", "size", "--only", *given, "--workers", "0", "--out", "tune")
    assert {row["model"] for row in csv_of(colias.folder / "tune/tuning.csv")} == {"dsnn:w_i=1", "emd:log=false"}
    drawing = (colias.folder / "tune" / "size.svg").read_text()
    assert "dsnn:w_i=1 (" in drawing and "emd:log=false (" in drawing


def test_models_without_a_colour_of_their_own_get_different_ones():
    from experiments.bench.figures.palette import colours

    given = colours(["dsnn", "dsnn:w_i=1", "mine", "dsnn:w_i=0", "emd"])
    assert len(set(given.values())) == 5 and given["dsnn"] == colours(["dsnn"])["dsnn"]


TEXTS = {
    "dsnn": ("dsnn", {}),
    "dsnn:w_i=1": ("dsnn", {"w_i": "1"}),
    "dsnn:tau_s=200,10,n_con=4": ("dsnn", {"tau_s": "200,10", "n_con": "4"}),
    "my_model.py:gain=2": ("my_model.py", {"gain": "2"}),
    "a:b/my.model.py": ("a:b/my.model.py", {}),
    "a:b/my.py:gain=2,t_sp=0.1": ("a:b/my.py", {"gain": "2", "t_sp": "0.1"}),
    "C:\\models\\my.py:gain=2": ("C:\\models\\my.py", {"gain": "2"}),
    "m.py:table=other.py": ("m.py", {"table": "other.py"}),
}


@pytest.mark.parametrize("text", TEXTS)
def test_a_text_is_taken_apart(text):
    asked = ask(text)
    assert (asked.source, dict(asked.values)) == TEXTS[text]


def test_a_path_with_colons_is_found(colias):
    (colias.folder / "at 12:30").mkdir()
    (colias.folder / "at 12:30" / "my_model.py").write_text(user_files.MODEL)
    path = "at 12:30/my_model.py"
    ran(colias, "run", "speed", *QUICK, "--only", "--model", path, "--model", f"{path}:gain=1", "--out", "out")
    assert models_of(colias.folder / "out") == ["gradient", "gradient:gain=1"]


WRONG = {
    "dsnn:": "--model dsnn:: expected NAME:PARAM=VALUE",
    "dsnn:w_i": "--model dsnn:w_i: expected NAME:PARAM=VALUE",
    "dsnn:w_i=": "--model dsnn:w_i=: expected NAME:PARAM=VALUE",
    "dsnn:w_i=1,w_i=0": "w_i is there twice",
    "dsnn:w_j=1": "dsnn has no parameter 'w_j' (nearest: w_i; all: colias parameters --only --model dsnn)",
    "dsnn:w_i=2": "--model dsnn:w_i=2: w_i=2: legal is a number from 0 to 1",
    "dsnn:n_con=4,w_i=x": "w_i=x: legal is a number from 0 to 1",
    "dsnn:tau_s=10": "tau_s=10: legal is 2 values",
    "dsn:w_i=1": "unknown model 'dsn'",
    "nowhere.py:gain=1": "nowhere.py: no such file",
    "even.py:gain=3": "--model even.py:gain=3: gain=3: an even number is needed",
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_settings_end_in_one_line(refused, tmp_path, text):
    checked = "    t_sp: float = 0.2\n\n    def __post_init__(self):\n        if self.gain % 2:\n            "
    checked += "raise ValueError('an even number is needed')\n"
    even = user_files.MODEL.replace("    t_sp: float = 0.2  # threshold on the potential\n", checked)
    (tmp_path / "even.py").write_text(even.replace("gain: float = 0.05", "gain: float = 2.0"))
    assert WRONG[text] in refused("run", "speed", *QUICK, "--model", text, "--out", "out")


def test_two_models_of_one_name_are_refused(refused, tmp_path):
    for name, doc in (("one.py", "a"), ("two.py", "b")):
        (tmp_path / name).write_text(f'"""{doc}"""\n' + user_files.MODEL)
    message = refused("run", "speed", *QUICK, "--model", "one.py", "--model", "two.py")
    assert "--model two.py: another model shown is called gradient too" in message
    (tmp_path / "three.py").write_text(user_files.MODEL.replace('"gradient"', '"dsnn"'))
    message = refused("run", "speed", *QUICK, "--model", "three.py")
    assert "--model three.py: another model shown is called dsnn too" in message


def test_a_label_with_signs_of_the_printers_is_printed_and_drawn_as_it_is(colias):
    """Brackets are mark-up on the terminal, two dollars a formula in a figure."""
    text = user_files.MODEL.replace("    gain: float = 0.05\n", '    gain: float = 0.05\n    note: str = ""\n')
    (colias.folder / "my_model.py").write_text(text)
    label = "gradient:note=[/b]$a$"
    (colias.folder / "mine.py").write_text(OWN)
    for name, command in (("robot", ("run", "general", "--repeats", "1")), ("clips", ("run", "mine.py"))):
        given = ("--model", "my_model.py:note=[/b]$a$", "--workers", "0", "--no-recordings")
        done = ran(colias, *command, *given, "--out", name)
        assert label in done.stdout, done.stdout
        assert label in (colias.folder / name / "figure.svg").read_text()


def test_a_model_with_settings_travels(tmp_path):
    path = tmp_path / "my_model.py"
    path.write_text(user_files.MODEL)
    trial_plan = plan(registry.load("speed"), ["dsnn", "dsnn:w_i=1", f"{path}:gain=2"], ["dsnn.n_con=4"], 1, 0)
    there = pickle.loads(pickle.dumps(trial_plan.settings.models))
    assert there == trial_plan.settings.models
    assert [model.label for model in there] == ["dsnn", "dsnn:w_i=1", "gradient:gain=2"]
    assert Path(there[2].source) == path and there[1].network.w_i == 1.0 and there[0].network.w_i == 0.9
    assert there[1].network.n_con == 4, "what --set says of the family"


def test_off_line_models_keep_their_preset_under_settings():
    plain, changed = watchers(["dsnn", "dsnn:w_i=1"], [], fps=25.0)[0]
    assert (changed.network.t_sp, changed.network.fps, changed.network.w_i) == (plain.network.t_sp, 25.0, 1.0)
    assert watchers(["dsnn:fps=60"], [], fps=25.0)[0][0].network.fps == 60.0
    with pytest.raises(UsageError, match=r"--set dsnn\.n_con=99"):
        watchers(["dsnn:n_con=4"], ["dsnn.n_con=99"])


# --- grids ------------------------------------------------------------------------------------------------------------

GRID = ("map", "speed", "--measure", "spikes", "--set", "experiment.speeds_cm_s=20,30", "--repeats", "1",
        "--workers", "0")  # fmt: skip


def test_a_grid_shows_several_models(colias):
    """A model that a point does not move is shown once in each rendering, and counts at every point."""
    given = ("--over", "dsnn.n_con=4,6", "--over", "camera.read_noise=0,0.64")
    ran(colias, *GRID, *given, "--model", "dsnn", "--model", "emd", "--model", "lgmd1", "--out", "out")
    rows = [row for row in csv_of(colias.folder / "out" / "counts.csv") if row["speed_cm_s"] == "20"]
    points = [(row["model"], row["dsnn.n_con"], row["camera.read_noise"]) for row in rows]
    assert sorted(points) == sorted(
        (model, n, noise) for model in ("dsnn", "emd", "lgmd1") for n in ("4", "6") for noise in ("0", "0.64")
    )
    trials = pq.read_table(colias.folder / "out" / "trials.parquet")
    assert trials.num_rows == 2 * 2 * 4, "once per rendering, not once per point"
    ran(colias, "run", "speed", *GRID[4:], "--set", "dsnn.n_con=4", "--no-recordings", "--out", "alone")
    spikes = {r["speed_cm_s"]: r["spikes"] for r in pq.read_table(colias.folder / "alone/trials.parquet").to_pylist()}
    same = {float(r["speed_cm_s"]): float(r["value"]) for r in csv_of(colias.folder / "out" / "counts.csv")
            if (r["model"], r["dsnn.n_con"], r["camera.read_noise"]) == ("dsnn", "4", "0.64")}  # fmt: skip
    assert same == spikes


def test_what_a_model_has_settled_itself_no_point_varies(colias):
    ran(colias, *GRID, "--over", "dsnn.n_con=4,6", "--model", "dsnn", "--model", "dsnn:n_con=5", "--out", "out")
    models = json.loads((colias.folder / "out/experiment.json").read_text())["models"]
    assert sorted(model["network"]["n_con"] for model in models) == [4, 5, 6]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--over", "dsnn.n_con=4", "--model", "emd"), "no model shown has 'dsnn.n_con': add --model dsnn"),
        (("--over", "dsnn.n_con=4", "--model", "dsnn:n_con=5"), "--model dsnn:n_con=5 has settled that"),
        (("--over", "dsnn.n_con=99"), "--over dsnn.n_con=99: legal is a whole number from 1 to 64"),
        (("--over", "camera.read_noise=0,99"), "--over camera.read_noise=99: legal is a number from 0 to 64"),
    ],
)
def test_a_wrong_grid_ends_in_one_line(refused, arguments, says):
    assert says in refused(*GRID, *arguments, "--out", "out")
