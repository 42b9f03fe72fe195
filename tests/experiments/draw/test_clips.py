"""Figures of clips: what is drawn are the table's numbers, and what their titles find is so."""

import itertools
import re

import numpy as np
import polars as pl
import pytest

from experiments import ClipFigure
from experiments.draw.clips import course_finding, direction_finding, draw, with_responses
from tests.helpers.figure_rows import clip_frames, clip_trials, threshold

RENDERED = True

MODELS = ("hybrid", "dsnn", "emd", "lgmd1")
THRESHOLDS = {model: None if model == "emd" else threshold(model) for model in MODELS}
CHANNELS = {"hybrid": ["HS", "VS", "looming"], "lgmd1": ["looming"]}


def drawn(figure, trials):
    """The figure, from rows in any order."""
    given = (table.sample(fraction=1.0, shuffle=True, seed=1) for table in (trials, clip_frames(trials)))
    return draw(figure, *given, THRESHOLDS, "clips")


def panels(figure):
    """(Name of the row, title of the column) -> axes, as one reads them."""
    names, titles, found = {}, {}, {}
    for axes in (axes for axes in figure.axes if axes.get_visible()):
        row, column = axes.get_subplotspec().rowspan.start, axes.get_subplotspec().colspan.start
        names.setdefault(row, axes.get_ylabel().partition("\n")[0])
        titles[column] = axes.get_title("left") or titles[column]
        found[names[row], titles[column]] = axes
    return found


def dashed(axes):
    return [line.get_ydata()[0] for line in axes.lines if line.get_linestyle() == "--"]


def response(row):
    if row["model"] == "lgmd1":
        return row["peak_looming"]
    channel = "vs" if row["motion"] in ("upward", "downward") else "hs"
    return max(row[f"peak_{channel}"], -row[f"trough_{channel}"])


@pytest.mark.parametrize("rising", range(2, 5))
def test_a_title_counts_the_curves_that_go_as_it_says(rising):
    """Of four seeds, so many rise with the speed: each seed is a curve, and their mean is none."""
    clips = [{"speed": speed} for speed in (20.0, 60.0, 120.0)]
    sign = pl.when(pl.col("repeat") < rising).then(1.0).otherwise(-1.0)
    trials = with_responses(clip_trials(["dsnn"], clips, 4)).with_columns(response=0.5 + sign * pl.col("speed") / 300.0)
    title, order = course_finding(trials, "speed", "grey")
    assert f" rises with speed of the object in {rising} of 4 " in order and ("rises" in title) == (rising == 4)


def test_the_direction_is_found_where_the_largest_potential_has_it():
    right, left = {"motion": "rightward"}, {"motion": "leftward"}
    trials = with_responses(clip_trials(["dsnn"], [right, right, left, {**right, "object": "absent"}]))
    assert " 2 of 3 " in direction_finding(trials, THRESHOLDS)
    assert " 0 of 3 " in direction_finding(trials.with_columns(peak_vs=1.0), THRESHOLDS), "VS is larger"
    both = trials.with_columns(peak_hs=0.5, trough_hs=-0.5)
    assert " 0 of 3 " in direction_finding(both, THRESHOLDS), "HS is as large either way"


@pytest.mark.parametrize(("models", "count"), [(MODELS, 2), (MODELS[:2], 16)])
def test_traces_are_means_of_the_frames_and_bands_their_range(models, count):
    """Sixteen clips take two rows of panels."""
    trials = clip_trials(models, [{"clip": f"clip {n}", "fps": (30.0, 60.0)[n % 2]} for n in range(count)], 3)
    table = clip_frames(trials).join(trials, on=["trial", "model"])
    axes = panels(drawn(ClipFigure("traces"), trials))
    assert axes.keys() == set(itertools.product(models, trials["clip"]))
    for (model, clip), panel in axes.items():
        lines = [line for line in panel.lines if line.get_linestyle() == "-"]
        assert [line.get_label() for line in lines] == CHANNELS.get(model, ["HS", "VS"])
        for line, band in zip(lines, panel.collections, strict=True):
            channel = line.get_label().lower()
            rows = [of[channel].to_list() for _, of in table.filter(model=model, clip=clip).group_by("trial")]
            np.testing.assert_allclose(line.get_ydata(), np.mean(rows, axis=0), atol=1e-12)
            np.testing.assert_allclose(line.get_xdata(), np.arange(12) / (60.0 if int(clip[5:]) % 2 else 30.0))
            limits = band.get_datalim(panel.transData)
            assert (limits.y0, limits.y1) == pytest.approx((np.min(rows), np.max(rows)))
        level, signed = THRESHOLDS[model], model != "lgmd1"
        assert dashed(panel) == ([level, -level][: 1 + signed] if level else []), "one that is None is not drawn"


