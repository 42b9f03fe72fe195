"""Tuning curves: preferences of detectors made up by formulas, laws of clips and models, the run and its tables."""

import dataclasses
import itertools
import math

import numpy as np
import polars as pl
import pytest

from experiments.base.palette import TITLES
from experiments.draw.tuning import LABELS, MEASURES, draw
from experiments.judge import curves
from experiments.kinds import tuning as tune
from experiments.kinds.result import perform
from experiments.kinds.tuning import CROSSES, LOOMS, RECEDES
from experiments.store.asked import Asked
from experiments.store.workers import Workers

TURNS = 22.5 * np.arange(16)
NOT_GIVEN = {"model": "m", "direction_deg": 0.0, "response": 0.0, "hs": 0.0, "vs": 0.0, "looming": 0.0, "spikes": 0,
             "contact_s": None, "repeat": 0}  # fmt: skip


def planned(models, curves, seed=0):
    return tune.plan(Asked(kind="tuning", models=models, only=True, seed=seed, options={"curves": curves}))


def table(rows):
    return pl.DataFrame([NOT_GIVEN | row for row in rows], curves.points_schema(tune.AXES))


def gratings(turns=TURNS, best=0.0, repeat=0):
    """Responses of a detector whose HS prefers one direction, and whose VS prefers the one 90 degrees on."""
    return [
        {"curve": "direction", "line": "grating", "x": t, "direction_deg": t, "repeat": repeat,
         "hs": math.cos(math.radians(t - best)), "vs": math.sin(math.radians(t - best))}
        for t in turns
    ]  # fmt: skip


# --- preferences ------------------------------------------------------------------------------------------------------


def test_preferences_of_direction():
    row = tune.preferences(table(gratings()), "m", ("hs", "vs"))
    assert row["dsi"] == pytest.approx(row["vs_dsi"]) == pytest.approx(math.pi / 4, abs=0.02)
    assert row["prefers_deg"] == pytest.approx(0.0, abs=1e-9) and row["error_deg"] == pytest.approx(0.0, abs=1e-9)
    mirrored = tune.preferences(table(gratings(best=180.0)), "m", ("hs", "vs"))
    assert (mirrored["prefers_deg"], mirrored["error_deg"]) == pytest.approx((180.0, 180.0))
    assert row["speed_px_s"] is row["temporal_hz"] is row["slope"] is None, "they were not shown"
    lost = tune.preferences(table(gratings(TURNS[1:])), "m", ("hs", "vs"))
    assert lost["dsi"] is None, "with a direction lost, the index would be wrong"


def test_a_direction_that_varies_with_the_phase_is_not_defined():
    phases = [
        row for repeat, best in enumerate((0.0, 67.5, 315.0, 22.5, 90.0)) for row in gratings(TURNS, best, repeat)
    ]
    row = tune.preferences(table(phases), "m", ("hs", "vs"))
    assert row["dsi"] is row["prefers_deg"] is None and "dsi: " in row["not_defined"]
    same = [row for repeat in range(5) for row in gratings(TURNS, 67.5, repeat)]
    assert tune.preferences(table(same), "m", ("hs", "vs"))["prefers_deg"] == pytest.approx(67.5)


def test_looming_is_preferred_where_it_beats_receding_and_crossing():
    """By more than 1 %: two potentials at their ceiling are equal."""
    shown = {LOOMS: [0.4, 0.5, 0.5, 0.4], RECEDES: [0.1, 0.498, 0.1, 0.5], CROSSES: [0.2, 0.1, 0.5, 0.1]}
    rows = [{"curve": "disc", "line": line, "x": float(x), "response": r, "spikes": int(10 * r)}
            for line, responses in shown.items() for x, r in enumerate(responses)]  # fmt: skip
    row = tune.preferences(table(rows), "m", ("looming",))
    assert (row["looming_by_potential"], row["looming_by_spikes"]) == (0.25, 0.5)
    assert tune.preferences(table(rows[:4]), "m", ("looming",))["looming_by_spikes"] is None


def test_a_detector_that_fires_at_an_angle_does_so_at_every_l_over_v():
    rows = [{"curve": "l-over-v", "line": "dark looming", "x": s, "contact_s": s / math.tan(math.radians(15.0))}
            for s in (0.02, 0.08, 0.64)]  # fmt: skip
    assert tune.preferences(table(rows), "m", ("looming",))["fires_deg"] == pytest.approx(30.0)


def test_a_repeat_has_a_seed_of_its_own_and_a_spike_the_time_to_contact_of_its_frame():
    plan = planned(("lgmd1",), ("direction", "l-over-v"), 7)
    shown = list(zip(plan.declared, plan.trials, strict=True))
    assert {trial.seed - point["repeat"] for point, trial in shown} == {7} < {trial.seed for _, trial in shown}
    point, trial = next(job for job in shown if job[0]["line"] == "dark looming")
    clip = list(trial.condition.build(trial.seed))
    fired = max(frame for frame, shown in enumerate(clip) if shown.truth.time_to_contact_s) - 5
    spike = np.arange(len(clip)) == fired
    frames = pl.DataFrame({"looming_spikes": spike.astype(int), "looming": 0.5 + 0.25 * spike}).with_columns(
        pl.lit(0.0).alias("hs"), vs=0.0, trial=trial.index, model=pl.lit("lgmd1")
    )
    (row,) = tune.responses(dataclasses.replace(plan, declared=(point,), trials=(trial,)), frames).to_dicts()
    contact_s = pytest.approx(clip[fired].truth.time_to_contact_s)
    assert (row["contact_s"], row["response"], row["spikes"]) == (contact_s, 0.25, 1)


