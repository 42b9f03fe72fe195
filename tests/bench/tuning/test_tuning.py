"""Tuning curves: the index on made-up responses, laws that the models keep, the command in real processes."""

import csv
import dataclasses
import json
import math

import numpy as np
import pyarrow.parquet as pq
import pytest

from dsnn import DSNN, EMD, MODELS, DSNNParams, EMDParams
from dsnn.stimuli import STIMULI
from experiments.bench.run.errors import UsageError
from experiments.bench.run.runs import Resources
from experiments.bench.run.workers import open_workers
from experiments.bench.tuning import probes
from experiments.bench.tuning import run as tuning_run
from experiments.bench.tuning.curves import (
    Preferred,
    TuningPoint,
    answer,
    best_rows,
    grid,
    half_contrast,
    moving,
    pointing_error,
    preferred,
    projected,
    selectivity,
    speed_slope,
)
from experiments.bench.tuning.defined import direction_noise, order_p, undefined_direction, undefined_peak
from experiments.bench.tuning.preferences import direction_undefined, firing_angle, preferences, prefers_looming
from experiments.bench.tuning.probes import (
    CROSSES,
    CURVES,
    LOOMS,
    RECEDES,
    Family,
    Probe,
    curve_family,
    families,
)
from tests.helpers import user_files

TURNS = [22.5 * i for i in range(16)]


def probe_response(model, probe):
    """The response of a direction model to one probe."""
    clip = probe.clip.build(0)
    series = model(clip.shape).run(frame.luma for frame in clip)
    columns = {name: getattr(series, name) for name in ("hs", "vs", "looming")}
    return answer(curve_family("speed"), probe, "m", ("hs", "vs"), columns, moving(clip))


def made_up(turns, **of):
    """Answers of a model to gratings in these directions: ``of`` gives hs, vs, looming as functions of the angle."""
    return [
        TuningPoint("direction", "grating", "m", t, None, t, 0.0,
               *(of[s](math.radians(t)) if s in of else 0.0 for s in ("hs", "vs", "looming")))
        for t in turns
    ]  # fmt: skip


# --- pure functions ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("best", [0, 3, 8, 13])
def test_an_answer_to_one_direction_alone_is_fully_selective(best):
    turn_tuning = selectivity(TURNS, [float(i == best) for i in range(16)])
    assert turn_tuning.dsi == pytest.approx(1.0)
    assert turn_tuning.preferred_deg == pytest.approx(TURNS[best], abs=1e-9)


def test_the_same_answer_to_all_directions_is_not_selective():
    assert selectivity(TURNS, [0.3] * 16).dsi == pytest.approx(0.0, abs=1e-12)


def test_an_axis_is_no_direction():
    assert selectivity(TURNS, [abs(math.cos(math.radians(t))) for t in TURNS]).dsi == pytest.approx(0.0, abs=1e-12)


def test_a_cosine_rectified_has_pi_over_4():
    turn_tuning = selectivity(
        [360 * i / 720 for i in range(720)], [math.cos(math.radians(i / 2 - 90)) for i in range(720)]
    )
    assert turn_tuning.dsi == pytest.approx(math.pi / 4, abs=1e-4)
    assert turn_tuning.preferred_deg == pytest.approx(90.0)


def test_selectivity_is_of_the_shape_and_turns_with_the_response():
    rng = np.random.default_rng(0)
    r = rng.uniform(-1, 1, 16)
    base, louder, turned = (selectivity(TURNS, given) for given in (r, 7 * r, np.roll(r, 4)))
    assert louder.dsi == pytest.approx(base.dsi) == pytest.approx(turned.dsi)
    assert (turned.preferred_deg - base.preferred_deg) % 360 == pytest.approx(90.0)


def test_no_response_has_no_selectivity():
    assert selectivity(TURNS, [0.0] * 16) is None
    assert selectivity(TURNS, [-1.0] * 16) is None
    assert selectivity([], []) is None


