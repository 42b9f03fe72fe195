"""A trial is a pure function of its specification, and its numbers are those of its frames."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import polars as pl
import pytest

from colias_sim import CameraConfig, Pose, RobotConfig, SceneConfig, Simulation
from colias_sim.truth import COLUMNS
from dsnn.model import MAP_SCALES
from experiments.declare.conditions import Condition, Hand
from experiments.declare.experiment import Angular, Experiment, Translation, visit
from experiments.settings.models import choose
from experiments.settings.settings import Settings
from experiments.show import course, robot
from experiments.show.play import ERRORS
from experiments.show.robot import RobotTrial, trial_seed, trials_of
from experiments.show.trial_rows import AGREEMENT, agreement
from tests.helpers.played import Played


def settings(**changes) -> Settings:
    base = Settings((choose("dsnn"),), RobotConfig(), CameraConfig(), SceneConfig(), 1.0, 1.0)
    return dataclasses.replace(base, **changes)


def trial_of(condition: Condition, seed=5, **changes) -> RobotTrial:
    return RobotTrial("test", 0, 0, seed, condition, settings(**changes))


def spec(speed=10.0, distance=8.0, direction="rightward", seed=7, **changes) -> RobotTrial:
    return trial_of(Condition("translation", direction, speed, distance), seed, **changes)


def test_same_specification_same_numbers_whatever_ran_before():
    first = Played(spec())
    Played(spec(speed=20.0, direction="leftward", seed=99))
    assert Played(spec()).equals(first)
    robot.forget_simulations()  # a newly compiled scene, a new OpenGL context
    assert Played(spec(), maps=True).equals(first)


def test_truth_adds_columns_of_what_is_in_view_and_changes_nothing():
    plain = Played(spec(speed=20.0))
    told = Played(dataclasses.replace(spec(speed=20.0), truth=True))
    (row,), (before,) = told.record.rows, plain.record.rows
    assert {name: value for name, value in row.items() if name not in AGREEMENT} == before
    assert row["true_hs_view_r"] > 0.8 and row["true_sign"] > 0.9 and row["true_gain"] > 0.05
    frames = told.record.frames
    assert frames.drop(*COLUMNS, *ERRORS).equals(plain.record.frames)
    rightward, bearing = frames["true_flow_x"].to_numpy(), frames["stimulus_bearing_deg"].to_numpy()
    assert np.isnan(rightward[np.abs(bearing) > 60]).all() and (rightward[np.abs(bearing) < 25] > 2).all()


def test_a_models_local_motion_is_compared_with_the_flow_of_every_frame():
    """Optic flow is nearer to the truth than no motion, whose error is the length of the flow; the DSNN has none."""
    trial = dataclasses.replace(spec(speed=20.0, models=(choose("dsnn"), choose("flow"))), truth=True)
    dsnn, flow = (Played(trial).record.frames.filter(model=name) for name in ("dsnn", "flow"))
    assert dsnn["true_end_point_error_px"].null_count() == dsnn["true_angular_error_deg"].null_count() == dsnn.height
    moving = flow.filter(pl.col("true_flow_x") > 2, pl.col("stimulus_bearing_deg").abs() < 25)
    assert (moving["true_end_point_error_px"] < moving["true_flow_x"]).all() and moving.height > 10
    assert moving["true_angular_error_deg"].is_between(0.0, 60.0).all()


def test_a_potential_in_proportion_to_the_flow_agrees_in_full():
    """And one of the other sign in nothing; in what does not move there is nothing to agree with."""
    flow = [None, 0.0, 1.0, 2.0, -1.0, None]
    frames = pl.DataFrame({"true_flow_x": flow, "true_view_x": [x and x / 5 for x in flow], "vs": [0.0] * 6})
    frames = frames.with_columns(true_flow_y=pl.lit(0.0), true_view_y=pl.lit(None))
    for gain in (0.25, -0.25):
        found = agreement(frames.with_columns(hs=gain * pl.col("true_flow_x").fill_null(0.0)))
        assert found["true_hs_flow_r"] == pytest.approx(np.sign(gain)) == found["true_hs_view_r"]
        assert (found["true_gain"], found["true_sign"]) == (pytest.approx(gain), float(gain > 0))
        assert found["true_vs_flow_r"] is found["true_vs_view_r"] is None
    silent = agreement(frames.with_columns(hs=0.0, true_flow_x=pl.lit(None)))
    assert set(silent) == set(AGREEMENT) and not any(value is not None for value in silent.values())


def test_numbers_are_those_of_the_trial_and_of_its_camera():
    """By the frames, of an eye with another clock, view and place than usual; windows are those of 10 cm/s."""
    camera = CameraConfig(fps=20.0, hfov_deg=50.0, forward_cm=1.0)
    condition = Condition("translation", "rightward", 6.0, 8.0)
    result = Played(RobotTrial("test", 3, 2, 7, condition, settings(camera=camera)))
    (row,), (answer,), columns = result.record.rows, result.answers, result.columns
    ahead = np.exp(1j * np.radians(columns.observer_heading_deg))
    eye = columns.observer_x_cm + 1j * columns.observer_y_cm + 1.0 * ahead
    away = (columns.stimulus_x_cm + 1j * columns.stimulus_y_cm - eye) / ahead
    bearing, spikes = -np.degrees(np.angle(away)), np.abs(answer.series.hs_spikes)
    np.testing.assert_allclose(columns.stimulus_bearing_deg, bearing, atol=1e-6)
    seen, half = np.abs(bearing) <= 25.0, math.radians(25.0)
    off_s = np.abs(columns.time_s - columns.time_s[np.abs(bearing).argmin()])
    inner, window = (off_s <= (8.0 * math.tan(half) + edge / math.cos(half)) / 10.0 for edge in (0.0, 2.0))
    expected = {
        "trial": 3, "repeat": 2, "seed": 7, "closest_cm": np.abs(away).min(), "seconds_in_view": seen.sum() / 20,
        "firing_rate_hz": 20 * spikes.mean(), "rate_in_view_hz": 20 * spikes[seen].mean(),
        "spikes_in_window": spikes[window].sum(), "spikes_in_inner_window": spikes[inner].sum(),
        "mean_hs_near_axis": answer.series.hs[np.abs(away.imag) <= 3.5].mean(),
        "mean_hs_in_view": answer.series.hs[seen].mean(), "spikes_in_view": spikes[seen].sum(),
        "spikes": spikes.sum(), "hs_spikes": spikes.sum(), "vs_spikes": np.abs(answer.series.vs_spikes).sum(),
        **{f"peak_{name}": getattr(answer.series, name).max() for name in ("hs", "vs")},
        **{f"trough_{name}": getattr(answer.series, name).min() for name in ("hs", "vs")},
    }  # fmt: skip
    assert {name: row[name] for name in expected} == pytest.approx(expected) and spikes[inner].sum() > 0


def test_a_condition_s_looks_are_those_of_a_scene_set_so():
    looks = {"shell_grey": 0.5, "wall_contrast": 0.4}
    by_condition = Played(trial_of(Condition("translation", "rightward", 30.0, 8.0, **looks)))
    by_scene = Played(spec(30.0, seed=5, scene=SceneConfig(**looks)))
    np.testing.assert_array_equal(by_condition.media.images[""], by_scene.media.images[""])


def test_a_hand_s_commands_have_their_units_and_their_frame():
    commands = ((10, "stimulus", 6.0, 0.0), (10, "observer", 0.0, -30.0))
    hand = Hand(40, (12.0, 0.0, 90.0), (0.0, 0.0, 0.0), commands)
    columns = Played(*trials_of(visit(hand), settings(), 1, 0)).columns
    for way, rate in ((columns.stimulus_y_cm, 6.0), (columns.observer_heading_deg, -30.0)):
        assert np.abs(way[:10]).max() < 0.02 < abs(way[10])
        np.testing.assert_allclose(np.diff(way[20:]) * 30, rate, rtol=0.03)


@pytest.mark.parametrize("name", MAP_SCALES)
def test_the_maps_of_a_recording_are_the_layers_of_their_names(name):
    media = Played(spec(), maps=True).media
    network, (gain, zero) = choose("dsnn").build((72, 99)), MAP_SCALES[name]
    layer = [gain * getattr(network.step(frame, maps=True).maps, name) + zero for frame in media.images[""]]
    assert np.abs(media.maps[name] - np.clip(layer, 0, 255)).max() < 0.51


def depth_trial(motion, angle):
    return Played(trial_of(Angular(motion, acceleration_cm_s2=15.0).at(motion, angle)))


@pytest.mark.parametrize("motion", ["approach", "recession"])
@pytest.mark.parametrize("angle", [-30.0, 0.0, 15.0])
def test_approach_and_recession_go_where_they_say(motion, angle):
    """Between a point 5 cm before the lens and 20 cm from it, on the robot's left for negative angles."""
    result = depth_trial(motion, angle)
    columns, lens = result.columns, 1.95
    x, y = columns.stimulus_x_cm - lens, columns.stimulus_y_cm
    near, far = (-1, 0) if motion == "approach" else (0, -1)
    assert (x[near], y[near]) == (pytest.approx(5.0, abs=0.35), pytest.approx(0.0, abs=0.35))
    assert np.hypot(x[far], y[far]) == pytest.approx(20.0, abs=0.4)
    slope = np.degrees(np.arctan2(y[far] - y[near], x[far] - x[near]))
    assert slope == pytest.approx(-angle, abs=2.0)
    assert result.achieved_speed_cm_s == pytest.approx(6.0, rel=0.02)
    assert result.path_error_mm < 1.0


