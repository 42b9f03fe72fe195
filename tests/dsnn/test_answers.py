"""Models that answer wrongly, or write where they should read: through commands, envs and files."""

from pathlib import Path

import gymnasium as gym
import numpy as np
import polars as pl
import pytest

import colias_sim  # noqa: F401  (registers the envs)
from dsnn import Response, ResponseError, checked_response
from experiments.declare.clip import Clip
from experiments.kinds.clips import play_clip
from experiments.settings.settings import watchers
from experiments.show.clips import ClipTrial
from experiments.show.play import Sample, Showing, troubles
from tests.helpers import footage
from tests.helpers.answering import write_model


def test_what_a_model_is_is_what_its_entry_declares(tmp_path):
    """Channels that are not declared are left out of counts, peaks and frames."""
    filled = "Response(hs=0.5, hs_spikes=2, looming=0.9, looming_spikes=1, azimuth=0.25)"
    declared = {"loomer": ', channels=("looming",)', "pointer": ', channels=("hs", "azimuth")'}
    files = [str(tmp_path / write_model(tmp_path, name, filled, more)) for name, more in declared.items()]
    crossing = Clip("right", "plain", {"rows": 40, "columns": 60, "width": 20.0, "height": 20.0, "speed": 240.0})
    shown = play_clip(ClipTrial("test", 0, 0, 0, crossing, tuple(watchers([*files, "dsnn"]))))
    rows = {row["model"]: row for row in shown.rows}
    loom, point = rows["loomer"], rows["pointer"]
    frames = loom["frames"]
    counts = ("spikes", "hs_spikes", "vs_spikes", "looming_spikes")
    assert [loom[name] for name in counts] == [frames, None, None, frames]
    assert [point[name] for name in counts] == [2 * frames, 2 * frames, None, None]
    assert (loom["peak_hs"], point["peak_looming"]) == (0.0, 0.0)
    azimuths = shown.frames.group_by("model").agg(pl.col("azimuth").unique())
    assert dict(azimuths.iter_rows()) == {"dsnn": [0.0], "pointer": [0.25], "loomer": [0.0]}


def test_watch_reads_each_channel_against_its_own_threshold(colias, tmp_path):
    """The hybrid's looming potential rests at 0.5: over the DSNN's T, under the LGMD's."""
    footage.write(tmp_path / "still.avi", [np.full((40, 60), 128, np.uint8)] * 20)
    done = colias("watch", "still.avi", "--no-view", "--model", "hybrid", "--out", "still")
    assert done.returncode == 0, done.stderr
    assert pl.read_csv(tmp_path / "still" / "summary.csv").height == 0, "nothing moves in a still film"


def test_an_env_takes_a_model_as_the_command_line_does_and_a_factory_counts_whole(tmp_path):
    response = Response(hs=0.25, looming=0.75, looming_spikes=1)
    path = tmp_path / write_model(tmp_path, "mine", repr(response), ', channels=("looming",)')

    class Fixed:
        reset, step = (lambda self: None), (lambda self, frame: response)

    for model, hs in ((str(path), 0.0), (lambda shape: Fixed(), 0.25)):
        env = gym.make("colias_sim/Fixation-v0", observation="neural", model=model)
        seen, _ = env.reset(seed=0)
        env.close()
        assert seen.tolist() == [hs, 0.0, 0.0, 0.0, 0.75, 1.0, 0.0]


@pytest.mark.parametrize(
    ("answer", "problem"),
    [(lambda frame: Response(hs=float("nan")), "must"), (lambda frame: frame.fill(0), "read-only")],
)
def test_an_env_refuses_an_answer_that_is_none_and_a_model_that_writes_into_its_frame(answer, problem):
    class Wrong:
        reset, step = (lambda self: None), (lambda self, frame: answer(frame))

    env = gym.make("colias_sim/Fixation-v0", observation="both", model=lambda shape: Wrong())
    with pytest.raises(ValueError, match=problem):
        env.reset(seed=0)
    env.close()


CASE = Path(__file__).parents[1] / "data" / "cases" / "half.py"
FAULTS = {
    "overflows in half precision": CASE.read_text(),
    "has no step to read": "class Half(Half):\n    step = property(lambda self: 1 / 0)\n",
    "hides the parameters of its step": "class Step:\n    __signature__ = property(lambda self: 1 / 0)\n"
    "    __call__ = Half.step\nHalf.step = Step()\n",
    "has maps that no picture shows": "from dsnn import LayerMaps\nclass Half(Half):\n"
    "    def step(self, frame, maps=False):\n"
    "        return Response(maps=LayerMaps(*[np.ones(frame.shape, np.longdouble)] * 4))\n",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_model_that_fails_costs_its_own_rows_alone(tmp_path, fault):
    path, last = tmp_path / "half.py", 'MODEL = ModelEntry("half"'
    before, after = CASE.read_text().split(last)
    path.write_text(before + FAULTS[fault].partition(last)[0] + last + after)
    frames = [Sample(i / 30, np.full((20, 30), 10 * i, np.uint8), {"time": i}) for i in range(12)]
    showing = Showing(type("Source", (), {"shape": (20, 30), "__iter__": lambda self: iter(frames)})(),
                      watchers([str(path), "dsnn"]))  # fmt: skip
    showing.runners[0].maps = True
    assert len(list(showing)) == 12
    assert [model.label for model, _ in showing.series()] == ["dsnn"] and list(troubles([showing])) == ["half"]


def test_numbers_of_every_kind_are_taken_and_nothing_else():
    for value in (0.25, np.float32(0.25), np.array(0.25)):
        hs = checked_response(Response(hs=value)).hs
        assert type(hs) is float and hs == 0.25
    for value in (2, np.int8(2), 2.0):
        count = checked_response(Response(hs_spikes=value)).hs_spikes
        assert type(count) is int and count == 2
    half = np.float16("inf"), np.array(np.float16("-inf")), np.float16("nan"), np.longdouble("inf"), np.float32(1.1e9)
    wrong = (None, "1", 1j, np.zeros(1), np.ma.masked, 1e308, 2**70, float("nan"), float("inf"), *half)
    for values in (*({"hs": v} for v in wrong), *({"vs_spikes": v} for v in (*wrong, 0.5)), {"looming_spikes": -1}):
        with pytest.raises(ResponseError):
            checked_response(Response(**values))
