"""Videos and strips of recordings with several models: who is shown, where, and what is said of the others."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from dsnn import Response, ResponseSeries
from experiments.bench.run.errors import UsageError
from experiments.bench.run.record import Content, Frames, Model, write
from experiments.bench.video import make
from experiments.bench.video.choice import with_models
from experiments.bench.video.layout import lay_out, levels_of, traces_of
from experiments.bench.video.reading import Reel, read
from experiments.bench.video.still import still_of

SIZES = [(1280, 720), (640, 360)]
FRAMES = 40
LONG = "dsnn-onboard:preset=bits16,n_con=8,d=2"
LABELS = ("dsnn", "emd:tau=40", "lgmd1", LONG, "models/my.py", "dsnn@ov7670", *(f"m{i}" for i in range(14)))
"""Twenty, some of which a path in a recording escapes, and one with no room for all of it."""
LOOMING = ("lgmd1", "m3")
PIXELS = "m1"
"""A model whose potential is no share of anything, as that of optic flow."""


def answered(label: str) -> SimpleNamespace:
    """What a model answered: potentials with a size of its own, and a spike in every fourth frame."""
    size = 3.0 if label == PIXELS else 0.2 + 0.03 * LABELS.index(label)
    times = np.linspace(0, 2 * np.pi, FRAMES)
    if label in LOOMING:
        series = [Response(looming=0.5 + size * abs(np.sin(t)) / 2, looming_spikes=int(i % 4 == 0))
                  for i, t in enumerate(times)]  # fmt: skip
        return SimpleNamespace(model=label, channels=("looming",), thresholds={"looming": 0.7},
                               series=ResponseSeries.from_responses(series))  # fmt: skip
    series = [Response(hs=size * np.sin(t), vs=size * np.cos(t) / 2, hs_spikes=int(i % 4 == 0))
              for i, t in enumerate(times)]  # fmt: skip
    threshold = 0.2 if LABELS.index(label) % 2 else 0.16
    return SimpleNamespace(model=label, channels=("hs", "vs"), thresholds={"hs": threshold, "vs": threshold},
                           series=ResponseSeries.from_responses(series))  # fmt: skip


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> dict[int, Path]:
    """Number of models -> a recording of so many."""
    folder, paths = tmp_path_factory.mktemp("models"), {}
    seconds = np.arange(FRAMES) / 30
    for count in (1, 3, 4, 8, 20):
        answers = [answered(label) for label in LABELS[:count]]
        models = tuple(Model(one.model, one.channels, tuple(one.thresholds.items())) for one in answers)
        series = {one.model: one.series for one in answers}
        shown = Frames(seconds, np.arange(FRAMES), series, {"": np.full((FRAMES, 12, 16), 200, np.uint8)})
        paths[count] = folder / f"{count}.rrd"
        paths[count].write_bytes(write(Content(models, ("",)), shown, "many"))
    return paths


def film(reel: Reel, size: tuple[int, int]):
    layout = lay_out(reel, make.aspects(reel), *size)
    return layout, still_of(reel, layout, make.caption_of(reel, None))


# Who is shown.


def test_a_recording_tells_whose_traces_and_thresholds_are_whose(recordings):
    reel = read(recordings[20])
    assert reel.models == LABELS
    for label in LABELS:
        answer = answered(label)
        (line,) = [t for t in reel.traces if (t.place, t.model, t.dotted) == ("potential", label, False)]
        np.testing.assert_allclose(line.values, getattr(answer.series, answer.channels[0]))
        wanted = {
            sign * level for level in answer.thresholds.values() for sign in ((1,) if label in LOOMING else (1, -1))
        }
        assert set(levels_of(reel, label)) == wanted


def test_models_are_chosen_by_name(recordings):
    whole = read(recordings[20])
    reel = with_models(whole, ["m13", "lgmd1"])
    assert (reel.models, reel.hidden) == (("m13", "lgmd1"), 0), "in the order asked for; nobody is missed"
    assert set(reel.levels) == {0.7, 0.2, -0.2}, "thresholds of others are gone"
    with pytest.raises(UsageError, match=r"^--model emd: .*20\.rrd has no such model; there are: dsnn, emd"):
        with_models(whole, ["emd"])
    with pytest.raises(UsageError, match=r"^--model lgmd: .*20\.rrd has no such model \(nearest: lgmd1\); there are: "):
        with_models(whole, ["lgmd"])
    with pytest.raises(UsageError, match=r"^--model: 9 models; legal are up to 8 in one picture$"):
        with_models(whole, LABELS[:9])


# Where they are.


@pytest.mark.parametrize("count", [1, 3, 4, 8, 20])
def test_each_model_has_a_lane_of_its_own(recordings, count):
    reel = with_models(read(recordings[count]))
    layout, _ = film(reel, SIZES[0])
    assert tuple(layout.lanes) == reel.models
    drawn = [id(trace) for model in layout.lanes for place in ("potential", "spikes")
             for trace in traces_of(reel, model, place)]  # fmt: skip
    assert sorted(drawn) == sorted(id(trace) for trace in reel.traces if trace.place in ("potential", "spikes"))


def test_potentials_are_drawn_to_one_scale_but_those_that_are_no_shares(recordings):
    reel = with_models(read(recordings[20]), [*LABELS[:4], PIXELS])
    layout, _ = film(reel, SIZES[0])
    scales = {label: layout.lanes[label].y for label in reel.models}
    assert len({scales[label] for label in LABELS[:4]}) == 1
    assert scales[PIXELS][1] > 3.0 > 1.5 > scales["dsnn"][1]


@pytest.mark.parametrize("count", [3, 8])
def test_a_frame_has_each_model_s_spikes_at_the_edge_of_its_lane(recordings, count):
    """Above every potential, so that no trace is taken for a spike."""
    reel = with_models(read(recordings[count]))
    layout, still = film(reel, SIZES[0])
    drawer = make.Drawer(reel, layout, still.picture())
    (frame,) = make.frames(reel, drawer, reel.time_s[[-1]])
    for label in reel.models:
        panel = layout.lanes[label]
        highest = max(float(trace.values.max()) for trace in traces_of(reel, label))
        edge = panel.pixels(np.array([0.0]), np.array([highest]))[0, 1] - 3
        rows = slice(round(panel.top) + 1, round(edge))
        inside = frame[rows, round(panel.left) + 4 : round(panel.left + panel.width) - 6].reshape(-1, 3).astype(int)
        (trace,) = [trace for trace in traces_of(reel, label, "spikes") if np.any(trace.values)]
        assert (np.abs(inside - trace.colour).max(1) < 8).any(), f"{label}'s own spikes"


# The command.
