"""Figures of robot trials: marks are the table's numbers, and titles order no means whose intervals overlap."""

import itertools
import math
import re

import numpy as np
import polars as pl
import pytest
from matplotlib.colors import to_rgb
from scipy import stats

from experiments.bench.report import findings, robot
from experiments.bench.sources.excitation import BALANCED, CURVES, MOTION, WHOLE
from experiments.bench.stats.tests import summarise
from tests.helpers.figure_rows import SPEEDS, drawn_robot, robot_frames, robot_rows

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
    text = findings.order(levels, samples, *findings.unit(SPEED))
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


def test_a_leftward_potential_is_as_large_as_its_mirror_image():
    rows = robot_rows(["dsnn"], SPEEDS, 1)
    mirrored = [{**row, "peak_hs": -row["trough_hs"], "trough_hs": -row["peak_hs"]} for row in rows]
    there, back = (robot.prepared(of, None, SPEED)["peak"].to_list() for of in (rows, mirrored))
    assert there == back == [row["peak_hs"] for row in rows]


def test_a_model_of_looming_alone_has_the_peak_of_looming_and_no_hs_near_the_axis():
    rows = robot_rows(["lgmd1"], SPEEDS, 1)
    table = robot.prepared(rows, robot_frames(rows), SPEED)
    assert table["peak"].to_list() == [row["peak_looming"] for row in rows]
    assert table["mean_hs_near_axis"].null_count() == len(rows)


@pytest.mark.parametrize("count", [1, 2])
def test_a_title_finds_nothing_where_there_are_no_intervals(count):
    """Neither an order, nor in how many models."""
    rows = robot.prepared(robot_rows(["dsnn", "hybrid"], SPEEDS, count), None, SPEED)
    text = robot.finding(rows, robot.COUNT, SPEED)
    assert not re.search(r"rises|falls|largest|least|\d of \d", text)


@pytest.mark.parametrize("rising", range(3, 6))
def test_a_title_counts_the_models_that_go_as_it_says(rising):
    """Of five models, so many have more spikes at each higher speed and the others fewer."""
    models = [f"model {place}" for place in range(5)]
    rows = robot_rows(models, SPEEDS)
    for row in rows:
        row["spikes"] = row[SPEED] * (1 if models.index(row["model"]) < rising else -1)
    text = robot.finding(robot.prepared(rows, None, SPEED), robot.COUNT, SPEED)
    assert f"rises with speed in {rising} of 5 models" in text
    assert ("falls" in text) == (rising < 5), "nothing is hidden"


APART = [{"direction": way, SPEED: speed, "distance_cm": far}
         for way in ("rightward", "leftward") for far in (5.0, 10.0) for speed in (2.0, 4.0)]  # fmt: skip
MEASURES = (["spikes", "spikes_in_window"], ["seconds_in_view"], ["rate_in_view_hz"], ["peak_hs", "mean_hs_near_axis"])


@pytest.mark.parametrize(
    ("kind", "conditions", "measures", "every"),
    [("spikes", SPEEDS, [["spikes"]], 2), ("spikes", APART, [["spikes"]], 2), ("mechanism", SPEEDS, MEASURES, 1)],
)
def test_lines_are_means_of_the_trials_of_each_other_condition_by_itself(kind, conditions, measures, every):
    """Two directions at two distances are four lines, never one of all."""
    models = ("dsnn", "hybrid")
    rows = robot_rows(models, conditions)
    panels = drawn_robot(kind, rows).axes[::every]
    for axes, (model, columns) in zip(panels, itertools.product(models, measures), strict=True):
        table = pl.DataFrame(rows, infer_schema_length=None).filter(model=model)
        by_speed = table.group_by("direction", "distance_cm", SPEED, maintain_order=True).agg(pl.mean(*columns))
        lines = by_speed.partition_by("direction", "distance_cm", maintain_order=True)
        expected = [line[column].to_list() for column in columns for line in lines]
        assert list(means(axes).values()) == [pytest.approx(values) for values in expected]


def test_numbers_stand_to_scale_and_a_model_without_a_threshold_has_no_counts():
    dsnn, _, emd, _ = drawn_robot("spikes", robot_rows(["dsnn", "emd"], SPEEDS)).axes
    (line,) = (line for line in dsnn.lines if line.get_label() == "spikes")
    assert list(line.get_xdata()) == [2.0, 4.0, 6.0, 8.0, 10.0] and not emd.lines


