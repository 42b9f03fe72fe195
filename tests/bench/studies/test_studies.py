"""The studies that ship: what is varied and nothing else, the reproduction's own seeds, and how they are run."""

import csv
import dataclasses
import json

import polars as pl
import pytest

from colias_sim.config import CameraConfig, RobotConfig
from experiments.bench import reproduce
from experiments.bench.cli import main
from experiments.bench.run.errors import UsageError
from experiments.bench.sources.clip_claims import paper_claims
from experiments.bench.studies import figure, registry, run
from experiments.bench.studies.counts import Counts
from experiments.bench.studies.plan import EVERY_MODEL
from experiments.bench.studies.replicates import replicate
from experiments.bench.studies.stored import studies
from experiments.studies.fidelity import EYE
from experiments.studies.sensitivity import APPARATUS, DEFAULTS, NETWORK, READINGS
from tests.bench.stats.test_replicates import rows_of
from tests.helpers.paper import design

APPARATUS_OF = {"camera": CameraConfig(), "robot": RobotConfig()}


def planned(name, seed=0, **changes):
    return run.planned(dataclasses.replace(registry.find(name), **changes), seed)


def trials(plan, point, model="dsnn", judged=None):
    """The trials of a point before one model, each with that model's network. ``judged``: whose, if another's."""
    specs = {spec.index: spec for spec in plan.specs}
    seen = []
    for name in plan.experiments:
        share = plan.shares[point, model if judged is None else judged, name, 0]
        (watcher,) = (watcher for watcher in share.watchers if watcher.name == model)
        for number in share.trials:
            (network,) = (m.network for m in specs[number].settings.models if m.label == watcher.label)
            settings = dataclasses.replace(specs[number].settings, models=())
            seen.append((dataclasses.replace(specs[number], index=0, settings=settings), network))
    return seen


def bare(pairs):
    """A trial without what fidelity may change."""
    return [(dataclasses.replace(spec, settings=dataclasses.replace(spec.settings, **APPARATUS_OF)), network)
            for spec, network in pairs]  # fmt: skip


def test_fidelity_changes_eye_and_wheels_alone():
    plan = planned("fidelity", 3, replicates=1, repeats=2)
    first, *others = plan.points
    for point in others:
        assert bare(trials(plan, point, judged=EVERY_MODEL)) == trials(plan, first, judged=EVERY_MODEL)
    assert {(spec.settings.camera, spec.settings.robot) for spec in plan.specs} == {
        (camera, robot)
        for camera in (CameraConfig(), CameraConfig.preset("ov7670"))
        for robot in (RobotConfig(), RobotConfig.preset("colias4"))
    }


def test_the_range_of_eyes_has_the_fixed_ones_and_moves_what_is_not_known():
    """The eyes ``default`` and ``ov7670`` are there to the last setting; no other than what the study names moves."""
    plan = planned("eye-range", 3, replicates=1, repeats=1)
    cameras = {}
    for point in plan.points:
        (settings,) = {(spec.settings.camera, spec.settings.scene.light) for spec, _ in trials(plan, point)}
        cameras[tuple(label for _, label in point.values)] = settings
    fixed = {"default": CameraConfig(), "ov7670": CameraConfig.preset("ov7670")}
    for name, camera in fixed.items():
        assert cameras["1", "108", name] == (camera, 1.0)
    assert {target: cameras["0.1", target, "default"] for target in ("60", "150")} == {
        target: (fixed["default"], 0.1) for target in ("60", "150")
    }, "it has no target"
    unknown = {"ae_target", "exposure_samples", "row_bands", "gamma", "gamma_points", "ae_meter", "vignetting"}
    for (light, target, eye), (camera, strength) in cameras.items():
        if eye != "default":
            base = fixed["ov7670"]
            moved = {f.name for f in dataclasses.fields(base) if getattr(camera, f.name) != getattr(base, f.name)}
            assert moved <= unknown and (camera.ae_target, strength) == (float(target), float(light))
    assert len(set(cameras.values())) == len(cameras) - 4, "the default's three targets are one"


