"""The figure of single edges: traces, and bars of what is left of HS, are those of the tables."""

import numpy as np
import pytest

import experiments
from experiments import Clip, Figure, OfflineExperiment
from experiments.bench import registry
from experiments.bench.clips.claims import find
from experiments.bench.clips.edges_figure import CASES, shares

SMALL = (("rows", 24), ("columns", 48), ("rest_s", 0.1))
MODELS = ("dsnn", "dsnn-on-blocked", "dsnn-off-blocked")
CLIPS = [
    Clip(f"{polarity} {motion}", "edge", (*SMALL, ("polarity", polarity), ("motion", motion)))
    for polarity in ("off", "on")
    for motion in ("rightward", "leftward")
]
SMALL_EDGES = OfflineExperiment("small-edges", "small edges", CLIPS, MODELS, figure=Figure("edges"))


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    out = tmp_path_factory.mktemp("edges") / "out"
    return experiments.run(SMALL_EDGES, recordings=False, quiet=True, workers=0, out=out)


def panels(run):
    """Of each polarity: icons, HS to the right and to the left, bars."""
    axes = run.figure().axes
    return {"off": axes[:4], "on": axes[4:]}


def test_the_experiment_that_ships_is_drawn_so():
    assert registry.find("edges").figure.kind == "edges"


def test_traces_are_those_of_the_frames(run):
    rows, frames = run.trials.to_pylist(), run.frames.to_pylist()
    for polarity, (_, rightward, leftward, _) in panels(run).items():
        for axes, motion in ((rightward, "rightward"), (leftward, "leftward")):
            drawn = {line.get_label(): line for line in axes.get_lines() if line.get_label() in MODELS}
            for row in (row for row in rows if (row["polarity"], row["motion"]) == (polarity, motion)):
                row_frames = [f for f in frames if (f["trial"], f["model"]) == (row["trial"], row["model"])]
                line = drawn[row["model"]]
                assert line.get_ydata() == pytest.approx([frame["hs"] for frame in row_frames])
                assert line.get_xdata()[-1] == pytest.approx((len(row_frames) - 1) / row["fps"])


def test_bars_are_shares_of_the_intact_network_with_the_claim_s_bounds(run):
    rows = run.trials.to_pylist()
    left = shares(rows)
    for polarity, (*_, bars) in panels(run).items():
        driven = f"dsnn-{polarity}-blocked"
        for bar, model in zip(bars.patches, MODELS[1:], strict=True):
            polarity_shares = [left[clip.name, model] for clip in CLIPS if clip.name.startswith(polarity)]
            assert bar.get_height() == pytest.approx(100 * np.mean(polarity_shares))
            assert bool(bar.get_height() < 5.0) is (model == driven), "the edge drives the pathway of its own sign"
        bounds = sorted(line.get_ydata()[0] for line in bars.get_lines() if line.get_linestyle() == "--")
        assert bounds == [5.0, 95.0]
    (whole,) = (row for row in rows if row["model"] == "dsnn" and row["clip"] == "off rightward")
    (part,) = (row for row in rows if row["model"] == MODELS[1] and row["clip"] == "off rightward")
    assert left["off rightward", MODELS[1]] == pytest.approx(part["peak_hs"] / whole["peak_hs"])
    assert find("C22").judge(rows, 0.16).verdict == "holds", "the judge reads the same numbers"


def test_the_icons_name_the_edges_of_objects(run):
    for polarity, (icons, *_) in panels(run).items():
        labels = {text.get_text().replace("\n", " ") for text in icons.texts}
        assert set(CASES[polarity][1]) <= labels
    darkens = {case for case in CASES["off"][1]}
    assert darkens == {"dark object, leading edge", "light object, trailing edge"}
    assert not darkens & set(CASES["on"][1])


def test_a_model_that_is_not_compared_with_the_dsnn_has_no_share():
    row = {"clip": "a", "peak_hs": 0.2, "trough_hs": 0.0}
    assert shares([{**row, "model": "emd"}]) == {}
    silent = [{**row, "model": "dsnn", "peak_hs": 0.0}, {**row, "model": "emd"}]
    assert np.isnan(shares(silent)["a", "emd"])
