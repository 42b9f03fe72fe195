"""Marks in a recording, read back from disk, are the spikes of its table: sign for sign, frame for frame."""

import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import polars as pl
import pytest

import experiments
from dsnn import Response
from dsnn.model import SPIKING
from experiments.cli.main import command
from experiments.draw.video import Reel
from experiments.settings.models import choose
from experiments.show.episodes import play, record
from tests.helpers.answering import write_model
from tests.helpers.envs import FIXATION
from tests.helpers.footage import write

FRAMES = 12
ANSWER = """Response(
            hs=(h := (0, 2, -1)[self.frame % 3]) / 4, hs_spikes=h,
            vs=(v := (-3, 0, 0, 1)[self.frame % 4]) / 4, vs_spikes=v,
            looming=0.5 + (n := (0, 1)[self.frame % 2]) / 4, looming_spikes=n,
        )"""
MODEL = {"models": "both.py", "only": True, "out": "run", "quiet": True}
SPIKES = tuple(f"{channel}_spikes" for channel in SPIKING)
Marked = tuple[Path, pl.DataFrame]
"""A recording, and a table with the spikes frame by frame."""


def of_run(run: experiments.Run) -> Marked:
    (recording,) = run.recordings
    return recording, run.frames


def robot() -> Marked:
    settings = {"experiment.speeds_cm_s": [30], "experiment.direction": "rightward"}
    return of_run(experiments.run("speed", repeats=1, settings=settings, workers=0, **MODEL))


def clip() -> Marked:
    clips = (experiments.Clip("c", "plain", {"rows": 60, "columns": 80}),)
    return of_run(experiments.run(experiments.OfflineExperiment("one", "", clips, ("both.py",)), workers=0, **MODEL))


def footage() -> Marked:
    write(Path("film.avi"), [np.full((60, 80, 3), 20 * frame, np.uint8) for frame in range(FRAMES)])
    return of_run(experiments.watch("film.avi", **MODEL))


def episode() -> Marked:
    turns = experiments.Behaviour("turns", "", FIXATION, lambda rng: lambda seen: (0.1, -0.1), model="both.py")
    played = play(turns, FIXATION, {}, 0, FRAMES)
    Path("episode.rrd").write_bytes(record(played))
    return Path("episode.rrd"), played.steps(0)


def recorded_env() -> Marked:
    made = gym.make("colias_sim/Pursuit-v0", observation="neural", model="both.py", max_episode_steps=FRAMES)
    env = experiments.RecordRerun(made, "env.rrd")
    env.reset(seed=0)
    answers = [(env.step(np.zeros(2, np.float32)), made.unwrapped.response)[1] for _ in range(FRAMES)]
    env.close()
    return Path("env.rrd"), pl.DataFrame({name: [getattr(answer, name) for answer in answers] for name in SPIKES})


def log() -> Marked:
    hs, vs, looming = [0, 2, -1, 0] * 3, [-3, 0, 0, 1] * 3, [0, 1] * 6
    frames = pl.DataFrame({"hs_spikes": hs, "vs_spikes": vs, "looming_spikes": looming})
    frames.with_columns(
        hs=pl.col("hs_spikes") / 4, vs=pl.col("vs_spikes") / 4, looming=0.5 + pl.col("looming_spikes") / 4,
        trial=0, speed_cm_s=6, model=pl.lit("hybrid"), time_s=pl.Series(range(1, 13)) / 30,
    ).write_csv("log.csv")  # fmt: skip
    assert command(["import", "log.csv", "--out", "run", "--quiet"]) == 0
    return of_run(experiments.load("run"))


@pytest.mark.parametrize("kind", [robot, clip, footage, episode, recorded_env, log])
def test_the_marks_of_a_recording_are_the_spikes_of_its_table(kind: Callable[[], Marked], tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_model(tmp_path, "both", ANSWER, ", channels=('hs', 'vs', 'looming')")
    path, table = kind()
    (marks,) = Reel(path).values.values()
    for channel, name in zip(SPIKING, SPIKES, strict=True):
        assert marks[f"spikes/{channel}"][1].tolist() == table[name].to_list()
        assert {*np.sign(table[name])} == ({0, 1} if channel == "looming" else {-1, 0, 1})


@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="no viser: run 'sh tools/setup.sh --live'")
def test_the_traces_of_the_live_page_have_the_spikes_of_each_channel_with_their_signs():
    from experiments.live.page import Traces

    chosen = choose("dsnn")
    runner = SimpleNamespace(chosen=chosen, network=chosen.network, label="dsnn")
    page: Any = SimpleNamespace(add_uplot=lambda data, _series, **more: SimpleNamespace(data=data, **more))
    session: Any = SimpleNamespace(runners=[runner], interval_s=1 / 30)
    traces = Traces(page, session)
    for hs, vs in ((0, 0), (4, -3), (-1, 2), (-1, 0)):
        traces.add({"dsnn": Response(hs / 4, vs / 4, hs, vs)})
    _, spikes = traces._plots
    _, hs_trace, vs_trace = (trace[-4:].tolist() for trace in spikes.data)
    assert (hs_trace, vs_trace) == ([0, 4, -1, -1], [0, -3, 2, 0])