def test_many_points_with_names_make_a_map_for_each_claim():
    counts = Counts(planned("eye-range", replicates=1, repeats=1))
    drawn = figure.draw(counts)
    titles = [axes.get_title(loc="left") for axes in drawn.axes if axes.axison]
    assert [title.partition(":")[0] for title in titles if title] == [f"C{number}" for number in range(13, 21)]
    axes = drawn.axes[0]
    assert [label.get_text() for label in axes.get_yticklabels()] == [*reversed(counts.plan.axes[-1].labels)]
    assert len(axes.texts) == len(counts.plan.points) == 36
    few = figure.draw(Counts(planned("fidelity", replicates=1, repeats=1)))
    assert len([axes for axes in few.axes if axes.get_title("left")]) == 1, "few are rows"


def test_the_first_point_is_the_reproduction_s_own_replicate():
    plan = planned("fidelity", 3, replicates=1, repeats=2)
    replicate_specs = {(s.experiment, s.seed): s for s in design(1, 2, 3).specs}
    for spec, network in trials(plan, plan.points[0], judged=EVERY_MODEL):
        ours = replicate_specs[spec.experiment, spec.seed]
        assert spec.condition == ours.condition and network == ours.settings.models[0].network
        assert dataclasses.replace(ours.settings, models=()) == spec.settings


def test_moves_change_what_they_name_and_nothing_else():
    """Each point of the study of sensitivity differs from the defaults in its own parameter, and in no seed."""
    plan = planned("sensitivity", repeats=1)
    by_label = {point.values[0][1]: point for point in plan.points}
    assert list(by_label) == [DEFAULTS, *NETWORK, *READINGS, *APPARATUS]
    for model in ("dsnn", "dsnn-onboard"):
        defaults = trials(plan, by_label[DEFAULTS], model)
        for label, text in (NETWORK if model == "dsnn-onboard" else NETWORK | READINGS).items():
            for (spec, network), (plain, base) in zip(trials(plan, by_label[label], model), defaults, strict=True):
                changed = {
                    f.name for f in dataclasses.fields(base) if getattr(network, f.name) != getattr(base, f.name)
                }
                assert spec == plain and changed == {text.partition("=")[0]}
    defaults = trials(plan, by_label[DEFAULTS])
    for name, settings in APPARATUS.items():
        moved = trials(plan, by_label[name])
        assert [(s.experiment, s.seed, n) for s, n in moved] == [(s.experiment, s.seed, n) for s, n in defaults]
        if not settings[0].startswith("experiment."):
            assert all(s.settings != plain.settings for (s, _), (plain, _) in zip(moved, defaults, strict=True))
    alone = {point.values[0][1] for point, model in plan.judged} - {
        point.values[0][1] for point, model in plan.judged if model == "dsnn-onboard"
    }
    assert alone == {*READINGS, *APPARATUS}


def test_moves_of_clips_are_those_of_the_network_and_leave_its_rivals():
    """All points share their clips; a model that none of them moves is shown a clip once."""
    plan = planned("sensitivity-clips")
    labels = [point.values[0][1] for point in plan.points]
    assert set(labels) == {DEFAULTS, "T_sp = 0.2", *NETWORK, *READINGS} - {"K_sp = 2", "K_sp = 3", "T_sp = 0.16"}
    assert set(plan.study.claims) == set(paper_claims())
    for spec in plan.specs:
        networks = {model.label: model.network for model in spec.models}
        for name in {label.removesuffix(DEFAULTS) for label in networks if label.endswith(DEFAULTS)}:
            assert {f"{name}{label}" for label in labels} <= networks.keys()
        assert not any(label.startswith(("dsn2017 ", "emd ")) for label in networks)
        base = networks[DEFAULTS]
        for label in set(labels) & {*NETWORK, *READINGS}:
            fields = dataclasses.fields(base)
            changed = {f.name for f in fields if getattr(networks[label], f.name) != getattr(base, f.name)}
            assert changed == {(NETWORK | READINGS)[label].partition("=")[0]}


