"""Marks in a recording, read back from disk, are the spikes of its table: sign for sign, frame for frame."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium as gym
import numpy as np
import polars as pl
import pytest
import rerun as rr

import experiments
from dsnn import Response
from dsnn.model import SPIKING
from experiments.bench.cli.main import command
from experiments.bench.run.models import choose
from tests.helpers.answering import write_model
from tests.helpers.envs import end_after
from tests.helpers.footage import write

FRAMES = 12
ANSWER = """Response(
            hs=(h := (0, 2, -1)[self.frame % 3]) / 4, hs_spikes=h,
            vs=(v := (-3, 0, 0, 1)[self.frame % 4]) / 4, vs_spikes=v,
            looming=0.5 + (n := (0, 1)[self.frame % 2]) / 4, looming_spikes=n,
        )"""
BEHAVIOUR = """
from experiments import Behaviour

BEHAVIOUR = Behaviour("turns", "turns", "Fixation", lambda rng: lambda seen: (0.1, -0.1), model="both.py")
"""
CLIP = """
from experiments import Clip, OfflineExperiment

EXPERIMENT = OfflineExperiment("one", "one clip", (Clip("c", "plain", {"rows": 60, "columns": 80}),), ("both.py",))
"""
SPIKES = tuple(f"{channel}_spikes" for channel in SPIKING)
Table = dict[str, list[int]]
"""Column of spikes -> its values, frame by frame."""


def table_of(path: Path) -> Table:
    table = pl.read_parquet(path)
    return {name: table[name].to_list() for name in SPIKES}


def run(folder: Path) -> tuple[Path, Table]:
    (recording,) = (folder / "run" / "recordings").iterdir()
    return recording, table_of(folder / "run" / "frames.parquet")


def colias(*arguments: Any) -> None:
    assert command([str(argument) for argument in (*arguments, "--quiet")]) == 0


def RobotTrial(folder: Path) -> tuple[Path, Table]:
    crossing = ("--set", "experiment.speeds_cm_s=30", "--set", "experiment.direction=rightward")
    colias("run", "speed", "--repeats", 1, *crossing, "--only", "--model", "both.py", "--workers", 0, "--out", "run")
    return run(folder)


def clip(folder: Path) -> tuple[Path, Table]:
    (folder / "one.py").write_text(CLIP)
    colias("run", "one.py", "--workers", 0, "--out", "run")
    return run(folder)


def footage(folder: Path) -> tuple[Path, Table]:
    write(folder / "film.avi", [np.full((60, 80, 3), 20 * frame, np.uint8) for frame in range(FRAMES)])
    colias("watch", "film.avi", "--no-view", "--only", "--model", "both.py", "--out", "run")
    return run(folder)


def episode(folder: Path) -> tuple[Path, Table]:
    (folder / "turns.py").write_text(BEHAVIOUR)
    with pytest.MonkeyPatch.context() as patch:
        end_after(FRAMES, patch)
        colias("behave", "turns.py", "--episodes", 1, "--no-baselines", "--workers", 0, "--out", "run")
    return run(folder)


def recorded_env(folder: Path) -> tuple[Path, Table]:
    made = gym.make("colias_sim/Pursuit-v0", observation="neural", model="both.py", max_episode_steps=FRAMES)
    env = experiments.RecordRerun(made, folder / "env.rrd")
    env.reset(seed=0)
    answers = [(env.step(np.zeros(2, np.float32)), made.unwrapped.response)[1] for _ in range(FRAMES)]
    env.close()
    return folder / "env.rrd", {name: [getattr(a, name) for a in answers] for name in SPIKES}


def log(folder: Path) -> tuple[Path, Table]:
    spikes = {"hs_spikes": [0, 2, -1, 0] * 3, "vs_spikes": [-3, 0, 0, 1] * 3, "looming_spikes": [0, 1] * 6}
    with (folder / "log.csv").open("w", newline="") as file:
        lines = csv.writer(file)
        lines.writerow(["trial", "speed_cm_s", "model", "time_s", "hs", "vs", "looming", *spikes])
        for frame, (hs, vs, looming) in enumerate(zip(*spikes.values(), strict=True)):
            cells = (hs / 4, vs / 4, 0.5 + looming / 4, hs, vs, looming)
            lines.writerow([0, 6, "hybrid", (frame + 1) / 30, *cells])
    colias("import", "log.csv", "--out", "run")
    return run(folder)


KINDS = (RobotTrial, clip, footage, episode, recorded_env, log)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_the_marks_of_a_recording_are_the_spikes_of_its_table(kind: Callable[[Path], Any], tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_model(tmp_path, "both", ANSWER, ", channels=('hs', 'vs', 'looming')")
    path, table = kind(tmp_path)
    model = "hybrid" if kind is log else "both"
    assert all({-1, 1} <= set(np.sign(table[name])) for name in ("hs_spikes", "vs_spikes"))
    for channel, name in zip(SPIKING, SPIKES, strict=True):
        entity = f"/models/{model}/spikes/{channel}"
        chunks = rr.chunk.RrdReader(path).stream().filter(content=entity, is_static=False).to_chunks()
        batches = [chunk.to_record_batch() for chunk in chunks]
        frames = [frame for batch in batches for frame in batch["frame"].to_pylist()]
        counts = [count for batch in batches for (count,) in batch["Scalars:scalars"].to_pylist()]
        assert [count for _, count in sorted(zip(frames, counts, strict=True))] == table[name]


@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="no viser: run 'sh tools/setup.sh --live'")
def test_the_traces_of_the_live_page_have_the_spikes_of_each_channel_with_their_signs():
    from experiments.bench.live.drawing import Traces

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
    low, high = spikes.scales["y"]["range"]
    assert low <= -3 and high >= 4
