"""``--model`` shows a model beside the command's own, ``--only`` just those of ``--model``: one meaning everywhere."""

import json

import polars as pl
import pytest

from experiments.base.errors import UsageError
from experiments.settings.models import choose, parse_model, rate_notes, shown_models
from experiments.settings.settings import watchers
from tests.helpers import user_files


def ran(colias, *arguments):
    done = colias(*arguments)
    assert done.returncode == 0, done.stderr
    return done


# --- one meaning, on every command ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("given", "only", "shown"),
    [
        (None, False, ["dsnn"]),
        (["emd"], False, ["dsnn", "emd"]),
        (["emd", "dsnn", "emd"], False, ["dsnn", "emd"]),
        (["emd"], True, ["emd"]),
    ],
)
def test_each_model_is_shown_once(given, only, shown):
    assert shown_models(["dsnn"], given, only) == shown


def test_a_model_s_frame_rate_is_held_against_what_it_is_shown():
    """29.97 frames/s are 30."""
    dsnn, emd, flow = (choose(name) for name in ("dsnn", "emd", "flow"))
    assert rate_notes([(dsnn, 30.0), (emd, 29.97), (flow, 60.0)]) == []
    assert rate_notes([(dsnn, 60.0), (emd, 60.0)]) == [
        f"{model} assumes 30 frames/s and receives 60" for model in ("dsnn", "emd")
    ]


# --- one model under several settings ---------------------------------------------------------------------------------


def test_one_model_is_shown_under_two_settings(colias):
    """In worker processes too, to which models go as what made them."""
    (colias.folder / "my_model.py").write_text(user_files.MODEL)
    given = ("--model", "dsnn:n_con=4,tau_s=200,10", "--model", "my_model.py:gain=1e-9")
    common = ("--set", "experiment.speeds_cm_s=20", "--set", "dsnn.n_con=6", "--repeats", "3", "--no-recordings")
    ran(colias, "run", "speed", *common, *given, "--workers", "1", "--out", "out")
    labels = ["dsnn", "dsnn:n_con=4,tau_s=200,10", "gradient:gain=1e-9"]
    there = json.loads((colias.folder / "out" / "run.json").read_text())
    networks = {model["label"]: model["network"] for model in there["settings"]["models"]}
    assert [networks[label]["n_con"] for label in labels[:2]] == [6, 4], "--set is the family's; what is its own wins"
    assert networks[labels[1]]["tau_s"] == [200.0, 10.0] and networks[labels[2]]["gain"] == 1e-9
    assert list(there["files"]) == [str(colias.folder / "my_model.py")]
    rows = pl.read_parquet(colias.folder / "out" / "trials.parquet").to_dicts()
    assert list(dict.fromkeys(row["model"] for row in rows)) == labels
    peaks = {label: max(row["peak_hs"] for row in rows if row["model"] == label) for label in labels}
    assert len(set(peaks.values())) == 3 and peaks[labels[2]] < 1e-3
    given = (*given[:2], "--model", "my_model.py:gain=1", "--workers", "0")
    other = colias("run", "speed", *common, *given, "--out", "out")
    assert (other.returncode, other.stderr.count("\n")) == (2, 1), other.stderr


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
    assert parse_model(text) == TEXTS[text]


def test_off_line_models_keep_their_preset_under_settings():
    plain, changed = watchers(["dsnn", "dsnn:w_i=1"], fps=25.0)
    assert (changed.network.t_sp, changed.network.fps, changed.network.w_i) == (plain.network.t_sp, 25.0, 1.0)
    assert watchers(["dsnn:fps=60"], fps=25.0)[0].network.fps == 60.0
    with pytest.raises(UsageError, match=r"--set dsnn\.n_con=99"):
        watchers(["dsnn:n_con=4"], {"dsnn.n_con": "99"})


# --- grids ------------------------------------------------------------------------------------------------------------

GRID = ("sweep", "speed", "--measure", "spikes", "--set", "experiment.speeds_cm_s=20,30", "--repeats", "1",
        "--workers", "0")  # fmt: skip


def test_a_grid_shows_several_models(colias):
    """A model that a point does not move is shown once in each rendering, and counts at every point."""
    given = ("--over", "dsnn.n_con=4,6", "--over", "camera.read_noise=0,0.64")
    ran(colias, *GRID, *given, "--model", "dsnn", "--model", "emd", "--model", "lgmd1", "--out", "out")
    rows = pl.read_csv(colias.folder / "out" / "counts.csv").filter(speed_cm_s=20).to_dicts()
    points = [(row["model"], float(row["dsnn.n_con"]), float(row["camera.read_noise"])) for row in rows]
    assert sorted(points) == sorted(
        (model, n, noise) for model in ("dsnn", "emd", "lgmd1") for n in (4, 6) for noise in (0, 0.64)
    )
    trials = pl.read_parquet(colias.folder / "out" / "trials.parquet")
    assert trials.height == 2 * 2 * 4, "once per rendering, not once per point"
