"""Figures of robot trials: marks are the table's numbers, and titles order no means whose intervals overlap."""

import itertools
import math
import re

import numpy as np
import polars as pl
import pytest
from scipy import stats

from experiments.draw import robot, style
from experiments.judge.tests import summarise
from experiments.show.excitation import BALANCED, CURVES, MOTION, PARTS, WHOLE
from tests.helpers.figure_rows import SPEEDS, bearings, drawn_robot, potential, robot_frames, robot_rows, threshold

RENDERED = True

MODELS = ("dsnn", "emd", "lgmd1")
SPEED = "speed_cm_s"
FAR = [{"distance_cm": far} for far in (5.0, 10.0, 15.0)]


def means(axes):
    """The lines of means of a panel: label -> values along the axis."""
    return {line.get_label(): list(line.get_ydata()) for line in axes.lines if not line.get_label().startswith("_")}


def separate(lower, higher):
    return summarise(lower).high < summarise(higher).low


@pytest.mark.parametrize("seed", range(40))
def test_a_title_orders_no_means_whose_intervals_overlap(seed):
    """From far apart to alike: every order that it names is one of intervals, reckoned anew."""
    rng = np.random.default_rng(seed)
    levels = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0][: 2 + seed % 5]
    centres = np.sort(rng.normal(0.0, (0.1, 3.0, 30.0)[seed % 3], len(levels)))[:: (-1) ** (seed % 2)]
    samples = [list(rng.normal(centre, 1.0, 3 + seed % 6)) for centre in centres]
    text = style.order(levels, samples, *style.unit(SPEED))
    steps = list(itertools.pairwise(samples))
    if "rises" in text or "falls" in text:
        assert all(separate(*step) if "rises" in text else separate(*step[::-1]) for step in steps)
        return
    assert not all(itertools.starmap(separate, steps))
    for word, named in re.findall(r"(largest|least) at ([\d.]+.cm/s(?: or [\d.]+.cm/s)*)", text):
        inside = {float(number) for number in re.findall(r"[\d.]+", named)}
        best = (max if word == "largest" else min)(samples, key=np.mean)
        for level, values in zip(levels, samples, strict=True):
            apart = separate(values, best) if word == "largest" else separate(best, values)
            assert (level in inside) != apart


@pytest.mark.parametrize(("count", "more"), [(1, 0), (2, 0), (1, 8)])
def test_a_title_finds_nothing_where_there_are_no_intervals(count, more):
    """Neither an order, nor in how many models; and not where one condition alone has an interval."""
    models = ["dsnn", "hybrid"]
    rows = robot_rows(models, SPEEDS, count) + robot_rows(models, SPEEDS[:1], more)
    text = robot.finding(robot.prepared(rows, None, SPEED), robot.COUNT, SPEED)
    assert not re.search(r"rises|falls|largest|least|\d of \d", " ".join(text))


def test_a_title_of_one_mean_has_its_interval():
    text, one = style.order([2.0], [[1.0, 2.0, 6.0]], "speed"), summarise([1.0, 2.0, 6.0])
    assert list(map(float, re.findall(r"-?[\d.]+", text))) == pytest.approx([one.value, one.low, one.high], rel=0.01)


@pytest.mark.parametrize("rising", range(3, 6))
def test_a_title_says_what_all_models_share_and_the_caption_counts_those_that_differ(rising):
    """Of five models, so many have more spikes at each higher speed and the others fewer."""
    models = [f"model {place}" for place in range(5)]
    rows = robot_rows(models, SPEEDS)
    for row in rows:
        row["spikes"] = row[SPEED] * (1 if models.index(row["model"]) < rising else -1)
    title, order = robot.finding(robot.prepared(rows, None, SPEED), robot.COUNT, SPEED)
    assert ("rises" in title) == (rising == 5) and "falls" not in title
    assert (order.count("rises"), order.count("falls")) == ((rising, 5 - rising) if rising < 5 else (0, 0))
    two = [row for row in rows if row["model"] in ("model 0", "model 4")]
    _, order = robot.finding(robot.prepared(two, None, SPEED), robot.COUNT, SPEED)
    named = re.findall(r"(model \d) (rises|falls)", order)
    assert named == ([("model 0", "rises"), ("model 4", "falls")] if rising < 5 else [])