def test_mirrored_angles_mirror_the_image():
    """Image directions: an approach from the left moves right; a recession to the right moves right."""
    ways = {-30: "rightward", -15: "rightward", 0: "straight", 15: "leftward", 30: "leftward"}
    assert {c.angle_deg: c.direction for c in Angular("approach").conditions()} == ways
    assert {-c.angle_deg: c.direction for c in Angular("recession").conditions()} == ways


@pytest.mark.parametrize(
    ("direction", "drive", "turn"),
    [*(("rightward", *way) for way in ((0.0, 0.0), (0.0, -5.0), (0.0, 5.0), (0.0, 20.0), (-1.0, 0.0), (2.0, 0.0))),
     ("leftward", 2.0, 0.0), ("leftward", 0.0, 5.0)],
)  # fmt: skip
def test_a_crossing_is_out_of_a_moving_observer_s_view_at_both_ends(direction, drive, turn):
    """By the poses that physics gives: the stimulus's whole disc beyond the edge of the view, on the right sides."""
    sign = 1.0 if direction == "rightward" else -1.0
    condition = Condition(
        "translation", direction, 6.0, 8.0, observer_speed_cm_s=drive, observer_turn_deg_s=sign * turn
    )
    result = Played(trial_of(condition))
    columns = result.columns
    middle = int(np.argmin(np.abs(columns.stimulus_y_cm)))
    assert columns.observer_heading_deg[middle] == pytest.approx(0.0, abs=1.0), "in mid-crossing as it stands otherwise"
    assert columns.observer_x_cm[middle] == pytest.approx(0.0, abs=0.1)
    ahead = CameraConfig().forward_cm * np.exp(1j * np.radians(columns.observer_heading_deg))
    lens = columns.observer_x_cm + 1j * columns.observer_y_cm + ahead
    distance = np.abs(columns.stimulus_x_cm + 1j * columns.stimulus_y_cm - lens)
    beyond = np.abs(columns.stimulus_bearing_deg) - np.degrees(np.arcsin(2.0 / distance)) - 35.0
    assert beyond[0] > 0 and beyond[-1] > 0 and beyond[len(beyond) // 2] < 0
    assert sign * columns.stimulus_bearing_deg[0] < 0 < sign * columns.stimulus_bearing_deg[-1]


def test_turning_with_the_stimulus_is_refused():
    condition = Condition("translation", "rightward", 6.0, 8.0, observer_turn_deg_s=-20.0)
    with pytest.raises(ValueError, match=r"-20 .* 6 cm/s"):
        course.nominal(condition, settings())


def test_light_and_wall_vary_with_the_seed_and_switch_off():
    def first_frames(**scene):
        quiet = CameraConfig(shot_noise=0, read_noise=0)
        specs = [spec(30.0, seed=s, camera=quiet, scene=SceneConfig(**scene)) for s in (1, 2)]
        return [Played(trial_spec, maps=True).media.images[""][0] for trial_spec in specs]

    varied, fixed = first_frames(), first_frames(light_sd=0, turn_wall=False)
    assert not np.array_equal(*varied)
    np.testing.assert_array_equal(*fixed)


def test_what_a_reset_draws_next_does_not_depend_on_what_is_switched_off():
    """A wall that stands and light that stays change no robot's draw, and no camera's noise."""
    drawn = []
    for scene in ({}, {"turn_wall": False}, {"light_sd": 0}, {"light_sd": 0, "turn_wall": False}):
        rng = np.random.default_rng(3)
        with Simulation(scene=SceneConfig(**scene), seeing=False) as sim:
            sim.reset({"stimulus": Pose(0.1, 0.0, 0.0)}, rng)
        drawn.append(rng.random())
    assert len(set(drawn)) == 1


def test_seeds_depend_on_the_experiment_s_seed_and_index_alone():
    experiment = Experiment("x", "", Translation(speeds_cm_s=(2, 4), distances_cm=(8,)), "speed_cm_s")
    few, many = (trials_of(experiment, settings(), repeats, 5) for repeats in (2, 4))
    assert few == many[:4], "more repeats only append"
    assert [s.seed for s in many] == [trial_seed(5, i) for i in range(8)]
    assert len({s.seed for s in many} | {trial_seed(6, i) for i in range(8)}) == 16
    assert [s.condition.speed_cm_s for s in few] == [2, 4, 2, 4]


def test_recordings_leave_no_threads_behind():
    """Rerun would keep two threads, and with them all data, of every recording made."""
    result, threads = Played(spec(), maps=True), []
    for _ in range(5):
        assert result.recording
        threads.append(len(list(Path("/proc/self/task").iterdir())))
    assert threads[-1] <= threads[2]


def test_it_stands_still_before_and_after():
    """Three tenths of a second each; in between it starts and stops no harder than told."""
    columns = depth_trial("approach", 0.0).columns
    moved = np.hypot(np.diff(columns.stimulus_x_cm), np.diff(columns.stimulus_y_cm)) * 30  # cm/s
    assert (moved[:8] < 0.05).all() and (moved[-8:] < 0.1).all()
    assert moved.max() == pytest.approx(6.0, rel=0.03)
    quick = np.flatnonzero(moved > 5.4)
    started = np.flatnonzero(moved > 0.6)[0]
    assert (quick[0] - started) / 30 == pytest.approx(4.8 / 15.0, abs=0.07)