def test_potentials_are_means_of_the_frames_at_the_table_s_bearings_and_bands_their_range():
    rows = robot_rows(MODELS, SPEEDS)
    frames = robot_frames(rows)
    for axes, model in zip(drawn_robot("spikes", rows).axes[1::2], MODELS, strict=True):
        potential = "looming" if model == "lgmd1" else "hs"
        for place, (label, values) in enumerate(means(axes).items()):
            trials = [row["trial"] for row in rows if f"{row[SPEED]:g}" == label.split("\N{NO-BREAK SPACE}")[0]]
            table = frames.filter(pl.col("trial").is_in(trials), model=model)
            of_frame = table.group_by("stimulus_bearing_deg").agg(
                mean=pl.col(potential).mean(), low=pl.col(potential).min(), high=pl.col(potential).max()
            ).sort("stimulus_bearing_deg")  # fmt: skip
            assert values == pytest.approx(of_frame["mean"].to_list())
            assert list(axes.lines[place].get_xdata()) == pytest.approx(of_frame["stimulus_bearing_deg"].to_list())
            edge = axes.collections[place].get_paths()[0].vertices[:, 1]
            assert {*np.round(edge, 9)} == {*np.round([*of_frame["low"], *of_frame["high"]], 9)}
        dashed = {line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"}
        assert dashed == (set() if model == "emd" else {0.16}), "a threshold that is None is not drawn"


def test_excitation_is_drawn_as_in_its_table_with_the_interval_of_its_mean():
    rows = robot_rows((WHOLE, BALANCED), [{"motion": "approach", "angle_deg": angle} for angle in (-10.0, 10.0)])
    rise = np.hanning(12)
    curves = {name: (1.0 - 0.1 * place) * rise for place, name in enumerate(CURVES)}
    curves |= {f"{name}_sd": 0.1 * rise for name in CURVES}
    frames = pl.DataFrame({"sim_time_s": np.arange(12) / 30, **curves})
    table = pl.DataFrame(rows, infer_schema_length=None).select(MOTION).unique(maintain_order=True)
    table = table.join(frames, how="cross").with_columns(pl.col(*curves) * (2.0 + pl.col("angle_deg").sign()))
    table = table.with_columns(n=3, w_i=0.7, firing=0, firing_w_i_1=0)
    axes = drawn_robot("excitation", rows, "angle_deg", table).axes
    names = ("excitation", "weighted_inhibition"), ("hs", "hs_w_i_1", "residue")
    for place, panel in enumerate(axes[:4]):
        of = table.filter(angle_deg=(-10.0, 10.0)[place % 2])
        for line, band, name in zip(panel.lines, panel.collections, names[place // 2], strict=False):
            mean, error = of[name].to_numpy(), of[f"{name}_sd"].to_numpy() / math.sqrt(3)
            assert line.get_ydata() == pytest.approx(mean)
            low, high = stats.t.interval(0.95, 2, mean, error + 1e-15)
            limits = band.get_datalim(panel.transData)
            assert (limits.y0, limits.y1) == pytest.approx((low.min(), high.max()), abs=1e-9)


def test_the_paper_s_panels_show_the_first_model_of_its_four_experiments():
    angles = [{"motion": "approach", "angle_deg": angle} for angle in (-30.0, -15.0, 0.0, 15.0, 30.0)]
    runs = {"clean": [], "speed": robot_rows(MODELS, SPEEDS), "distance": pl.DataFrame(robot_rows(MODELS, FAR))}
    runs |= {f"angular-{kind}": robot_rows(MODELS, angles) for kind in ("approach", "recession")}
    spikes = np.reshape([row["spikes"] for row in runs["speed"] if row["model"] == "dsnn"], (5, 3)).mean(axis=1)
    for names, shown in ((list(runs), [5, 3, 5, 5]), (["speed"], [5])):
        panels = [means(axes) for axes in robot.panels({name: runs[name] for name in names}).axes if axes.get_visible()]
        assert [len(panel["spikes"]) for panel in panels] == shown and panels[0]["spikes"] == pytest.approx(spikes)


@pytest.mark.parametrize("levels", [(-30.0, -15.0, 0.0, 15.0, 30.0), (-5.0, 2.5)])
def test_signed_levels_diverge_blue_to_the_left_and_red_to_the_right(levels):
    tints = {level: to_rgb(tint[:3] if level else tint) for level, tint in robot.tints(levels).items()}
    for level, (red, _, blue) in tints.items():
        assert np.sign(red - blue) == np.sign(level)
    assert len(set(tints.values())) == len(levels)


@pytest.mark.parametrize("known", ["hs", "looming"])
def test_a_log_without_poses_and_with_one_channel_is_drawn_over_time(known):
    unknown = ("peak_hs", "trough_hs", "mean_hs_near_axis") if known == "looming" else ("peak_looming",)
    rows = robot_rows(["dsnn" if known == "hs" else "lgmd1"], SPEEDS)
    nothing = {name: pl.lit(None, pl.Float64) for name in ("hs", "looming", "stimulus_bearing_deg") if name != known}
    frames = robot_frames(rows).with_columns(**nothing)
    logged = [{**row, **dict.fromkeys(unknown), "provenance": "measured"} for row in rows]
    title = robot.title("speed", "leaves", logged, {}, open_loop=False)
    assert title.endswith("measured")
    _, traces = robot.draw("spikes", logged, frames, SPEED, {"dsnn": 0.16}, title).axes
    for line in traces.lines[:5]:
        assert list(line.get_xdata()) == pytest.approx(frames["sim_time_s"].unique().sort().to_list())
