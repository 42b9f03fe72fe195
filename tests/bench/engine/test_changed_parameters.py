"""Parameters that are not at their defaults are columns of trials.parquet, and refused where they are altered."""

import json
from dataclasses import dataclass

import polars as pl

import experiments
from experiments.bench import registry
from experiments.bench.offline import plan as clips_plan
from experiments.bench.run.parameters import in_words, of_model, with_columns
from experiments.bench.sources.rows import TRIAL_SCHEMA
from experiments.bench.trials import describe, plan

SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
CLIPS = experiments.OfflineExperiment("small", "small", (experiments.Clip("right", "plain", SMALL),), ("dsnn", "emd"))


def planned(models=("dsnn",), *assignments):
    return plan(registry.load("speed"), models, assignments, 1, 0)


def test_by_default_nothing_is_changed():
    usual = planned(("dsnn", "emd", "lgmd1"))
    assert usual.changed() == {} and "changed" not in describe(usual)
    assert with_columns(TRIAL_SCHEMA, usual.changed()) == TRIAL_SCHEMA
    assert clips_plan(CLIPS, CLIPS.models, (), 1, 0).changed() == {}
    assert planned(("dsnn",), "dsnn.n_con=8", "experiment.distances_cm=8").changed() == {}, "typed, but the same"


def test_by_set_and_by_model():
    trial_plan = planned(("dsnn", "dsnn:n_con=6", "emd"), "dsnn.tau_s=200,10", "camera.read_noise=0.25",
                         "scene.light=0.7", "experiment.direction=both")  # fmt: skip
    changed = trial_plan.changed()
    assert changed == {
        "dsnn.tau_s": {"dsnn": "200,10", "dsnn:n_con=6": "200,10", "emd": None},
        "dsnn.n_con": {"dsnn": 8, "dsnn:n_con=6": 6, "emd": None},
        "camera.read_noise": {"dsnn": 0.25, "dsnn:n_con=6": 0.25, "emd": 0.25},
        "scene.light": {"dsnn": 0.7, "dsnn:n_con=6": 0.7, "emd": 0.7},
        "experiment.direction": {"dsnn": "both", "dsnn:n_con=6": "both", "emd": "both"},
    }
    assert describe(trial_plan)["changed"] == changed
    schema = with_columns(TRIAL_SCHEMA, changed)
    assert schema.names()[: len(TRIAL_SCHEMA)] == TRIAL_SCHEMA.names()
    assert [schema[name] for name in ("dsnn.tau_s", "dsnn.n_con", "camera.read_noise")] == [
        pl.String,
        pl.Int64,
        pl.Float64,
    ]
    assert of_model(changed, "emd")["dsnn.n_con"] is None
    assert in_words(changed).startswith("dsnn.tau_s=200,10, dsnn.n_con=8|6, camera.read_noise=0.25")


@dataclass(frozen=True)
class Mixed:
    """Values of several kinds in one design."""

    way: bool = False
    speed: float = 30
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0

    def conditions(self):
        """One crossing."""
        return [experiments.Condition("translation", "leftward" if self.way else "rightward", self.speed, 8.0)]


def test_a_design_of_ones_own():
    experiment = experiments.Experiment("mine", "mine", Mixed(), "speed_cm_s")
    changed = plan(experiment, ["dsnn"], ["experiment.way=true", "experiment.speed=25"], 1, 0).changed()
    assert changed == {"experiment.way": {"dsnn": True}, "experiment.speed": {"dsnn": 25.0}}
    assert with_columns(TRIAL_SCHEMA, changed)["experiment.way"] == pl.Boolean


def clips(folder):
    return experiments.run(CLIPS, models="dsnn:n_con=6", settings={"dsnn.w_i": 0.5}, out=folder,
                           workers=0, recordings=False, quiet=True)  # fmt: skip


def test_rows_have_columns_for_them(tmp_path):
    run = clips(tmp_path / "out")
    columns = ["model", "dsnn.w_i", "dsnn.n_con"]
    rows = run.trials.select(columns).rows()
    usual = json.loads((tmp_path / "out" / "run.json").read_text())["models"][0]["network"]["n_con"]
    assert rows == [("dsnn", 0.5, usual), ("emd", None, None), ("dsnn:n_con=6", 0.5, 6)]
    assert clips(tmp_path / "out").trials.equals(run.trials)


def test_the_points_of_a_grid(colias):
    quick = ("--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--workers", "0", "-q", "--measure", "spikes")
    models = ("--model", "dsnn", "--model", "emd")
    done = colias("sweep", "speed", *quick, "--over", "dsnn.n_con=4,8", *models, "--out", "out")
    assert done.returncode == 0, done.stderr
    rows = pl.read_parquet(colias.folder / "out" / "trials.parquet").to_dicts()
    assert [(row["model"], row["dsnn.n_con"]) for row in rows] == [
        ("dsnn.n_con=4", 4), ("dsnn.n_con=8", 8), ("emd", None),
    ]  # fmt: skip