def test_a_preferred_value_says_where_it_ends():
    x = [1.0, 2.0, 4.0, 8.0]
    assert preferred(x, [0.1, 0.9, 0.5, 0.2]) == Preferred(2.0, 2.0, False, False)
    assert str(preferred(x, [0.1, 0.9, 0.899, 0.2])) == "2..4"
    assert str(preferred(x, [0.1, 0.2, 0.5, 0.9])) == "≥8"
    assert str(preferred(x, [0.9, 0.895, 0.5, 0.1])) == "≤2"
    assert str(preferred(x, [1.0, 1.0, 1.0, 1.0])) == "flat"
    assert preferred(x, [0.0, -1.0, 0.0, 0.0]) is None
    assert preferred([], []) is None


def test_half_contrast_is_between_points_on_a_log_axis():
    assert half_contrast([0.01, 0.1, 1.0], [0.0, 0.25, 0.75]) == pytest.approx(0.1 * 10**0.25)
    assert half_contrast([0.1, 1.0], [0.9, 1.0]) is None  # lower than what was shown
    assert half_contrast([0.1, 1.0], [0.0, 0.0]) is None
    assert half_contrast([], []) is None


@pytest.mark.parametrize(("slope", "best"), [(0.0, lambda x: 4.0), (1.0, lambda x: 40.0 * x)])
def test_a_slope_tells_temporal_frequency_from_speed(slope, best):
    x = [1 / 40, 1 / 20, 1 / 10, 1 / 5]
    assert speed_slope(x, [best(v) for v in x]) == pytest.approx(slope)
    assert speed_slope(x, [best(x[0]), best(x[1]), math.nan, math.nan]) is None


def test_a_column_of_a_map_prefers_only_a_maximum_inside():
    y = [1.0, 2.0, 4.0, 8.0, 16.0]
    response = np.array([
        [0.0, 0.9, 0.00, 0.5, 0.5],
        [0.5, 0.5, 0.01, 1.0, 1.0],
        [1.0, 0.4, 0.02, 1.0, 1.0],
        [0.5, 0.3, 0.01, 0.2, 1.0],
        [0.1, 0.1, 0.00, 0.1, math.nan],
    ])  # fmt: skip
    inside, edge, weak, two, wide = best_rows(y, response)
    assert inside == 4.0 and two == pytest.approx(math.sqrt(8))
    assert all(map(math.isnan, (edge, weak, wide)))


def test_looming_is_preferred_where_it_beats_receding_and_crossing():
    """By more than 1 %: two potentials at their ceiling are equal."""

    def points(looms, recedes, crosses):
        values = zip((LOOMS, RECEDES, CROSSES), (looms, recedes, crosses), strict=True)
        return [TuningPoint("disc", line, "m", float(x), None, 0.0, r, 0.0, 0.0, r, spikes=int(10 * r))
                for line, responses in values for x, r in enumerate(responses)]  # fmt: skip

    given = points([0.4, 0.5, 0.5, 0.4], [0.1, 0.498, 0.1, 0.5], [0.2, 0.1, 0.5, 0.1])
    model_preferences = preferences(given, "m", ("looming",))
    assert (model_preferences.looming_by_potential, model_preferences.looming_by_spikes) == (0.25, 0.5)
    assert prefers_looming([], "m", lambda a: a.response) is None


def test_the_response_is_the_length_along_the_motion():
    assert projected(3.0, 4.0, math.atan2(4, 3)) == pytest.approx(5.0)
    assert projected(3.0, 4.0, math.atan2(4, 3) + math.pi) == pytest.approx(-5.0)
    assert projected(3.0, 4.0, math.atan2(3, -4)) == pytest.approx(0.0)


