"""What the figure must show: every repeat, every condition apart from every other."""

import itertools

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.text import Text

from experiments.bench.figures.palette import lanes
from experiments.bench.figures.plotting import End, label_ends, wrapped
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


@pytest.mark.parametrize("count", [2, 9, 20])
def test_a_key_has_each_model_and_each_condition_once(count):
    """Not a line for each pair of them: with many models those leave no room for the counts."""
    models = tuple(f"model {i}" for i in range(count))
    kinds = [(way, speed, 8.0) for way in ("rightward", "leftward") for speed in (2.0, 4.0)]
    figure = drawn(kinds, models=models)
    counts = figure.subfigs[0]
    legends = [*counts.legends, *(axes.get_legend() for axes in counts.axes if axes.get_legend() is not None)]
    words = [text.get_text() for legend in legends for text in legend.get_texts()]
    assert sorted(words) == sorted([*models, "rightward", "leftward"])


def test_a_panel_s_name_has_the_mark_of_its_model_s_line():
    figure = drawn(SPEEDS, models=("dsnn", "emd", "mine"))
    looks = {line.get_label(): (line.get_color(), line.get_marker()) for line in figure.axes[0].get_lines()
             if line.get_label() in series(figure.axes[0])}  # fmt: skip
    named = [axes.get_legend().legend_handles[0] for axes in figure.subfigs[1].axes if axes.get_legend()]
    assert {handle.get_label(): (handle.get_color(), handle.get_marker()) for handle in named} == looks


@pytest.mark.parametrize(
    "models", [("dsnn", "emd"), ("dsnn", "emd", "mine"), ("dsnn", "a model with a very long name")]
)
def test_a_line_has_its_name_at_its_end_or_in_the_key(models):
    figure = drawn(SPEEDS, models=models)
    counts = figure.axes[0]
    tints = {line.get_label(): line.get_color() for line in counts.get_lines() if line.get_label() in models}
    names = [text for text in counts.texts if text.get_text() in models]
    in_key = [text.get_text() for key in figure.subfigs[0].legends for text in key.get_texts()]
    assert sorted([*(text.get_text() for text in names), *in_key]) == sorted(models)
    assert bool(in_key) == (max(map(len, models)) > 10), "what fits stands at its line"
    assert {text.get_text(): text.get_color() for text in names} == ({} if in_key else tints)
    assert {text.xy[0] for text in names} <= {10.0}


def test_lines_that_end_close_together_keep_their_order_and_are_named_apart():
    axes = Figure().subplots()
    axes.set_ylim(0.0, 100.0)
    ends = [End(1.0, y, name, "black") for y, name in ((50.0, "b"), (49.0, "a"), (90.0, "c"))]
    assert label_ends(axes, ends, (4.0, 2.0))
    heights = {text.get_text(): text.xy[1] for text in axes.texts}
    assert heights["b"] - heights["a"] >= 100.0 * 8.0 / 72.0 / 2.0, "a line of type of 8 points on 2 inches"
    assert heights["c"] > heights["b"]
    assert not label_ends(axes, ends * 4, (4.0, 2.0)), "12 names at 3 heights are far from their lines"
    assert len(axes.texts) == 3, "nothing is drawn of what does not fit"


def test_looming_detectors_begin_a_row_and_have_a_scale_from_0_to_1():
    panels = drawn(SPEEDS, models=("dsnn", "lplc2", "emd"), looming=("lplc2",), lplc2=0.7).subfigs[1].axes
    shown = [axes for axes in panels if axes.get_visible()]
    assert [axes.get_legend().get_texts()[0].get_text() for axes in shown] == ["dsnn", "emd", "lplc2"]
    assert [axes.get_subplotspec().rowspan.start for axes in shown] == [0, 0, 1]
    assert [round(axes.get_ylim()[0]) for axes in shown] == [-1, -1, 0]
    assert [axes.get_ylabel().split()[0] for axes in shown if axes.get_ylabel()] == ["HS", "looming"]


def test_a_potential_beyond_1_is_not_cut_off_and_its_panel_has_numbers_of_its_own():
    _, panel, strong = drawn(SPEEDS, models=("dsnn", "flow"), strong=("flow",)).axes
    assert panel.get_ylim()[1] < 1.1 and strong.get_ylim()[1] > 3.0
    assert all(axes.yaxis.get_tick_params()["labelleft"] for axes in (panel, strong))


def test_the_threshold_s_words_keep_clear_of_the_traces():
    """The made-up traces of a strong potential lie along the top, those of a weak one below the middle."""
    _, weak, strong = drawn(SPEEDS, models=("dsnn", "mine"), strong=("mine",)).axes
    assert [text.get_va() for axes in (weak, strong) for text in axes.texts] == ["bottom", "bottom"]
    (low,) = drawn(SPEEDS, models=("lplc2",), looming=("lplc2",), lplc2=0.7).subfigs[1].axes
    assert low.texts[0].get_text() == "threshold 0.7"


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


def boxes(figure, monkeypatch):
    """The texts of a figure that are drawn, with their places on it; an axis keeps labels that it does not draw."""
    texts, draw = [], Text.draw
    monkeypatch.setattr(Text, "draw", lambda self, *args, **more: (texts.append(self), draw(self, *args, **more)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    visible = {id(text): text for text in texts if text.get_text().strip() and text.get_visible()}.values()
    return [(text.get_text(), text.get_window_extent(canvas.get_renderer())) for text in visible]


@pytest.mark.parametrize("models", [1, 2, 3, 20])
def test_no_two_texts_overlap(models, monkeypatch):
    text_boxes = boxes(drawn(SPEEDS, models=tuple(f"model {i}" for i in range(models))), monkeypatch)
    assert len(text_boxes) > 10
    overlapping = [
        (one, other) for (one, a), (other, b) in itertools.combinations(text_boxes, 2)
        if a.shrunk(0.98, 0.9).overlaps(b.shrunk(0.98, 0.9)) and a.width > 1 and b.width > 1
    ]  # fmt: skip
    assert not overlapping


def test_every_axis_says_what_it_is_with_a_unit():
    figure = drawn(SPEEDS, models=("a", "b"))
    assert (
        figure.subfigs[0].get_supxlabel().endswith("(cm/s)") and figure.subfigs[0].get_supylabel() == "spikes per trial"
    )
    assert {part.get_supxlabel() for part in figure.subfigs} >= {"bearing of the stimulus (degrees, right positive)"}


@pytest.mark.parametrize("inches", [0.6, 1.0, 1.4])
def test_a_label_of_settings_is_broken_at_its_commas_and_in_no_number(inches):
    text = "dsnn:n_con=1,k_sig=0.02,w_i=0.25"
    lines = wrapped(text, inches, 8).split("\n")
    assert len(lines) > 1 and "".join(lines) == text
    assert all(line.endswith(",") for line in lines[:-1]) or inches < 1.0  # a setting alone may be too long
    assert wrapped("a, b", 4.0, 8) == "a, b"