def test_with_nothing_moved_each_claim_comes_to_what_it_does_in_replicate_0():
    """The first row of the table of sensitivity, of trials whose answers differ with their seeds."""
    plans = reproduce.planned(dataclasses.replace(reproduce.USUAL, repeats=5), 3, robot_only=True)

    def answered(specs):
        rows = zip(rows_of(specs), (spec for spec in specs for _ in spec.settings.models), strict=True)
        return [{**row, "spikes": row["spikes"] * (spec.seed % 7), "peak_hs": spec.seed % 5 / 20} for row, spec in rows]

    specs = [spec for run_plan in plans.paper() for spec in run_plan.specs()]
    first = replicate(specs, [row for run_plan in plans.paper() for row in answered(run_plan.specs())])
    counts = Counts(plans.studies["sensitivity"], answered(plans.studies["sensitivity"].specs))
    for cell in counts.cells[: len(plans.studies["sensitivity"].claims)]:
        assert (dict(cell.point.values), cell.model) == ({"moved": DEFAULTS}, "dsnn")
        assert cell.outcomes == (reproduce.judge(cell.claim, first),)


def test_what_is_not_moved_somewhere_is_run_once():
    plan = planned("sensitivity", repeats=1)
    sudden = next(point for point in plan.points if point.values[0][1].startswith("sudden"))
    both = (sudden, plan.points[0])
    shared = [plan.shares[point, "dsnn", name, 0].trials for point in both for name in ("speed", "distance")]
    assert shared[:2] == shared[2:], "their designs have no start acceleration"


def test_a_study_without_its_trials_is_judged_nowhere():
    counts = Counts(planned("fidelity", replicates=1, repeats=1))
    assert {cell.outcomes[0].verdict for cell in counts.cells} == {"not shown"}


def test_a_study_without_models_judges_each_claim_on_those_that_it_is_about():
    """C21 is about looming detectors, C24 compares networks: a study of the DSNN alone refuses both."""
    plan = planned("fidelity", replicates=1, repeats=5, claims=("C14", "C21", "C24"), axes=(EYE,))
    cells = Counts(plan, rows_of(plan.specs)).cells
    assert {cell.outcomes[0].verdict for cell in cells} <= {"holds", "fails"} and len(cells) == 3 * len(plan.points)
    looming = next(cell for cell in cells if cell.claim == "C21")
    assert all(model in looming.outcomes[0].measured for model in ("lgmd1", "lgmd2"))
    with pytest.raises(UsageError, match="C21: it is about models that answer by looming"):
        planned("fidelity", claims=("C21",), models=("dsnn",))


OWN = """
from experiments import Axis, Level, Study

LIGHT = Axis("light", (Level("as it is"), Level("dim", ("scene.light=0.7",))))
STUDY = Study("light", "C16 in less light", claims=("C16",), axes=(LIGHT,), repeats=5, replicates=2)
"""


def test_a_user_s_own_study_is_run_counted_and_gone_on_with(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "light.py").write_text(OWN)
    arguments = ["study", "light.py", "--replicates", "1", "--workers", "0", "-q", "--out", "out"]
    assert main.command(arguments) == 0
    with (tmp_path / "out" / "counts.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert [(row["light"], row["claim"], row["experiment"]) for row in rows] == [
        ("as it is", "C16", "distance"), ("dim", "C16", "distance"),
    ]  # fmt: skip
    assert all(int(row["holds"]) + int(row["fails"]) == 1 == int(row["replicates"]) for row in rows)
    before = (tmp_path / "out" / "counts.csv").read_bytes()
    assert main.command(arguments) == 0
    assert (tmp_path / "out" / "counts.csv").read_bytes() == before
    assert list(studies(tmp_path)) == ["light"], "the report of a reproduction there shows it"


def stored(folder):
    """What a study's folder says of its numbers, its table, its trials, and how long each of these took."""

    note = json.loads((folder / "run.json").read_text())
    trials = pl.read_parquet(folder / "trials.parquet").to_dicts()
    took = [row.pop("wall_s") for row in trials]
    return (note["replicates"], note["trials"], (folder / "counts.csv").read_bytes(), trials), took