def test_a_response_is_of_the_second_half_of_what_moves():
    probe = Probe(curve_family("speed").probes[0].clip, "dark object", 1.0, direction_deg=180.0)
    series = {"hs": np.arange(10.0), "vs": np.zeros(10), "looming": np.array([0.9, *[0.5] * 4, 0.75, *[0.5] * 4])}
    frames = np.arange(2, 8)
    point = answer(curve_family("speed"), probe, "m", ("hs", "vs"), series, frames)
    assert (point.hs, point.response) == (6.0, pytest.approx(-6.0))
    assert answer(curve_family("speed"), probe, "m", ("looming",), series, frames).response == 0.25


def test_preferences_of_made_up_answers():
    ideal = made_up(TURNS, hs=math.cos, vs=math.sin)
    model_preferences = preferences(ideal, "m", ("hs", "vs"))
    assert model_preferences.prefers_deg % 360 == pytest.approx(0.0, abs=1e-9)
    assert model_preferences.dsi == pytest.approx(model_preferences.vs_dsi) == pytest.approx(math.pi / 4, abs=0.02)
    assert model_preferences.error_deg == pytest.approx(0.0, abs=1e-9)
    assert model_preferences.speed_px_s is None and model_preferences.temporal_hz is None
    assert pointing_error(made_up(TURNS, hs=lambda a: -math.cos(a), vs=lambda a: -math.sin(a)), "m", "grating") == 180.0
    looming = preferences(made_up(TURNS, looming=lambda a: 0.4), "m", ("looming",))
    assert looming.dsi == pytest.approx(0.0, abs=1e-12) and looming.error_deg is None
    # With a direction lost, an index would be wrong.
    assert preferences(ideal[1:], "m", ("hs", "vs")).dsi is None


def test_a_map_has_holes_where_clips_failed():
    given = [
        TuningPoint("frequency", "grating", "m", x, y, 0.0, x * y, 0, 0, 0) for x in (1.0, 2.0) for y in (3.0, 4.0)
    ]
    x, y, response = grid(given[1:], "m", "frequency")
    assert (x, y) == ([1.0, 2.0], [3.0, 4.0])
    np.testing.assert_array_equal(response, [[math.nan, 6.0], [4.0, 8.0]])


def test_curves_are_declared_once_a_point():
    assert families(["speed", "size", "speed"]) == (curve_family("speed"), curve_family("size"))
    assert families([]) == tuple(map(curve_family, CURVES))
    with pytest.raises(UsageError, match=r"--curve sped \(nearest: speed\): known are speed, "):
        families(["sped"])
    speed = curve_family("speed")
    with pytest.raises(ValueError, match="two probes at one point"):
        Family("twice", "", "curve", speed.x, (speed.probes[0], speed.probes[0]))


def test_the_curve_of_a_stimulus_shows_the_clips_of_the_family_with_its_values():
    assigned = {name: str(value) for name, value in {**probes.FRAME, **probes.OBJECT}.items() if name != "speed"}
    speeds = {probe.x: probe.clip for probe in curve_family("speed").probes}
    for motion, direction in (("rightward", 0.0), ("leftward", 180.0), ("downward", 90.0)):
        family = probes.of_stimulus(STIMULI["plain"], {**assigned, "motion": motion}, "plain.speed=15,60", 0)
        assert [(probe.x, probe.direction_deg) for probe in family.probes] == [(15.0, direction), (60.0, direction)]
        for probe in family.probes:
            expected = dataclasses.replace(speeds[probe.x].build(0).params, motion=motion)
            assert probe.clip.build(0).params == expected


def test_a_clip_moves_the_way_its_probe_says():
    for family in map(curve_family, CURVES):
        for probe in family.probes:
            clip = probe.clip.build(0)
            truth = clip[int(moving(clip)[0])].truth
            velocity = truth.velocity or truth.background_velocity
            turn = math.radians(probe.direction_deg)
            assert velocity.x * math.cos(turn) + velocity.y * math.sin(turn) == pytest.approx(math.hypot(*velocity))


# --- what is within the noise ----------------------------------------------------------------------------------------


