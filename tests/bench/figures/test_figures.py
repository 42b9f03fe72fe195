"""What the figure must show: every repeat, every condition apart from every other."""

import pytest
from matplotlib.collections import PathCollection

from experiments.bench.figures.palette import lanes
from tests.helpers.condition_figures import drawn


def series(axes):
    return [line.get_label() for line in axes.get_lines() if not line.get_label().startswith("_")]


def test_every_repeat_is_a_dot_and_a_trace():
    counts, traces = drawn([("rightward", speed, 8.0) for speed in (2.0, 4.0, 6.0)]).axes
    dots = [c for c in counts.collections if isinstance(c, PathCollection)]
    assert sum(len(c.get_offsets()) for c in dots) == 9
    assert sum(len(line.get_xdata()) == 4 for line in traces.get_lines()) == 9


def test_conditions_beside_the_varied_one_stay_apart():
    """Two directions at two distances: four means at each speed, never one of all."""
    kinds = [(way, speed, far) for way in ("rightward", "leftward") for speed in (2.0, 4.0) for far in (5.0, 10.0)]
    counts, _ = drawn(kinds).axes
    assert series(counts) == ["rightward, 5 cm", "rightward, 10 cm", "leftward, 5 cm", "leftward, 10 cm"]
    means = [line for line in counts.get_lines() if line.get_label() in series(counts)]
    assert len({line.get_linestyle() for line in means}) == 4
    assert {tuple(line.get_xdata()) for line in means} == {(2.0, 4.0)}, "numbers stand at their place on the axis"


@pytest.mark.parametrize("count", [3, 6, 7, 12])
def test_no_two_levels_share_a_colour(count):
    counts, _ = drawn([("rightward", float(speed), 8.0) for speed in range(1, count + 1)]).axes
    dots = [c for c in counts.collections if isinstance(c, PathCollection)]
    assert len({tuple(c.get_facecolor()[0]) for c in dots}) == count


def test_a_single_trial_has_no_error_bar():
    counts, _ = drawn([("rightward", 2.0, 8.0), ("rightward", 4.0, 8.0)], repeats=1).axes
    assert not counts.containers


SPEEDS = [("rightward", speed, 8.0) for speed in (2.0, 4.0, 6.0, 10.0)]


@pytest.mark.parametrize("count", [1, 2, 3, 9, 20])
def test_every_model_has_a_key_and_a_panel_of_its_own(count):
    models = tuple(f"model {i}" for i in range(count))
    figure = drawn(SPEEDS, models=models)
    axes_shown = [axes for axes in figure.axes if axes.get_visible()]
    groups = lanes(models)
    counts, panels = axes_shown[: len(groups)], axes_shown[len(groups) :]
    names = [[text.get_text() for text in key.get_texts()] for axes in panels if (key := axes.get_legend())]
    assert names == ([[model] for model in models] if count > 1 else [])
    assert all(sum(len(line.get_xdata()) == 4 for line in axes.get_lines()) == 12 for axes in panels)
    if count > 1:
        assert [series(axes) for axes in counts] == groups, "a lane for each group"
        for axes, group in zip(counts, groups, strict=True):
            tints = {line.get_color() for line in axes.get_lines() if line.get_label() in models}
            assert len(tints) == len(group), "no two models of a lane have one colour"


def test_a_potential_beyond_1_is_not_cut_off_and_its_panel_has_numbers_of_its_own():
    _, panel, strong = drawn(SPEEDS, models=("dsnn", "flow"), strong=("flow",)).axes
    assert panel.get_ylim()[1] < 1.1 and strong.get_ylim()[1] > 3.0
    assert all(axes.yaxis.get_tick_params()["labelleft"] for axes in (panel, strong))


def test_at_a_word_series_stand_about_its_tick_and_a_single_trial_is_one_marker():
    """Of two directions that a model has, one is of one speed alone: it stands at its tick."""
    kinds = [("rightward", 4.0, 8.0), ("leftward", 4.0, 8.0), ("leftward", 6.0, 8.0)]
    counts = drawn(kinds, varies="direction", repeats=1).axes[0]
    slow, fast = (line.get_xdata() for line in counts.get_lines() if line.get_label() in series(counts))
    assert list(slow) == pytest.approx([0.0, 1.0 - (fast[0] - 1.0)]) and list(fast) > [1.0]
    assert not [c for c in counts.collections if isinstance(c, PathCollection)]


def test_an_axis_of_numbers_has_their_scale():
    counts = drawn(SPEEDS).axes[0]
    ticks = {tick.get_text(): place for tick, place in zip(counts.get_xticklabels(), counts.get_xticks(), strict=True)}
    assert ticks == {"2": 2.0, "4": 4.0, "6": 6.0, "10": 10.0}
    (line,) = (line for line in counts.get_lines() if len(line.get_xdata()) == 4)
    assert list(line.get_xdata()) == [2.0, 4.0, 6.0, 10.0]


def test_words_have_no_line_between_them():
    """Between approach and recession there is nothing."""
    counts = drawn([("rightward", 4.0, 8.0), ("leftward", 4.0, 8.0)], varies="direction", models=("a", "b")).axes[0]
    assert {line.get_linestyle() for line in counts.get_lines() if line.get_label() in ("a", "b")} == {"None"}


def test_a_model_without_spikes_is_named_and_not_drawn_at_zero():
    counts = drawn(SPEEDS, models=("a", "b"), b=None).axes[0]
    assert "b" in counts.get_title(loc="left") and series(counts) == [], "one series needs no key"