@pytest.mark.parametrize("curve", ["speed", "direction", "l-over-v", "frequency"])
def test_a_figure_has_the_points_of_each_model_at_their_places(curve):
    """Of several phases the first; of directions HS and VS of gratings; in a map shares of the largest response."""
    rng, along = np.random.default_rng(0), tune.CURVES[curve]
    lines = {"direction": ("grating", "square"), "frequency": ("grating",)}.get(curve, ("dark", "light"))
    y = (1.0, 2.0, 4.0, 8.0) if curve == "frequency" else (0.0,)
    rows = []
    for model, line, repeat, x, rate in itertools.product("ab", lines, (0, 1), (0.05, 0.2, 0.1), y):
        row = {"curve": curve, "model": model, "line": line, "repeat": repeat, "x": x, "y": rate}
        row |= dict(zip(("response", "hs", "vs"), rng.normal(size=3), strict=True))
        rows.append(row | {"spikes": int(rng.integers(9)), "contact_s": x * rng.uniform(1, 3)})
    figure, model = draw(table(rows), along, {}), ""
    assert {axes.get_xlabel() for axes in figure.axes if axes.images or axes.lines} - {""} == {LABELS[along[0]]}
    for axes in (axes for axes in figure.axes if axes.images or axes.lines):
        model = axes.get_title("left") or model
        own = [row | {"angle_deg": 2 * math.degrees(math.atan(row["x"] / row["contact_s"]))}
               for row in rows if (row["model"], row["repeat"]) == (model, 0)]  # fmt: skip
        across, up = axes.xaxis.get_major_formatter(), axes.yaxis.get_major_formatter()
        if axes.images:
            largest, shown = max(abs(row["response"]) for row in own), axes.images[0].get_array()
            shares = {(f"1/{1 / row['x']:.0f}", f"{row['y']:g}"): row["response"] / largest for row in own}
            for i, j in itertools.product(axes.get_xticks(), axes.get_yticks()):
                assert shown[j, i] == pytest.approx(shares[across(i), up(j)])
            continue
        column = {label: name for name, label in MEASURES.items()}.get(axes.get_ylabel(), "response")
        expected = {}
        for row in sorted(own, key=lambda row: row["x"]):
            values = {"hs": row["hs"], "vs": row["vs"]} if curve == "direction" else {row["line"]: row[column]}
            for name, value in values.items() if row["line"] != "square" else ():
                expected.setdefault(name, []).append([row["x"], value])
        drawn = {line.get_label(): line.get_xydata().tolist() for line in axes.lines if line.get_marker() == "o"}
        assert drawn == {TITLES.get(name, name): points for name, points in expected.items()} and model in "ab"
        assert [text.get_text() for legend in figure.legends for text in legend.get_texts()] == list(drawn)


# --- clips and models -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("curve", tune.CURVES)
def test_a_clip_is_one_point_and_moves_the_way_its_point_says(curve):
    shown = [(clip, point) for clip, point in tune.clips() if point["curve"] == curve]
    assert len({tuple(point.values()) for _, point in shown}) == len(shown) > 0
    for clip, point in shown:
        truth = next(frame.truth for frame in clip.build(0) if frame.truth.motion != "still")
        (x, y), turn = truth.velocity or truth.background_velocity, math.radians(point["direction_deg"])
        assert x * math.cos(turn) + y * math.sin(turn) == pytest.approx(math.hypot(x, y))


def test_approaches_are_shown_to_looming_models_alone():
    plan = planned(("dsnn", "lgmd1", "hybrid"), ("speed", "l-over-v"))
    for point, trial in zip(plan.declared, plan.trials, strict=True):
        expected = ["lgmd1", "hybrid"] if point["curve"] == "l-over-v" else ["dsnn", "lgmd1", "hybrid"]
        assert [model.label for model in trial.models] == expected


# --- the run ----------------------------------------------------------------------------------------------------------


def test_tables_read_back(tmp_path):
    plan = planned(("dsnn", "lgmd1"), ("size", "disc", "direction"))
    run = perform(plan, tmp_path, Workers(0, quiet=True))
    points = tune.responses(plan, run.frames)
    preferences = [tune.preferences(points, model.label, model.channels) for model in plan.models]
    assert run.failures.is_empty() and {path.stem for path in tmp_path.glob("*.png")} == {"size", "disc", "direction"}
    read = pl.read_csv(tmp_path / "tuning.csv", infer_schema_length=None)
    assert read.rows() == points.drop("x", "y").rows()
    assert read["size_px"].to_list() == [x if c == "size" else None for c, x in points["curve", "x"].rows()]
    rows = pl.read_csv(tmp_path / "preferences.csv").to_dicts()
    assert [row["model"] for row in rows] == ["dsnn", "lgmd1"]
    assert rows[1]["size_px_low"] == preferences[1]["size_px_low"] > 3.0