def test_a_preferred_direction_is_defined_where_its_interval_is_narrower_than_the_step():
    assert undefined_direction([10.0, 12.0, 9.0, 11.0, 10.0], 22.5) == ""
    assert undefined_direction([350.0, 2.0, 355.0, 5.0, 358.0], 22.5) == "", "angles go round"
    assert "5 phases" in undefined_direction([310.0, 350.0, 347.0, 343.0, 320.0], 22.5)
    assert undefined_direction([40.0], 22.5) == "", "one phase tells of no noise"


def test_the_interval_of_a_direction_covers():
    rng, covered = np.random.default_rng(0), 0
    for _ in range(400):
        turns = rng.normal(90.0, 8.0, 5)
        covered += abs(turns.mean() - 90.0) <= direction_noise(turns)
    assert 0.92 <= covered / 400 <= 0.98


def test_a_peak_of_noise_is_not_defined_and_one_of_a_curve_is():
    x = np.linspace(-2, 2, 11)
    assert undefined_peak(np.exp(-(x**2))) == undefined_peak(x) == undefined_peak([0.4] * 9) == ""
    assert "random order" in undefined_peak([0.1, 0.9, 0.2, 0.8, 0.0, 0.9, 0.1, 0.7, 0.3])
    assert undefined_peak(np.add.outer(x, x)) == "" and undefined_peak([1.0, math.nan, 2.0]) == ""
    rng = np.random.default_rng(1)
    false = sum(order_p(rng.normal(size=(1, 10))) <= 0.05 for _ in range(40))
    assert false <= 6, "of noise one in twenty passes: more than 6 of 40 have a chance of 1 in 200"


def test_preferences_within_the_noise_are_left_out_with_the_reason():
    """A response to each direction that another phase of the grating gives to another direction."""
    given = []
    for repeat, best in enumerate((0.0, 67.5, 315.0, 22.5, 90.0)):
        given += [
            TuningPoint("direction", "grating", "m", t, None, t, 0.0, max(math.cos(math.radians(t - best)), 0.0),
                        0.0, 0.0, repeat=repeat)
            for t in TURNS
        ]  # fmt: skip
    model_preferences = preferences(given, "m", ("hs", "vs"))
    assert (
        model_preferences.dsi is None
        and model_preferences.prefers_deg is None
        and set(model_preferences.undefined) == {"dsi", "prefers_deg"}
    )
    assert "dsi: the preferred direction varies" in model_preferences.row()["not_defined"]
    same = [dataclasses.replace(a, repeat=r) for a in given if a.repeat == 0 for r in range(5)]
    assert preferences(same, "m", ("hs", "vs")).undefined == {}


def test_flow_has_no_preferred_direction_for_gratings_and_the_emd_has():
    for name, defined in (("flow", False), ("emd", True)):
        entry, given = MODELS[name], []
        for probe in curve_family("direction").probes:
            if probe.line == "grating":
                clip = probe.clip.build(probe.repeat)
                series = entry.build(clip.shape, entry.preset("offline")).run(frame.luma for frame in clip)
                columns = {system: getattr(series, system) for system in ("hs", "vs", "looming")}
                given.append(answer(curve_family("direction"), probe, "m", ("hs", "vs"), columns, moving(clip)))
        assert (direction_undefined(given, "m", ("hs", "vs")) == "") == defined, name


# --- approaches -------------------------------------------------------------------------------------------------------


def test_approaches_are_of_looming_models_alone():
    tuning_plan = tuning_run.plan(["dsnn", "lgmd1", "hybrid"], ["speed", "l-over-v"], [], 0)
    for showing, (_, family, _) in zip(tuning_plan.trials(), tuning_plan.numbered_probes(), strict=True):
        seen = [model.label for model in showing.models]
        assert seen == (["lgmd1", "hybrid"] if family.name == "l-over-v" else ["dsnn", "lgmd1", "hybrid"])
    assert {family.name for _, family, _ in tuning_run.plan(["emd"], [], [], 0).numbered_probes()} == set(CURVES) - {
        "l-over-v",
        "disc",
    }


