"""The style of figures: colours apart in grey, means and intervals of the data, labels clear of each other, bytes."""

import re

import numpy as np
import polars as pl
import pytest
from matplotlib.figure import Figure

from experiments import ClipFigure
from experiments.base import palette
from experiments.draw import clips as clips_figure, style
from experiments.judge.tests import summarise
from tests.helpers.figure_rows import SPEEDS, clip_frames, clip_trials, drawn_robot, robot_rows

RENDERED = True


def test_means_intervals_and_trials_are_those_of_the_values():
    samples = [[3.0], [1.0, 2.0], [4.0, 5.0, 9.0]]
    axes = Figure().subplots()
    style.means(axes, [1.0, 2.0, 3.0], samples, palette.INK, "dsnn")
    (line,) = (line for line in axes.lines if line.get_label() == "dsnn")
    assert list(line.get_ydata()) == [3.0, 1.5, 6.0]
    dots = [list(line.get_ydata()) for line in axes.lines if line.get_markerfacecolor() == "none"]
    assert dots == samples
    (whisker,) = (line.get_xydata() for line in axes.lines if line.get_marker() == "None")
    expected = summarise(samples[2])
    assert tuple(whisker[:, 1]) == pytest.approx((expected.low, expected.high)), "and none of fewer than three"


@pytest.mark.parametrize(("values", "scale"), [([0.0, 1.0, 99.0], "linear"), ([0.0, 1.0, 101.0], "symlog")])
def test_an_axis_is_logarithmic_where_its_values_span_more_than_two_decades_and_shows_all(values, scale):
    axes = Figure().subplots()
    axes.plot(values, range(3))
    style.decades(axes, pl.Series(values))
    low, high = axes.get_xlim()
    assert axes.get_xscale() == scale and low <= 0.0 and high > max(values)


def test_labels_of_lines_that_end_together_do_not_collide(tmp_path):
    figure = Figure(figsize=(4.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=(0, 1), ylim=(0, 1))
    style.label_ends(axes, [(1.0, y, str(y), palette.INK) for y in (0.5, 0.51, 0.1, 0.52)])
    style.save(figure, tmp_path / "labels")
    placed = sorted(axes.texts, key=lambda text: text.get_window_extent().y0)
    assert [text.get_text() for text in placed] == ["0.1", "0.5", "0.51", "0.52"], "in the order of the lines"
    heights = [text.get_window_extent().y0 * 72.0 / figure.dpi for text in placed]
    assert min(np.diff(heights)) > style.SMALL


@pytest.mark.parametrize("count", [1, 3, 20])
@pytest.mark.parametrize("draw", [
    lambda models: drawn_robot("spikes", robot_rows(models, SPEEDS)),
    lambda models: drawn_robot("mechanism", robot_rows(models, SPEEDS)),
    *(lambda models, form=form: clip_figure(ClipFigure(form), models) for form in ("traces", "ranges", "background")),
])  # fmt: skip
def test_a_title_has_twelve_words_a_caption_two_lines_and_a_figure_one_legend_outside_its_panels(draw, count):
    figure = draw([f"model {place}" for place in range(count)])
    titles = [figure.get_suptitle(), *(axes.get_title("left") for axes in figure.axes)]
    assert all(len(re.sub(r"^[a-d]  ", "", title).split()) <= 12 for title in titles) and any(titles)
    assert figure._supxlabel.get_text().count("\n") < 2
    assert len(figure.legends) <= 1 and not any(axes.get_legend() for axes in figure.axes)


def clip_figure(figure, models):
    clips = [{"speed": speed, "grey": grey, "motion": motion, "background_speed": behind} for speed in (20.0, 60.0)
             for grey in (0.0, 255.0) for motion in ("rightward", "looming") for behind in (-60.0, 30.0)]  # fmt: skip
    trials = clip_trials(models, [*clips, {"object": "absent"}], 3)
    return clips_figure.draw(figure, trials, clip_frames(trials), dict.fromkeys(models, 0.1), "clips, seed 0")
