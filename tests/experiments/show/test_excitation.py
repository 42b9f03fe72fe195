"""Excitation and inhibition put together from potentials: laws of the network, the experiments."""

import dataclasses
from functools import cache

import numpy as np
import polars as pl
import pytest

import experiments
from dsnn import ReferenceDSNN
from dsnn.direction import reference as layers
from dsnn.filters import alpha
from experiments.declare.experiment import NEEDED
from experiments.kinds.result import plan_of
from experiments.show.excitation import BALANCED, WHOLE, sums
from experiments.store.asked import Asked
from tests.helpers import plans

SHAPE, FRAMES = (24, 40), 24
MADE = plans.planned("approach-mechanism", NEEDED, repeats=1)
NETWORKS = {model.label: model for model in MADE.trials[0].models}
W_I = NETWORKS[WHOLE].network.w_i
ROUNDING = 1e-4
"""Of E and I, relative to their largest: the network sums float32."""


def noise(seed=3):
    """Patches that jump: both polarities, every direction, strong and weak answers."""
    draws = np.random.default_rng(seed)
    coarse = draws.integers(60, 200, (FRAMES // 3, SHAPE[0] // 4, SHAPE[1] // 4))
    return np.kron(coarse, np.ones((3, 4, 4))).astype(np.uint8)


def answers(clip):
    """HS of every model that the figure needs."""
    hs_by_model = {}
    for label, model in NETWORKS.items():
        network = model.build(SHAPE)
        hs_by_model[label] = np.array([network.step(frame).hs for frame in clip])
    return hs_by_model


def potentials(hs_by_model):
    count = len(hs_by_model[WHOLE])
    return pl.concat(
        pl.DataFrame({"trial": [0] * count, "model": [label] * count, "frame": range(count),
                      "time_s": np.arange(count) / 30, "hs": hs, "hs_spikes": np.zeros(count, np.int64)})
        for label, hs in hs_by_model.items()
    )  # fmt: skip


def trial_of(clip, w_i=W_I):
    return {name: values.to_numpy() for name, values in sums(potentials(answers(clip)), w_i).to_dict().items()}


def by_the_equations(clip):
    """E and I of the paper's equations in float64, low-passed, over ``4 C R K_sig``."""
    q = NETWORKS[WHOLE].network
    reference, alphas, gain = ReferenceDSNN(SHAPE, q), [alpha(tau, q.dt) for tau in q.delays()], alpha(q.tau_mp, q.dt)
    delays = {name: [np.zeros(SHAPE) for _ in alphas] for name in ("f_on", "f_off")}
    sums, series = np.zeros(2), []
    for frame in clip:
        maps = reference.step(frame, maps=True).maps
        now = np.zeros(2)
        for name, states in delays.items():
            f = getattr(maps, name)
            delays[name] = layers.delayed(f, states, alphas)
            e = layers.correlate(f, delays[name], q.d, 0.0, axis=1)
            now += e, e - layers.correlate(f, delays[name], q.d, 1.0, axis=1)
        sums = sums + gain * (now - sums)
        series.append(sums / (4.0 * SHAPE[0] * SHAPE[1] * q.k_sig))
    return np.array(series).T


def near(measured, expected):
    return pytest.approx(expected, abs=ROUNDING * float(np.abs(expected).max())) == measured


# --- the laws ---------------------------------------------------------------------------------------------------------


def test_excitation_and_inhibition_are_those_of_the_equations():
    trial, (excitation, inhibition) = trial_of(noise()), by_the_equations(noise())
    assert excitation.max() > 0.1 and inhibition.max() > 0.1, "the clip drives both"
    assert near(trial["excitation"], excitation) and near(trial["inhibition"], inhibition)


@pytest.mark.parametrize("w_i", [0.0, 0.5, 0.9, 1.0])
def test_both_parts_make_up_what_the_lobula_plate_takes(w_i):
    trial = trial_of(noise(), w_i)
    taken = trial["excitation"] - trial["weighted_inhibition"]
    assert trial["directional"] + trial["residue"] == pytest.approx(taken, abs=1e-12)
    assert bool(trial["residue"].max() > 0.01) is (w_i < 1.0), "w_i = 1 leaves nothing of symmetric motion"


# --- the experiments --------------------------------------------------------------------------------------------------


@cache
def reproduction():
    return plan_of(Asked(kind="reproduction", seed=5, options={"scale": "quick", "robot_only": True})).parts


@pytest.mark.parametrize("motion", ["approach", "recession"])
def test_the_trials_are_those_that_the_claims_are_judged_on(motion):
    parts = reproduction()
    judged, mechanism = parts[f"angular-{motion}"], parts[f"{motion}-mechanism"]
    assert [model.label for model in mechanism.trials[0].models] == list(NEEDED), "and no other models"
    one, other = ([(spec.seed, spec.condition) for spec in run_plan.trials] for run_plan in (judged, mechanism))
    assert one == other
    assert len({dataclasses.replace(run_plan.trials[0].settings, models=()) for run_plan in (judged, mechanism)}) == 1


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    settings = {"experiment.angles_deg": [-30, 0], "experiment.speed_cm_s": 12}
    return experiments.run(
        "recession-mechanism", repeats=2, settings=settings, recordings=False, quiet=True, workers=0,
        out=tmp_path_factory.mktemp("excitation") / "out",
    )  # fmt: skip


def test_the_table_s_means_are_those_of_the_frames(run):
    frames = run.frames.to_dicts()
    trials = {row["trial"] for row in run.trials.to_dicts() if row["angle_deg"] == -30.0}
    at = [row for row in pl.read_csv(run.folder / "excitation.csv").to_dicts() if row["angle_deg"] == -30.0]
    for row in at[:: len(at) // 5]:
        here = [frame for frame in frames if frame["trial"] in trials and frame["frame"] == row["frame"]]
        for name, model in (("hs", WHOLE), ("hs_w_i_1", BALANCED)):
            assert row[name] == pytest.approx(np.mean([frame["hs"] for frame in here if frame["model"] == model]))
        firing = [frame for frame in here if frame["model"] == WHOLE and frame["hs_spikes"]]
        assert row["firing"] == len(firing)


def test_pathways_are_not_compared_as_if_they_were_models(run):
    assert {row["model"] for row in run.trials.to_dicts()} == set(NEEDED), "the tables have all"
    assert {row["model"] for row in run.summary.to_dicts()} == {WHOLE, BALANCED}
    pairs = pl.read_csv(run.folder / "comparisons.csv").to_dicts()
    assert {(row["model"], row["against"]) for row in pairs} == {(WHOLE, BALANCED)}