APART = [{"direction": way, SPEED: speed, "distance_cm": far}
         for way in ("rightward", "leftward") for far in (5.0, 10.0) for speed in (2.0, 4.0, 8.0)][1:]  # fmt: skip
MOTIONS = [{"motion": motion, "direction": way} for motion, way in zip(("recession", "translation", "translation"),
           ("straight", "rightward", "leftward"), strict=True)]  # fmt: skip
WHY = (["seconds_in_view"], ["rate_in_view_hz"], ["peak_hs", "mean_hs_near_axis"])


def seen(row):
    """A trial with the size of its potential, either way; one of looming alone has no HS, and no peak of it."""
    if row["model"] == "lgmd1":
        return row | {"peak_hs": row["peak_looming"], "mean_hs_near_axis": None}
    return row | {"peak_hs": max(row["peak_hs"], -row["trough_hs"])}


def nearest(x, places):
    return min(places, key=lambda level: abs(places[level] - np.mean(x)))


@pytest.mark.parametrize(
    ("kind", "varies", "conditions", "others", "measures", "every"),
    [("spikes", SPEED, SPEEDS[::-1], (), [["spikes"]], 2), ("spikes", "motion", MOTIONS, (), [["spikes"]], 2),
     ("spikes", SPEED, APART, ("direction", "distance_cm"), [["spikes"]], 2),
     ("mechanism", "distance_cm", FAR, (), [["spikes"], *WHY], 1),
     ("mechanism", SPEED, SPEEDS, (), [["spikes", "spikes_in_window"], *WHY], 1)],
)  # fmt: skip
def test_dots_are_the_trials_at_their_levels_and_lines_the_means_of_each_other_condition(
    kind, varies, conditions, others, measures, every
):
    """Two directions at two distances are four rows of a model, never one line of all; the first lacks a level.

    The EMD does not spike, and LGMD1 has no HS: where a model has no number nothing is drawn.
    """
    repeats = 2 if varies == "motion" else 3
    rows = robot_rows(MODELS, conditions, repeats)
    figure = drawn_robot(kind, rows, varies)
    assert re.search(r"n = (\d+)( to)?", figure._supxlabel.get_text()).groups() == (str(repeats), None)
    ticks = figure.axes[-every].get_xticklabels()
    names = {tick.get_text().replace("\n", " "): tick.get_position()[0] for tick in ticks}
    levels = list(dict.fromkeys(tuple(row[name] for name in others) for row in rows))
    panels = itertools.product(MODELS, levels, measures)
    for axes, (model, level, columns) in zip(figure.axes[::every], panels, strict=True):
        curves, own = {}, [row for row in rows if (row["model"], *(row[name] for name in others)) == (model, *level)]
        for column, row in itertools.product(columns, map(seen, own)):
            level = "{direction} {motion}".format_map(row) if varies == "motion" else row[varies]
            if row[column] is not None:
                curve = curves.setdefault((column, *(row[name] for name in others)), {})
                curve.setdefault(level, []).append(row[column])
        places = names if varies == "motion" else {row[varies]: row[varies] for row in rows}
        curves = {key: sorted(of.items(), key=lambda one: places[one[0]]) for key, of in curves.items()}
        drawn = [line for line in axes.lines if not line.get_label().startswith("_")]
        for line, ((_, *other), of) in zip(drawn, curves.items(), strict=True):
            assert [nearest(x, places) for x in line.get_xdata()] == [level for level, _ in of]
            assert list(line.get_ydata()) == pytest.approx([np.mean(values) for _, values in of])
            beside = figure.axes[every * figure.axes[::every].index(axes)].get_ylabel()
            assert all(f"{name}".removesuffix(".0") in beside for name in other)
        dots = [line for line in axes.lines if line.get_label().startswith("_") and line.get_marker() == "o"]
        expected, tints = list(itertools.chain(*curves.values())), style.tints(places, varies)
        assert [(nearest(dot.get_xdata(), places), list(dot.get_ydata())) for dot in dots] == expected
        assert [dot.get_color() for dot in dots] == [tints[level] for level, _ in expected]
        whiskers = [tuple(line.get_ydata()) for line in axes.lines if line.get_marker() == "None"]
        intervals = [(one.low, one.high) for one in (summarise(values) for _, values in expected)]
        assert whiskers == (intervals if repeats >= 3 else []), "two trials have none"


