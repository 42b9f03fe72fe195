"""The box of a fit: ranges by the parameters' own fields, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.bench import registry
from experiments.bench.box import Range, box_of, setting_at, spread
from experiments.bench.fit import Fit, assigned, text_of
from experiments.bench.run.errors import UsageError
from experiments.bench.study import Study


def box(*over, experiment="general", **more):
    study = Study("fit", "a fit", claims=("C14",), experiments=(experiment,), **more)
    return box_of(over, study, [registry.find(experiment)])


def test_ranges_are_of_the_kind_of_their_fields():
    whole, real, choice, camera = box(
        "dsnn.n_con=4..8", "dsnn.t_sp=0.05..0.3", "dsnn.polarity", "camera.luma_range=full,video"
    )
    assert whole.whole and {whole.at(share) for share in np.arange(0.0, 1.0, 0.01)} == {"4", "5", "6", "7", "8"}
    assert not real.whole and 0.05 <= float(real.at(0.3)) <= 0.3
    assert set(choice.choices) == {"common", "centre"}
    assert [part.network for part in (whole, real, choice, camera)] == [True, True, True, False]


def test_a_wide_range_of_positive_numbers_is_searched_by_its_logarithm():
    assert float(Range("dsnn.k_sig", 0.001, 10.0).at(0.5)) == pytest.approx(0.1)
    assert float(Range("x.y", 1.0, 99.0).at(0.5)) == 50.0


def test_parameters_that_move_together_have_one_value():
    square = box("dsnn.t_sp+dsnn.w_i=0.1..0.4", "dsnn.n_con=4,8")
    assert [part.key for part in square] == ["dsnn.t_sp+dsnn.w_i", "dsnn.n_con"]
    assert assigned(setting_at(square, [0.5, 0.9])) == ("dsnn.t_sp=0.25", "dsnn.w_i=0.25", "dsnn.n_con=8")
    fit = Fit(Study("fit", "a fit", experiments=("leaderboard",), models=("dsnn",)), over=("dsnn.t_sp+dsnn.w_i=0..1",),
              maximise=("auc_clips",))  # fmt: skip
    assert text_of(fit, setting_at(square, [0.5, 0.9])) == "dsnn:t_sp=0.25,w_i=0.25,n_con=8"


def test_sample_is_even_and_the_same_for_the_same_seed():
    square = box("dsnn.t_sp=0..1", "dsnn.w_i=0..1")
    settings = spread(square, 64, 3)
    assert settings == spread(square, 64, 3) != spread(square, 64, 4)
    for key in ("dsnn.t_sp", "dsnn.w_i"):  # one in each of 64 slices, as a Sobol sequence has them
        assert sorted(int(float(setting[key]) * 64) for setting in settings) == list(range(64))


def test_a_parameter_is_there_once():
    with pytest.raises(UsageError, match="there twice"):
        box("dsnn.t_sp=0.1..0.2", "dsnn.t_sp=0.2..0.3")
    with pytest.raises(UsageError, match="there twice"):
        box("dsnn.t_sp+dsnn.w_i=0.1..0.2", "dsnn.t_sp=0.2..0.3")