GREYS = (0.0, 128.0, 255.0)
SHOWN = [
    {"speed": speed, "grey": grey, "background_speed": behind, "motion": motion}
    for grey in GREYS
    for behind in (-60.0, 30.0)
    for speed in (20.0, 60.0)
    for motion in ("leftward", "upward", "receding")
]
SHOWN += [{"object": "absent", "background_speed": behind} for behind in (-60.0, 30.0)]
PARTS = {
    "peaks": [({"object": "dark", "grey": grey}, "speed", "background_speed") for grey in GREYS],
    "contrast": [({"object": "dark"}, "speed", "grey"), ({"object": "dark"}, "grey", "speed")],
    "background": [({"object": "absent"}, "px", "shade"), ({"depth": True}, "px", "shade"),
                   *(({"depth": False, "grey": grey}, "px", "speed") for grey in GREYS[::2])],
}  # fmt: skip


@pytest.mark.parametrize("unit", ["px/s", "px/frame"])
@pytest.mark.parametrize("kind", PARTS)
def test_curves_are_means_of_responses_at_their_levels(kind, unit):
    """A row of panels for each model, a panel for each part, a line for each level; at 30 frames/s."""
    trials = clip_trials(MODELS, [clip | {"speed_unit": unit} for clip in SHOWN], 3)
    figure = drawn(ClipFigure(kind), trials)
    assert re.findall(r"n = (\d+)", figure._supxlabel.get_text()) == ["3"]
    present, px = pl.col("object") == "dark", pl.col("background_speed").abs() / (30.0 if unit == "px/s" else 1.0)
    table = trials.with_columns(response=pl.Series(map(response, trials.to_dicts())), px=px,
                                shade=pl.when(present).then("grey"),
                                depth=pl.when(present).then(pl.col("motion") == "receding"))  # fmt: skip
    cells = {(model, title[0]): (axes, title.replace("\n", " ")) for (model, title), axes in panels(figure).items()}
    assert cells.keys() == set(itertools.product(MODELS, "abcd"[: len(PARTS[kind])]))
    for (model, letter), (axes, title) in cells.items():
        where, along, by = PARTS[kind]["abcd".index(letter)]
        assert f" {where.get('grey', 0.0):g}:" in title or "grey" not in where
        lines = [line for line in axes.lines if line.get_linestyle() == "-" and line.get_marker() == "o"]
        for line, of in zip(lines, table.filter(model=model, **where).sort(by, along).partition_by(by), strict=True):
            means = [(at[along][0], sum(at["response"]) / len(at)) for at in of.partition_by(along)]
            assert of[by][0] is None or f"{of[by][0]:g}" in re.split(r"[ ,]+", line.get_label())
            np.testing.assert_allclose(line.get_xydata(), means)
        labels = {
            text.get_text(): text.xy
            for text in axes.texts
            if text.get_text() not in ("", "response") and text.get_text()[:1] != "T"
        }
        ends = {line.get_label(): tuple(line.get_xydata()[-1]) for line in lines if line.get_label()[0] != "_"}
        assert labels == (ends if axes.get_subplotspec().rowspan.start == 0 else {})
        assert dashed(axes) == ([THRESHOLDS[model]] if THRESHOLDS[model] else [])


def test_ranges_reach_from_the_smallest_to_the_largest_response_of_each_model():
    trials = clip_trials(MODELS, SHOWN, 2)
    whole = drawn(ClipFigure("ranges"), trials)
    (axes,) = whole.axes
    names = {tick.get_position()[1]: tick.get_text() for tick in axes.get_yticklabels()}
    found = {}
    for line in axes.lines:
        kind = "dots" if line.get_marker() == "o" else line.get_label()
        found.setdefault((names[round(np.mean(line.get_ydata()))], kind), []).extend(sorted(line.get_xdata()))
    above = []
    for model in MODELS:
        rows = trials.filter(model=model).to_dicts()
        alone, crossing = (sorted(response(row) for row in rows if row["motion"] != "receding" and
                                  (row["object"] == "absent") == absent) for absent in (True, False))  # fmt: skip
        assert found.pop((model, "object crosses")) == [crossing[0], crossing[-1]]
        assert found.pop((model, "background alone")) == [alone[0], alone[-1]]
        assert sorted(found.pop((model, "dots"))) == sorted(crossing + alone)
        assert found.pop((model, "threshold"), [None] * 2) == [THRESHOLDS[model]] * 2
        above += [one > alone[-1] for one in crossing]
    words = whole.get_suptitle() + whole._supxlabel.get_text()
    assert not found and list(map(int, re.search(r"(\d+) of\s(\d+)\strials", words).groups())) == [
        sum(above),
        len(above),
    ]