def test_an_answer_to_an_approach_has_spikes_and_a_time_to_contact():
    family = curve_family("l-over-v")
    probe = next(p for p in family.probes if p.x == 0.16)
    contact = np.array([math.nan, 0.3, 0.2, 0.1, 0.0])
    series = {"hs": np.ones(5), "vs": np.zeros(5), "looming": np.array([0.5, 0.5, 0.7, 0.9, 0.5]),
              "looming_spikes": np.array([0, 0, 1, 1, 0])}  # fmt: skip
    point = answer(family, probe, "m", ("hs", "vs", "looming"), series, np.arange(1, 5), contact)
    assert (point.response, point.spikes, point.contact_s) == (pytest.approx(0.4), 2, 0.2)
    assert firing_angle([point], "m") == pytest.approx(2 * math.degrees(math.atan(0.16 / 0.2)))
    assert firing_angle([dataclasses.replace(point, contact_s=None)], "m") is None


# --- laws of the models -----------------------------------------------------------------------------------------------


def closed_form_hz(params):
    """The temporal frequency an EMD answers most to, whatever the wavelength.

    With H and D its high-pass and its delay as filters in discrete time, the mean response to a sine is proportional to
    |H|^2 Im(conj(D)), times sin of the phase between its arms, which the temporal frequency is not in.
    """
    f = np.linspace(0.05, params.fps / 2 - 0.05, 4000)
    z = np.exp(-2j * np.pi * f / params.fps)  # a delay of one frame
    high, low = (1 / (1 + tau * params.fps / 1000) for tau in (params.tau_hp, params.tau_lp))
    h, d = (1 - high) * (1 - z) / (1 - (1 - high) * z), low / (1 - (1 - low) * z)
    return float(f[np.argmax(np.abs(h) ** 2 * -d.imag)])


@pytest.mark.parametrize("tau_lp", [20.0, 50.0, 120.0])
def test_an_emd_is_tuned_to_temporal_frequency(tau_lp):
    params = EMDParams(tau_lp=tau_lp)
    probes = [p for p in curve_family("frequency").probes if round(1 / p.x) in (6, 16, 36, 72)]
    given = [probe_response(lambda shape: EMD(shape, params), probe) for probe in probes]
    x, y = sorted({p.x for p in probes}), sorted({p.y for p in probes})
    response = {(a.x, a.y): a.response for a in given}
    best = [max(y, key=lambda f: response[wave, f]) for wave in x]
    assert len(set(best)) == 1
    nearest = min(y, key=lambda f: abs(math.log(f / closed_form_hz(params))))
    assert abs(y.index(best[0]) - y.index(nearest)) <= 1


def test_a_linear_emd_points_where_the_motion_goes():
    params = EMDParams(log=False)
    probes = [p for p in curve_family("direction").probes if p.line == "grating" and p.repeat == 0]
    given = [
        dataclasses.replace(probe_response(lambda shape: EMD(shape, params), p), curve="direction") for p in probes
    ]
    assert pointing_error(given, "m", "grating") < 1.0
    cosine = selectivity(TURNS, [math.cos(math.radians(t)) for t in TURNS])
    for system, turn in (("hs", 0.0), ("vs", 90.0)):
        turn_tuning = selectivity(TURNS, [getattr(a, system) for a in given])
        assert turn_tuning.dsi == pytest.approx(cosine.dsi, abs=0.01)
        assert (turn_tuning.preferred_deg - turn + 180) % 360 - 180 == pytest.approx(0.0, abs=1.0)


