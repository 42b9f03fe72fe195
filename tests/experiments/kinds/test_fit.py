"""Fits: what is planted is found, luck is exposed, a fit resumes; and the box."""

import json

import numpy as np
import polars as pl
import pytest

import experiments
from experiments.base.errors import UsageError
from experiments.cli import main
from experiments.declare.outcome import Check, Outcome
from experiments.declare.study import Fit, Study
from experiments.draw import fit as report
from experiments.judge.sweep import MOST_SLACK, slack
from experiments.judge.tests import proportion_interval
from experiments.kinds import sweep
from experiments.kinds.fit import RESULTS, at, box_of, plan, scored, spread, study_of
from experiments.store.asked import Asked

pytest.importorskip("optuna")

PLANTED = '''
"""A model whose answer is set by its parameters alone, or by chance, and what is claimed of it."""
import hashlib
from dataclasses import dataclass

import dsnn
from experiments import Check, Claim, Clip, OfflineExperiment

SMALL = {"rows": 16, "columns": 24, "speed": 60.0, "count": 9, "duration_s": 0.2}


@dataclass(frozen=True)
class Parameters:
    a: float = 0.5
    b: float = 0.5
    t_sp: float = 0.2


class Planted:
    def __init__(self, shape, parameters):
        self.p = parameters
        self.reset()

    def reset(self):
        self.chance = None

    def step(self, frame):
        if self.chance is None:
            text = frame.tobytes() + repr((self.p.a, self.p.b)).encode()
            self.chance = int(hashlib.sha256(text).hexdigest()[:8], 16) / 2**32
        hill = 1.0 - (self.p.a - 0.7) ** 2 - (self.p.b - 0.2) ** 2
        return dsnn.Response(hs=hill, vs=self.chance)


def claim(name, column, bound, side="at least"):
    def judge(clips, threshold):
        reading = clips[0][column]
        return [Check(f"{column} {reading:.3f}", reading, bound, side)]
    return Claim(on="clips", id=name, says=name, judge=judge, models={"planted"})


MODEL = dsnn.ModelEntry("planted", "planted", Planted, Parameters())
EXPERIMENT = OfflineExperiment(
    "planted", "planted", [Clip("dots", "dots", SMALL)], models=("planted.py",),
    claims=(claim("hill", "peak_hs", 0.99), claim("valley", "peak_hs", 0.9, "below"), claim("luck", "peak_vs", 0.9)),
)
'''
A, B = ("--over", "planted.a=0..1"), ("--over", "planted.b=0..1")
SPEED = ("--over", "dots.speed=30..90")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("fit")
    (place / "planted.py").write_text(PLANTED)
    return place


def fit(folder, out, claims, *more, status=0):
    file = str(folder / "planted.py")
    chosen = ["--model", file, "--claims", claims, *more, "--out", str(folder / out)]
    assert main.command(["fit", file, *chosen, "--workers", "0", "-q"]) == status
    return json.loads((folder / out / "fit.json").read_text())


def table(folder, out, name="fit.csv"):
    return pl.read_csv(folder / out / name, infer_schema=False).to_dicts()


