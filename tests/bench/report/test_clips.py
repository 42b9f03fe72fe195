"""Figures of clips: what is drawn are the table's numbers, and what their titles find is so."""

import itertools

import numpy as np
import polars as pl
import pytest

from experiments import ClipFigure
from experiments.bench.report.clips import course_finding, direction_finding, draw, with_responses
from tests.helpers.figure_rows import clip_frames, clip_trials, strength

RENDERED = True

MODELS = ("dsnn", "emd", "dsnn-on-blocked")
SPEEDS = [{"speed": speed, "grey": grey} for grey in (0.0, 100.0) for speed in (20.0, 60.0, 120.0)]
THRESHOLDS = {"dsnn": 0.16, "emd": None, "dsnn-on-blocked": 0.3}
PEAKS = ClipFigure("peaks", along="speed", lines="background_speed", panels="grey")
KINDS = ("traces", "peaks", "background", "ranges", "contrast")


def drawn(figure, trials, thresholds=THRESHOLDS):
    return draw(figure, trials, clip_frames(trials), thresholds, "clips")


def lines(figure):
    """Every line with numbers of the table, by its label and values."""
    found = [line for axes in figure.axes for line in axes.lines if not line.get_label().startswith("_")]
    return sorted((line.get_label(), *np.round(line.get_ydata(), 9)) for line in found)


@pytest.mark.parametrize("rising", range(2, 5))
def test_a_title_counts_the_curves_that_go_as_it_says(rising):
    """Of four seeds, so many rise with the speed: each seed is a curve, and their mean is none."""
    clips = [{"speed": speed} for speed in (20.0, 60.0, 120.0)]
    sign = pl.when(pl.col("repeat") < rising).then(1.0).otherwise(-1.0)
    trials = with_responses(clip_trials(["dsnn"], clips, 4)).with_columns(response=0.5 + sign * pl.col("speed") / 300.0)
    assert f" rises with speed of the object in {rising} of 4 " in course_finding(trials, "speed", "grey")


def test_the_direction_is_found_where_the_largest_potential_has_it():
    right, left = {"motion": "rightward"}, {"motion": "leftward"}
    trials = with_responses(clip_trials(["dsnn"], [right, right, left, {**right, "object": "absent"}]))
    assert " 2 of 3 " in direction_finding(trials, THRESHOLDS)
    assert " 0 of 3 " in direction_finding(trials.with_columns(peak_vs=1.0), THRESHOLDS), "VS is larger"
    both = trials.with_columns(peak_hs=0.5, trough_hs=-0.5)
    assert " 0 of 3 " in direction_finding(both, THRESHOLDS), "HS is as large either way"


def test_traces_are_means_of_the_frames_and_bands_their_range():
    trials = clip_trials(MODELS, [{"clip": "first"}, {"clip": "second"}], 3)
    table = clip_frames(trials).join(trials, on=["trial", "model"])
    panels = itertools.product(MODELS, ("first", "second"))
    axes = dict(zip(panels, drawn(ClipFigure("traces"), trials).axes, strict=True))
    for (model, clip), panel in axes.items():
        of_panel = table.filter(model=model, clip=clip).group_by("frame", maintain_order=True)
        expected = of_panel.agg(mean=pl.col("hs").mean(), low=pl.col("hs").min(), high=pl.col("hs").max())
        (line,) = (line for line in panel.lines if line.get_label() == "HS")
        assert list(line.get_ydata()) == pytest.approx(expected["mean"].to_list())
        assert list(line.get_xdata()) == pytest.approx([frame / 30.0 for frame in expected["frame"]])
        band = panel.collections[0].get_datalim(panel.transData)
        assert (band.y0, band.y1) == pytest.approx((expected["low"].min(), expected["high"].max()))
        level = THRESHOLDS[model]
        dashed = [line.get_ydata()[0] for line in panel.lines if line.get_linestyle() == "--"]
        assert dashed == ([level, -level] if level is not None else []), "a threshold that is None is not drawn"


def test_lines_of_curves_are_means_of_responses():
    trials = clip_trials(MODELS, SPEEDS, 3)
    expected = with_responses(trials).group_by("model", "grey", "speed").agg(pl.col("response").mean()).sort("speed")
    curves = [tuple(np.round(curve["response"], 9)) for _, curve in expected.group_by("model", "grey")]
    assert sorted(values for _, *values in lines(drawn(PEAKS, trials))) == sorted(map(list, curves))


@pytest.mark.parametrize(("unit", "speeds"), [("px/s", (-30.0, 60.0)), ("px/frame", (-1.0, 2.0))])
def test_a_background_s_speed_is_in_px_a_frame_whatever_its_unit(unit, speeds):
    """At 30 frames/s."""
    trials = clip_trials(["dsnn"], [{"speed_unit": unit, "background_speed": speed} for speed in speeds])
    (axes,) = drawn(ClipFigure("background"), trials).axes
    assert [1.0, 2.0] in [list(line.get_xdata()) for line in axes.lines if not line.get_label().startswith("_")]


def test_ranges_reach_from_the_smallest_to_the_largest_response():
    trials = clip_trials(MODELS, [*SPEEDS, {"object": "absent"}], 2)
    (axes,) = drawn(ClipFigure("ranges"), trials).axes
    bars = [line.get_xdata() for line in axes.lines if line.get_label() == "object crosses"]
    assert bars == [pytest.approx([strength(model) * 0.9, strength(model) * 1.1]) for model in MODELS]
    limits = {line.get_xdata()[0] for line in axes.lines if line.get_label() == "threshold"}
    assert limits == {0.16, 0.3}


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_rows_changes_nothing(kind):
    trials = clip_trials(MODELS, [*SPEEDS, {"object": "absent"}], 2)
    figure = PEAKS if kind == "peaks" else ClipFigure(kind)
    assert lines(drawn(figure, trials)) == lines(drawn(figure, trials.sample(fraction=1.0, shuffle=True, seed=1)))
