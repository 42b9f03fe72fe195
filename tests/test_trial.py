"""A trial is a pure function of its specification, and its numbers are those of its frames."""

import dataclasses

import numpy as np
import pytest

from colias_sim import CameraConfig, RobotConfig, SceneConfig
from dsnn import DSNN, DSNNParams
from experiments.bench import trial
from experiments.bench.declaration import Condition, Experiment, Settings, Translation, trial_seed, trial_specs
from experiments.bench.trial import run_trial


def settings(**changes) -> Settings:
    base = Settings("dsnn", DSNNParams.robot(), RobotConfig(), CameraConfig(), SceneConfig(), 1.0, 1.0)
    return dataclasses.replace(base, **changes)


def spec(speed=10.0, distance=8.0, direction="rightward", seed=7, index=0, **changes):
    condition = Condition("translation", speed, distance, None, direction)
    return trial.TrialSpec("test", index, 0, seed, condition, settings(**changes))


def same(a: trial.TrialResult, b: trial.TrialResult) -> bool:
    scalars = [f.name for f in dataclasses.fields(a) if f.name not in ("wall_s", "columns", "media", "spec")]
    columns = [f.name for f in dataclasses.fields(a.columns)]
    return all(getattr(a, n) == getattr(b, n) for n in scalars) and all(
        np.array_equal(getattr(a.columns, n), getattr(b.columns, n)) for n in columns
    )


def test_same_specification_same_numbers_whatever_ran_before():
    first = run_trial(spec())
    run_trial(spec(speed=20.0, direction="leftward", seed=99))
    assert same(run_trial(spec()), first)
    trial.forget_simulation()  # a newly compiled scene, a new OpenGL context
    assert same(run_trial(spec(), keep_media=True), first)


def test_another_seed_is_another_trial():
    assert not same(run_trial(spec(seed=1)), run_trial(spec(seed=2)))


@pytest.mark.parametrize("direction", ["rightward", "leftward"])
@pytest.mark.parametrize(("speed", "distance"), [(30.0, 8.0), (30.0, 15.0), (10.0, 5.0)])
def test_achieved_speed_and_path_of_a_crossing(direction, speed, distance):
    result = run_trial(spec(speed, distance, direction))
    assert result.achieved_speed_cm_s == pytest.approx(speed, rel=0.02)
    assert result.path_error_mm < 1.0
    assert result.closest_cm == pytest.approx(distance, abs=1.2), "the errors of the start pose, carried along"


def test_a_crossing_starts_and_ends_outside_the_view():
    """Less than the noise tells its first and last frames from one another's background."""
    quiet = CameraConfig(shot_noise=0, read_noise=0)
    result = run_trial(spec(camera=quiet), keep_media=True)
    frames = result.media.camera.astype(int)
    assert np.abs(frames[0] - frames[-1]).max() <= 2
    assert np.abs(frames[0] - frames[len(frames) // 2]).max() > 150
    assert result.columns.stimulus_bearing_deg[0] > 35 > -35 > result.columns.stimulus_bearing_deg[-1]


def test_direction_decides_the_sign():
    """C14: rightward past +T and nothing past -T; leftward the other way round; spikes likewise."""
    right, left = run_trial(spec(6.0)), run_trial(spec(6.0, direction="leftward"))
    assert right.peak_hs > 0.2 and right.trough_hs > -0.1
    assert left.trough_hs < -0.2 and left.peak_hs < 0.1
    assert right.columns.hs_spikes.sum() == right.spikes > 0
    assert left.columns.hs_spikes.sum() == -left.spikes < 0


def test_the_response_is_the_model_s_on_the_recorded_frames():
    """What the recording shows is what the network saw: a fresh model on those frames answers the same."""
    result = run_trial(spec(), keep_media=True)
    series = DSNN((72, 99), DSNNParams.robot()).run(result.media.camera)
    np.testing.assert_array_equal(series.hs, result.columns.hs)
    np.testing.assert_array_equal(series.hs_spikes, result.columns.hs_spikes)


def test_numbers_are_those_of_the_frames():
    result = run_trial(spec())
    columns = result.columns
    assert result.frames == len(columns.hs) == len(columns.sim_time_s)
    np.testing.assert_allclose(np.diff(columns.sim_time_s), 1 / 30, atol=1e-9)
    assert result.spikes == np.abs(columns.hs_spikes).sum()
    assert result.firing_rate_hz == pytest.approx(result.spikes / columns.sim_time_s[-1])
    assert (result.peak_hs, result.trough_vs) == (columns.hs.max(), columns.vs.min())


def test_without_a_stimulus_in_view_noise_alone_fires_nothing():
    """The margin between camera noise and threshold: 40 frames of background stay below a tenth of T."""
    from colias_sim import Pose, Simulation

    model = DSNN((72, 99), DSNNParams.robot())
    with Simulation() as sim:
        sim.reset({"stimulus": Pose(-0.3, 0.0, 0.0)}, np.random.default_rng(0))
        rng = np.random.default_rng(1)
        hs = [model.step(sim.step(rng).luma).hs for _ in range(40)]
    assert np.abs(hs).max() < 0.02


def test_light_and_wall_vary_with_the_seed_and_switch_off():
    def first_frames(**scene):
        quiet = CameraConfig(shot_noise=0, read_noise=0)
        return [
            run_trial(spec(30.0, seed=s, camera=quiet, scene=SceneConfig(**scene)), keep_media=True).media.camera[0]
            for s in (1, 2)
        ]

    varied, fixed = first_frames(), first_frames(light_sd=0, turn_wall=False)
    assert not np.array_equal(*varied)
    np.testing.assert_array_equal(*fixed)


def test_seeds_depend_on_the_experiment_s_seed_and_index_alone():
    experiment = Experiment("x", "", Translation(speeds_cm_s=(2, 4), distances_cm=(8,)), "speed_cm_s")
    few, many = (trial_specs(experiment, settings(), repeats, 5) for repeats in (2, 4))
    assert few == many[:4], "more repeats only append"
    assert [s.seed for s in many] == [trial_seed(5, i) for i in range(8)]
    assert len({s.seed for s in many} | {trial_seed(6, i) for i in range(8)}) == 16
    assert [s.condition.speed_cm_s for s in few] == [2, 4, 2, 4]


def test_a_specification_is_small_and_hashable():
    import pickle

    one = spec()
    assert hash(one) == hash(pickle.loads(pickle.dumps(one)))
    assert len(pickle.dumps(one)) < 2000


def test_conditions_of_both_directions():
    design = Translation(speeds_cm_s=(6,), distances_cm=(5, 10), direction="both")
    assert [(c.direction, c.distance_cm) for c in design.conditions()] == [
        ("rightward", 5), ("rightward", 10), ("leftward", 5), ("leftward", 10),
    ]  # fmt: skip