def test_a_planted_optimum_is_found(folder):
    outcome = fit(folder, "hill", "hill", *A, *B, "--trials", "60", "--sample", "32")
    assert outcome["word"] == "fitted" and outcome["luck"] == pytest.approx(0.0)
    assert abs(float(outcome["winner"]["planted.a"]) - 0.7) < 0.1
    assert abs(float(outcome["winner"]["planted.b"]) - 0.2) < 0.1
    # The claim is kept within 0.1 of the hill's top: a disc of 3.1 % of the box.
    share = outcome["share"]
    assert share["low"] <= 3.1415926 * 0.1**2 <= share["high"]
    parts = {
        path.parent.name.split("-")[0]: json.loads(path.read_text())["seed"] for path in folder.glob("hill/*/run.json")
    }
    assert {name: seed // 1_000_000 for name, seed in parts.items()} == {"search": 0, "held": 1, "sample": 2}
    kept = [row for row in table(folder, "hill") if row["of"] == "search" and row["satisfied"] == "1"]
    assert len(kept) > 3 * 60 * 0.0314, "a search finds more than chance would"
    for row in table(folder, "hill"):
        a, b = (float(row[f"planted.{name}"]) for name in "ab")
        slack_of_hill = (0.01 - (a - 0.7) ** 2 - (b - 0.2) ** 2) / 0.002
        assert float(row["slack hill"]) == pytest.approx(max(slack_of_hill, -MOST_SLACK), abs=1e-3)


def test_a_planted_infeasible_box_is_reported_with_its_interval(folder):
    outcome = fit(folder, "none", "hill,valley", *A, *B, "--trials", "40", "--sample", "32", "--held-out", "2")
    assert outcome["word"] == "not fitted"
    assert outcome["share"] == {"satisfied": 0, "of": 32, "low": 0.0, "high": proportion_interval(0, 32)[1]}
    rows = pl.read_csv(folder / "none" / "fit.csv").filter(pl.col("of") == "search")
    assert rows["satisfied"].max() == 1, "each is kept by some, both by none"


def test_a_figure_has_the_slack_of_search_and_sample_by_parameter_and_the_shares_anew(folder):
    """Each setting is a dot under the name of what it is of; the settings judged anew have their intervals."""
    fit(folder, "drawn", "luck", *A, *B, "--trials", "12", "--sample", "8", "--held-out", "10")
    run = experiments.load(folder / "drawn")
    *panels, again = [axes for axes in report.draw(run).axes if axes.lines]
    keys = sorted(("planted.a", "planted.b"), key=lambda key: -run.fitted["importance"][key])
    assert [axes.get_xlabel() for axes in panels] == [f"{key} ({run.fitted['importance'][key]:.0%})" for key in keys]
    for axes, key in zip(panels, keys, strict=True):
        for of in ("search", "sample"):
            own = run.summary.filter(of=of).select(pl.col(key).cast(float), "least slack")
            (dots,) = [line for line in axes.lines if line.get_label() == of]
            np.testing.assert_allclose(dots.get_xydata().astype(float), own.to_numpy())
    rows = {f"no. {row['number']}": row for row in run.anew.filter(name=run.anew["name"][0]).to_dicts()}
    places = {tick.get_position()[1]: tick.get_text() for tick in again.get_yticklabels()}
    assert sorted(places.values()) == sorted(rows)
    assert len({row["satisfied"] for row in rows.values()}) > 1, "or one could stand for another"
    ends = [segment[:, 0] for segment in again.collections[0].get_segments()]
    for (value, y), (low, high) in zip(again.lines[0].get_xydata(), ends, strict=True):
        row = rows[places[y]]
        assert (value, low, high) == pytest.approx((row["satisfied"] / row["replicates"], row["low"], row["high"]))


def test_a_fit_to_noise_is_exposed_anew(folder):
    outcome = fit(folder, "luck", "luck", *A, "--trials", "60", "--share", "30", "--sample", "8")
    searched = [row for row in table(folder, "luck") if row["of"] == "search"]
    assert any(row["satisfied"] == "1" for row in searched), "60 draws of a chance of one in ten"
    assert outcome["word"] == "not fitted" and outcome["luck"] > 0.0
    winner = table(folder, "luck", "anew.csv")[0]
    assert int(winner["satisfied"]) <= 8 and winner["replicates"] == "20"


def test_settings_in_which_the_model_fails_are_worst_and_on_record(tmp_path):
    """It raises in the upper half of the box, where the claim would be kept."""
    (tmp_path / "planted.py").write_text(
        PLANTED.replace("        hill = 1.0", "        1 / (self.p.a < 0.5)\n        hill = 1.0")
    )
    fit(tmp_path, "out", "hill", *A, "--trials", "8", "--share", "4", "--sample", "4", "--held-out", "1", status=1)
    rows = table(tmp_path, "out")
    failed = [row for row in rows if float(row["planted.a"]) >= 0.5]
    assert 0 < len(failed) < len(rows)
    assert {(row["satisfied"], float(row["slack hill"])) for row in failed} == {("0", -MOST_SLACK)}
    failures = experiments.load(tmp_path / "out").failures
    assert failures.height >= len(failed) and failures["reason"].str.contains("division by zero").all()


def test_frames_are_shared_by_settings_of_the_network_alone(folder):
    fit(folder, "shared", "hill", *A, *SPEED, "--trials", "8", "--share", "4", "--sample", "4", "--held-out", "1")
    searched = [row for row in table(folder, "shared") if row["of"] == "search"]
    speeds = [row["dots.speed"] for row in searched]
    assert len({*speeds[:4]}) == len({*speeds[4:]}) == 1 and len({*speeds}) == 2
    assert len({row["planted.a"] for row in searched}) == 8
    description = json.loads((folder / "shared" / "search-0000" / "run.json").read_text())
    assert description["trials"] == 2, "one showing for each rendering, with four models"


SMALL = (*A, *SPEED, "--trials", "24", "--share", "4", "--sample", "4", "--held-out", "3")


@pytest.fixture(scope="module")
def undisturbed(folder):
    fit(folder, "whole", "hill,luck", *SMALL)
    return folder / "whole"


def test_more_settings_go_on_from_fewer(folder, undisturbed):
    first = fit(folder, "more", "hill,luck", *SMALL[:5], "8", *SMALL[6:])
    assert first["looks"] == 1
    assert fit(folder, "more", "hill,luck", *SMALL)["looks"] == 2, "a second look at the seeds is told"
    assert (folder / "more" / "fit.csv").read_bytes() == (undisturbed / "fit.csv").read_bytes()
    with pytest.raises(UsageError, match="search-0000"):
        fit(folder, "more", "hill,luck", "--over", "planted.a=0..2", *SMALL[2:])


def test_the_judging_anew_has_whole_replicates_where_the_search_has_fewer_repeats(folder, monkeypatch):
    repeats = {}

    def played(plan, out, pool):
        repeats[out.name.partition("-")[0]] = plan.declared.study.repeats
        return sweep.read(plan.declared, [], [])

    monkeypatch.setattr(sweep, "played", played)
    study = Study("few", "few", claims=("C15",), experiments=("speed",), repeats=10)
    few = Fit(study, over=("dsnn.t_sp=0.1..0.2",), trials=2, share=1, sample=2, held_out=1, search_repeats=4)
    experiments.fit(few, out=folder / "few", workers=0, quiet=True)
    assert repeats == {"search": 4, "held": 10, "sample": 4}


def test_equal_clips_are_fitted_to_once_and_judged_at_any_seed(tmp_path):
    crossing = 'Clip("crossing", "plain", {"rows": 16, "columns": 24, "width": 4, "height": 8, "speed": 120.0})'
    (tmp_path / "planted.py").write_text(PLANTED.replace('Clip("dots", "dots", SMALL)', crossing))
    more = ("--trials", "40", "--share", "10", "--sample", "4", "--replicates", "5", "--held-out", "20")
    outcome = fit(tmp_path, "out", "hill,luck", "--set", "planted.b=0.2", *A, *more)
    one, *_ = (row for row in table(tmp_path, "out", "anew.csv") if row["name"] == "hill")
    names = ("replicates", "satisfied", "word", "low", "high")
    assert [one[name] for name in names] == ["1", "1", "fitted", None, None]
    assert {row["replicates"] for row in table(tmp_path, "out", "anew.csv")} == {"1"} and outcome["luck"] == 0.0
    trials = [pl.read_parquet(path)["trial"].n_unique() for path in tmp_path.glob("out/*/trials.parquet")]
    assert set(trials) == {1}
    with pytest.raises(UsageError, match="repeats"):
        fit(tmp_path, "other", "hill", *A, "--repeats", "3")


def test_slack_is_in_smallest_differences_and_unjudged_is_worst():
    assert slack(Outcome.of([Check("5 spikes", 5.0, 2.0, unit="spikes")])) == 3.0
    assert slack(Outcome.of([Check("HS", 0.21, 0.2), Check("3 spikes", 3.0, 2.0, unit="spikes")])) == 1.0
    assert slack(Outcome.of([Check("HS", 0.21, 0.2), Check("VS", 0.19, 0.2)])) == pytest.approx(-5.0)
    assert slack(Outcome.of([Check("HS", 0.9, 0.2)])) == MOST_SLACK
    assert slack(Outcome.unjudged("silent", reason="silent model")) is None


def test_a_claim_that_holds_in_some_replicates_is_not_kept():
    rows = [(0, "one", 0, "holds", 3.0, True), (0, "one", 1, "fails", -5.0, True),
            (0, "other", 0, "holds", 2.0, True), (0, "other", 1, "holds", 4.0, True)]  # fmt: skip
    (row,) = scored(pl.DataFrame(rows, RESULTS, orient="row")).to_dicts()
    assert row == {"setting": 0, "satisfied": 1, "claims": 2, "least slack": -5.0, "slack one": -5.0,
                   "slack other": 2.0, "mean slack": 1.0}  # fmt: skip


# --- the box ----------------------------------------------------------------------------------------------------------


def box(*over, claims=("C14",)):
    study = Study("fit", "a fit", claims=claims, experiments=("general",))
    return box_of(Fit(study, over))


def test_ranges_are_of_the_kind_of_their_fields():
    kinds, rendered = box(
        "dsnn.n_con=4..8", "dsnn.t_sp=0.05..0.3", "dsnn.k_sig=0.001..10", "camera.luma_range=full,video"
    )
    shares = np.arange(0.0, 1.0, 0.01)
    assert {at(kinds["dsnn.n_con"], share) for share in shares} == {"4", "5", "6", "7", "8"}
    assert all(0.05 <= float(at(kinds["dsnn.t_sp"], share)) <= 0.3 for share in shares)
    assert float(at(kinds["dsnn.k_sig"], 0.5)) == pytest.approx(0.1), "a wide range is searched by its logarithm"
    assert {at(kinds["camera.luma_range"], share) for share in shares} == {"full", "video"}
    assert rendered == ["camera.luma_range"]


@pytest.mark.parametrize(
    "over", ["dsnn.t_sp=0.3..0.1", "dsnn.t_sp=0.1..nan", "dsnn.t_sp", "dsnn.nonsense=1..2", "dsnn.t_sp=-1..0.3"]
)
def test_what_is_no_range_is_refused_before_anything_runs(over):
    fit = Fit(Study("fit", "a fit", claims=("C14",), experiments=("general",)), (over,))
    with pytest.raises(UsageError):
        plan(Asked(kind="fit", declared=fit))


def test_parameters_that_move_together_have_one_value():
    kinds, _ = box("dsnn.t_sp+dsnn.w_i=0.1..0.4", "dsnn.n_con=4,8")
    setting = {key: at(kind, share) for (key, kind), share in zip(kinds.items(), (0.5, 0.9), strict=True)}
    fit = Fit(Study("fit", "a fit", claims=("C14",)), over=("dsnn.t_sp+dsnn.w_i=0.1..0.4", "dsnn.n_con=4,8"))
    (texts,) = study_of(fit, [setting]).axes["setting"].values()
    assert texts == ("dsnn.t_sp=0.25", "dsnn.w_i=0.25", "dsnn.n_con=8")


def test_sample_is_even_and_the_same_for_the_same_seed():
    square, _ = box("dsnn.t_sp=0..1", "dsnn.w_i=0..1")
    settings = spread(square, 64, 3)
    assert settings == spread(square, 64, 3) != spread(square, 64, 4)
    for key in ("dsnn.t_sp", "dsnn.w_i"):  # one in each of 64 slices, as a Sobol sequence has them
        assert sorted(int(float(setting[key]) * 64) for setting in settings) == list(range(64))