def test_the_dsnn_answers_most_in_its_own_direction_and_turns_with_a_mirror():
    params = DSNNParams.offline()
    probes = [p for p in curve_family("direction").probes if p.line == "grating" and p.repeat == 0]
    given = [probe_response(lambda shape: DSNN(shape, params), probe) for probe in probes]
    by_turn = {a.direction_deg: a for a in given}
    for turn, system, sign in ((0.0, "hs", 1), (90.0, "vs", 1), (180.0, "hs", -1), (270.0, "vs", -1)):
        assert sign * getattr(by_turn[turn], system) > 0.0 and by_turn[turn].response > 0.0
    for system, turn in (("hs", 0.0), ("vs", 90.0)):
        for sign in (1, -1):  # against it lies what it answers to with its other sign
            turn_tuning = selectivity(list(by_turn), [sign * getattr(a, system) for a in given])
            assert abs((turn_tuning.preferred_deg - turn - 90 * (1 - sign) + 180) % 360 - 180) < 5.0
            assert turn_tuning.dsi > 0.6


def test_a_mirrored_object_turns_the_dsnn_s_sign():
    probe = next(p for p in curve_family("direction").probes if p.line == "dark object" and p.direction_deg == 0.0)
    clip = probe.clip.build(0)
    frames = [frame.luma for frame in clip]
    model = DSNN(clip.shape, DSNNParams.offline())
    window = moving(clip)
    seen, mirrored = (model.run(given).hs[window].mean() for given in (frames, [f[:, ::-1] for f in frames]))
    assert seen > 0.1 and mirrored < -0.1


def test_the_dsnn_answers_more_to_more_contrast():
    for line in curve_family("contrast").lines:
        probes = [p for p in curve_family("contrast").probes if p.line == line]
        given = [probe_response(lambda shape: DSNN(shape, DSNNParams.offline()), probe).response for probe in probes]
        assert all(np.diff(given) > 0), line


# --- the command ------------------------------------------------------------------------------------------------------


def csv_of(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_tune_measures_a_model_of_one_s_own_goes_on_and_refuses_other_curves(colias):
    (colias.folder / "my_model.py").write_text(user_files.MODEL)
    arguments = ("tune", "--only", "--model", "my_model.py", "--model", "dsnn", "--curve", "size", "--out", "out")
    done = colias(*arguments)
    assert done.returncode == 0, done.stderr
    out = colias.folder / "out"
    assert "gradient" in done.stdout and "size px" in done.stdout and "DSI" not in done.stdout.splitlines()[1]
    assert "out/size.png" in done.stdout
    rows = csv_of(out / "tuning.csv")
    sizes = sorted({float(row["size_px"]) for row in rows})
    assert tuple(sizes) == probes.SIZES_PX and len(rows) == 2 * len(sizes)
    assert {row["model"] for row in rows} == {"gradient", "dsnn"}
    assert [row["model"] for row in csv_of(out / "preferences.csv")] == ["gradient", "dsnn"]
    assert (out / "size.svg").stat().st_size > 1000 and not (out / "speed.png").exists()
    before = pq.read_table(out / "trials.parquet")
    again = colias(*arguments)
    assert again.returncode == 0 and "11 of them done already" in again.stderr
    assert pq.read_table(out / "trials.parquet").equals(before)
    tuning_plan = tuning_run.plan([str(colias.folder / "my_model.py"), "dsnn"], ["size"], ["gradient.gain=0.1"], 0)
    with open_workers(0) as pool, pytest.raises(UsageError, match=r"--set \w+\.gain is 0\.05 there and 0\.1 now"):
        tuning_run.run(tuning_plan, out, pool, Resources(0, quiet=True))


def test_numbers_do_not_depend_on_workers(tmp_path):
    tuning_plan = tuning_run.plan(["dsnn", "emd", "lgmd1"], ["speed"], [], 0)
    reports = []
    for workers in (1, 2):
        with open_workers(workers) as pool:
            reports.append(tuning_run.run(tuning_plan, tmp_path / str(workers), pool, Resources(workers, quiet=True)))
    assert reports[0].answers == reports[1].answers
    for name in ("tuning.csv", "preferences.csv", "speed.svg"):
        first, second = ((tmp_path / str(workers) / name).read_bytes() for workers in (1, 2))
        assert first == second
    assert json.loads((tmp_path / "1" / "run.json").read_text())["experiment"] == "tuning"