def test_potentials_are_means_of_the_frames_at_the_table_s_bearings_and_bands_their_range():
    """Trials in which the stimulus is elsewhere at each frame are compared where they have the same bearing."""
    rows = robot_rows(MODELS, SPEEDS)
    for axes, model in zip(drawn_robot("spikes", rows).axes[1::2], MODELS, strict=True):
        ends = {}
        for place, line in enumerate(axes.lines[: len(SPEEDS)]):
            speed = line.get_label().split("\N{NO-BREAK SPACE}")[0]
            trials = [row["trial"] for row in rows if row["model"] == model and f"{row[SPEED]:g}" == speed]
            reach = {trial: (bearings(trial).min(), bearings(trial).max()) for trial in trials}
            x = line.get_xdata()
            assert (x[0], x[-1]) == (min(low for low, _ in reach.values()), max(high for _, high in reach.values()))
            of = [[potential(model, trial, at) for trial in trials if reach[trial][0] <= at <= reach[trial][1]]
                  for at in x]  # fmt: skip
            mean = np.array([np.mean(values) for values in of])
            assert line.get_ydata() == pytest.approx(mean)
            edge = axes.collections[place].get_paths()[0].vertices[:, 1]
            assert {*np.round(edge, 9)} == {*np.round([f(values) for values in of for f in (min, max)], 9)}
            ends[line.get_label()] = pytest.approx(mean[np.abs(mean).argmax()])
        dashed = {line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"}
        level = threshold(model)
        assert dashed == (set() if model == "emd" else {level, -level}), "a threshold that is None is not drawn"
        labels = {text.get_text(): text.xy[1] for text in axes.texts if "cm/s" in text.get_text()}
        assert labels == (ends if model == MODELS[0] else {})


POSE, TIME, NO_HS = "stimulus_bearing_deg", "time_s", ("peak_hs", "trough_hs", "mean_hs_near_axis", "hs")


@pytest.mark.parametrize(
    ("change", "lacking", "axis"),
    [({}, (), POSE), ({"motion": "approach"}, (), TIME), ({"observer_speed_cm_s": 2.0}, (), TIME),
     ({"observer_turn_deg_s": 5.0}, (), TIME), ({}, (POSE, "peak_looming", "looming"), TIME),
     ({}, (POSE, *NO_HS), TIME)],
)  # fmt: skip
def test_potentials_go_by_the_bearing_only_where_a_stimulus_crosses_before_a_still_observer(change, lacking, axis):
    """By the time in a log without poses, that has one channel alone."""
    rows = robot_rows(["lgmd1" if "hs" in lacking else "dsnn"], [SPEEDS[0] | change])
    frames = robot_frames(rows)
    known = frames.with_columns(pl.lit(None, pl.Float64).alias(name) for name in lacking if name in frames.columns)
    rows = [row | dict.fromkeys({*lacking} & {*row}) for row in rows]
    x = robot.draw("spikes", rows, known, SPEED, {}, "").axes[1].lines[0].get_xdata()
    assert (x[0], x[-1]) == (frames[axis].min(), frames[axis].max())


@pytest.mark.parametrize("angles", [(-10.0, 10.0), (-30.0, -20.0, -10.0, 0.0, 10.0, 20.0, 30.0)])
def test_excitation_is_drawn_as_in_its_table_with_the_interval_of_its_mean(angles):
    """Each condition has three panels below each other; five conditions stand side by side."""
    rows = robot_rows((WHOLE, BALANCED, *PARTS), [{"motion": "approach", "angle_deg": angle} for angle in angles])
    rise = np.hanning(12)
    curves = {name: (1.0 - 0.1 * place) * rise for place, name in enumerate(CURVES)}
    curves |= {f"{name}_sd": 0.1 * rise for name in CURVES}
    frames = pl.DataFrame({"time_s": np.arange(12) / 30, **curves, "firing": np.arange(12) % 4, "firing_w_i_1": 3})
    table = pl.DataFrame(rows, infer_schema_length=None).select(MOTION).unique(maintain_order=True)
    table = table.join(frames, how="cross").with_columns(pl.col(*curves) * (4.0 + pl.col("angle_deg") / 10))
    figure = drawn_robot("excitation", rows, "angle_deg", table.with_columns(n=3, w_i=0.7))
    axes = np.reshape(figure.axes, (-1, 3, min(len(angles), 5))).swapaxes(1, 2).reshape(-1, 3)
    names = ("excitation", "weighted_inhibition"), ("hs", "hs_w_i_1", "residue")
    for angle, panels in zip(angles, axes, strict=False):
        of = table.filter(angle_deg=angle)
        assert f"{abs(angle):g}" in panels[0].get_title("left")
        for panel, columns in zip(panels, names, strict=False):
            for line, band, name in zip(panel.lines, panel.collections, columns, strict=False):
                mean, error = of[name].to_numpy(), of[f"{name}_sd"].to_numpy() / math.sqrt(3)
                np.testing.assert_allclose(line.get_xydata(), np.column_stack([of["time_s"], mean]))
                low, high = stats.t.interval(0.95, 2, mean, error + 1e-15)
                limits = band.get_datalim(panel.transData)
                assert (limits.y0, limits.y1) == pytest.approx((low.min(), high.max()), abs=1e-9)
        dashed = [{line.get_ydata()[0] for line in panel.lines if line.get_linestyle() == "--"} for panel in panels]
        assert dashed == [set(), {threshold(WHOLE), -threshold(WHOLE)}, set()]
        (line,), (area,) = panels[2].lines, panels[2].collections
        assert {*line.get_ydata()} == {1.0} and area.get_datalim(panels[2].transData).y1 == 1.0
        assert {*np.round(3 * area.get_paths()[0].vertices[:, 1], 9)} == {0.0, 1.0, 2.0, 3.0}
    counts = drawn_robot("excitation", rows, "angle_deg")
    assert len(counts.axes) == 4, "where there is no such table, counts and potentials of the two whole networks"


def test_the_paper_s_panels_show_the_first_model_of_its_four_experiments():
    angles = [{"motion": "approach", "angle_deg": angle} for angle in (-30.0, -15.0, 0.0, 15.0, 30.0)]
    runs = {"angular-recession": robot_rows(MODELS, angles[1:]), "clean": [], "speed": robot_rows(MODELS, SPEEDS)}
    runs |= {"angular-approach": robot_rows(MODELS, angles), "distance": pl.DataFrame(robot_rows(MODELS, FAR))}
    for names in (list(runs), ["speed"]):
        figure = robot.panels({name: runs[name] for name in names})
        panels = [axes for axes in figure.axes if axes.get_visible()]
        for axes, (name, column) in zip(panels, robot.PAPER.items(), strict=len(names) > 1):
            levels = {}
            for row in pl.DataFrame(runs[name]).filter(model=MODELS[0]).to_dicts():
                levels.setdefault(row[column], []).append(row["spikes"])
            (line,) = (line for line in axes.lines if line.get_label() == "spikes")
            assert [*line.get_xdata()] == [*levels] and [*line.get_ydata()] == [*map(np.mean, levels.values())]
            assert axes.get_xlabel() == style.axis(column) and name.split("-")[-1] in axes.get_title("left").lower()
