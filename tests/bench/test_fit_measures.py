"""Fits to measures: a planted optimum, luck and gain, the front, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import polars as pl
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.bench import tune
from experiments.bench.box import Range
from experiments.bench.cli import main
from experiments.bench.fit import RESULTS, Fit, FitPlan, conclude, front, scored, worth
from experiments.bench.study import Study

pytest.importorskip("optuna")

PLANTED = '''
"""A model whose answers are set by its parameters alone, and a crossing to show it."""
from dataclasses import dataclass

import dsnn
from experiments import Clip, OfflineExperiment

CROSSING = {"rows": 16, "columns": 24, "motion": "rightward", "duration_s": 0.2, "width": 4.0, "height": 4.0}


@dataclass(frozen=True)
class Parameters:
    a: float = 0.5
    b: float = 0.5
    t_sp: float = 0.2


class Planted:
    def __init__(self, shape, parameters):
        self.p = parameters

    def reset(self):
        pass

    def step(self, frame):
        return dsnn.Response(hs=1.0 - (self.p.a - 0.7) ** 2 - (self.p.b - 0.2) ** 2, vs=0.0)


MODEL = dsnn.ModelEntry("planted", "planted", Planted, Parameters())
EXPERIMENT = OfflineExperiment("crossing", "a crossing", [Clip("crossing", "plain", CROSSING)], models=("planted.py",))
'''
A, B = ("--over", "planted.a=0..1"), ("--over", "planted.b=0..1")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("measures")
    (place / "planted.py").write_text(PLANTED)
    return place


def fit(folder, out, *arguments, experiment=""):
    file = str(folder / "planted.py")
    words = ["fit", experiment or file, "--model", file, *arguments, "--out", str(folder / out), "-q", "--workers", "0"]
    assert main.command(words) == 0
    return json.loads((folder / out / "fit.json").read_text())


def test_a_planted_optimum_of_a_measure_is_found_without_luck(folder):
    result = fit(folder, "hill", "--maximise", "peak-hs", *A, *B, "--trials", "60", "--sample", "16", "--held-out", "3")
    assert abs(float(result["winner"]["planted.a"]) - 0.7) < 0.15
    assert abs(float(result["winner"]["planted.b"]) - 0.2) < 0.15
    rows = pl.read_csv(folder / "hill" / "fit.csv").to_dicts()
    for row in rows:
        hill = 1.0 - (float(row["planted.a"]) - 0.7) ** 2 - (float(row["planted.b"]) - 0.2) ** 2
        assert float(row["peak-hs"]) == pytest.approx(hill, abs=1e-5)
    as_it_is = 1.0 - 0.2**2 - 0.3**2
    best = max(float(row["peak-hs"]) for row in rows if row["of"] == "search")
    assert result["gain"]["peak-hs"] == pytest.approx(best - as_it_is, abs=1e-5)
    assert result["luck"]["peak-hs"] == pytest.approx(0.0, abs=1e-9), "nothing there is random"


def planted_result(values, maximise, minimise, anew, start, even=lambda searched: searched):
    """A result of planted values: one for each setting searched, and those of the winner and the start anew."""
    study = Study("made", "made", claims=(), experiments=("clean",), repeats=None, replicates=1)
    asked = Fit(study, ("m.a=0..9",), maximise=maximise, minimise=minimise, held_out=3)
    settings = tuple({"m.a": str(number)} for number in range(len(values)))

    def results(rows):
        return pl.DataFrame(
            [(number, goal, place, None, value) for number, row in enumerate(rows)
             for goal, each in zip(asked.goals, row, strict=True) for place, value in enumerate(each)],
            RESULTS, orient="row",
        )  # fmt: skip

    searched = results([[(value,) for value in row] for row in values])
    best = tuple(front([worth(row, asked) for row in scored(searched).to_dicts()]))
    plan = FitPlan(asked, (Range("m.a", 0.0, 9.0, network=True),), 0, 1, 2)
    again = results([anew] * len(best) + [start])
    return conclude(plan, settings, searched, list(best), again, settings, even(searched), 1, {}, [])


def test_of_a_minimum_luck_and_gain_have_the_same_sense():
    result = planted_result([(0.2,), (0.9,)], (), ("x",), [(0.4, 0.4, 0.4)], [(0.7, 0.7, 0.7)])
    assert result.winner == {"m.a": "0"}
    assert result.luck["x"] == pytest.approx(0.2) and result.gain["x"] == pytest.approx(0.3)


def test_a_goal_without_a_value_in_the_even_sample_is_said_to_have_none():
    empty = planted_result([(0.2,), (0.9,)], ("x",), (), [(0.5,)], [(0.6,)], lambda t: t.with_columns(value=np.nan))
    assert empty.settings.filter(of="sample")["x"].is_nan().all() and empty.luck["x"] == pytest.approx(0.4)


def test_a_result_of_two_goals_has_its_front():
    rows = [(1.0, 5.0), (2.0, 6.0), (1.5, 9.0)]
    result = planted_result(rows, ("x",), ("y",), [(1.0,), (5.0,)], [(0.5,), (9.0,)])
    table = result.anew
    assert table["number"].unique(maintain_order=True).to_list() == [1, 0, None], "the third is worse than the second"
    assert table.height == 3 * 2 and table["m.a"][-1] == "as it is"


VALUES = st.lists(st.tuples(*[st.one_of(st.integers(0, 4), st.just(np.nan))] * 3), min_size=1, max_size=20)


@given(VALUES)
def test_the_front_has_just_the_settings_that_none_betters(values):
    signed = [np.array(row, float) for row in values]
    chosen = front(signed)
    for place, row in enumerate(signed):
        if np.isnan(row).any():
            assert place not in chosen
            continue
        betters = [other for other in signed if (other >= row).all() and (other > row).any()]
        if betters:
            assert place not in chosen
        else:
            assert any((signed[number] == row).all() for number in chosen)


def test_numbers_of_tuning_curves_are_goals_and_the_run_goes_on(folder, monkeypatch):
    turns = tune.FAMILIES["direction"]
    once = [probe for probe in turns.probes if probe.repeat == 0]
    monkeypatch.setattr(tune, "FAMILIES", {"direction": turns._replace(probes=once)})
    words = ("--maximise", "vs_dsi", "--minimise", "error_deg", "--over", "dsnn.w_i=0.5..1", "--trials", "2")
    small = ("--share", "1", "--sample", "1", "--held-out", "1")
    arguments = ["fit", "tuning", *words, *small, "--out", str(folder / "curves"), "-q", "--workers", "0"]
    assert main.command(arguments) == 0
    first = (folder / "curves" / "fit.csv").read_bytes()
    assert main.command(arguments) == 0, "nothing is played again"
    assert (folder / "curves" / "fit.csv").read_bytes() == first
    result = json.loads((folder / "curves" / "fit.json").read_text())
    assert result["goals"] == {"vs_dsi": 1, "error_deg": -1} and result["looks"] == 1