def test_a_study_goes_on_to_more_replicates_and_not_to_fewer(tmp_path, monkeypatch):
    """It comes to what the larger number comes to at once, and its first replicates are not run again."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "light.py").write_text(OWN)
    whole = ["study", "light.py", "--repeats", "1", "--workers", "0", "-q"]
    assert main.command([*whole, "--replicates", "1", "--out", "out"]) == 0
    (replicates, trials, *_), took = stored(tmp_path / "out")
    assert main.command([*whole, "--replicates", "2", "--out", "out"]) == 0
    assert main.command([*whole, "--replicates", "2", "--out", "at-once"]) == 0
    longer, took_longer = stored(tmp_path / "out")
    assert longer == stored(tmp_path / "at-once")[0] and longer[:2] == (2 * replicates, 2 * trials)
    assert took_longer[:trials] == took, "as they were"
    with pytest.raises(UsageError, match="--replicates is 2 there and 1 now"):
        main.command([*whole, "--replicates", "1", "--out", "out"])


def breaks(spec, keep=None):
    """In place of a trial."""
    raise ValueError("odd")


def test_a_study_whose_trials_failed_says_so_by_its_status(tmp_path, monkeypatch, capsys):
    """Its counts are written all the same."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "light.py").write_text(OWN)
    arguments = ["study", "light.py", "--replicates", "1", "--repeats", "1", "--workers", "0", "-q", "--out", "out"]

    with monkeypatch.context() as patched:
        patched.setattr(run.robot_run, "work", breaks)
        assert main.command(arguments) == 1
    assert "ValueError: odd" in capsys.readouterr().err
    with (tmp_path / "out" / "counts.csv").open() as file:
        assert [row["not shown"] for row in csv.DictReader(file)] == ["1", "1"]
    assert json.loads((tmp_path / "out" / "light.json").read_text())["failures"]


@pytest.mark.parametrize(
    ("words", "replicates", "repeats"),
    [
        (["fidelity"], 20, 10),
        (["fidelity", "--quick"], 2, 5),
        (["eye-range", "--quick"], 1, 5),
        (["sensitivity", "--quick"], 1, 5),
        (["constants-emd", "--quick"], 1, None),
        (["fidelity", "--quick", "--replicates", "3"], 3, 5),
        (["fidelity", "--quick", "--repeats", "7"], 2, 7),
    ],
)
def test_quick_is_two_short_replicates_at_most(words, replicates, repeats, tmp_path, monkeypatch):
    """And a number that is given counts."""
    asked = []

    def counted(plan, folder, resources):
        asked.append((plan.replicates, plan.study.repeats))
        return Counts(plan)

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(run, "run", counted)
    assert main.command(["study", *words, "-q", "--workers", "0"]) == 0
    assert asked == [(replicates, repeats)]


def test_spikes_over_a_grid_are_those_of_runs_alone(tmp_path, monkeypatch):

    monkeypatch.chdir(tmp_path)
    quick = ["--set", "experiment.speeds_cm_s=20,30", "--repeats", "2", "-q", "--workers", "0"]
    over = ["--over", "dsnn.n_con=4,8", "--over", "camera.read_noise=0,0.64"]
    assert main.command(["map", "speed", *quick, *over, "--measure", "spikes", "--out", "out"]) == 0
    with (tmp_path / "out" / "counts.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len({(r["dsnn.n_con"], r["camera.read_noise"], r["speed_cm_s"]) for r in rows}) == 8
    alone = ["run", "speed", *quick, "--set", "dsnn.n_con=4", "--no-recordings", "--out", "alone"]
    assert main.command(alone) == 0
    spikes = [row["spikes"] for row in pl.read_parquet(tmp_path / "alone" / "trials.parquet").to_dicts()
              if row["speed_cm_s"] == 20.0]  # fmt: skip
    (point,) = [
        r
        for r in rows
        if [float(r[name]) for name in ("dsnn.n_con", "camera.read_noise", "speed_cm_s")] == [4, 0.64, 20]
    ]
    assert (float(point["value"]), int(point["n"])) == (sum(spikes) / 2, 2)
