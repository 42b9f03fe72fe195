"""Runs of many robots: equal tables whoever plays them, exchanged and lost robots, what is counted and judged."""

import math
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from colias_sim import Pose
from colias_sim.envs.swarm import APART
from experiments import Check, Claim, Scenario, SwarmDesign, run, sweep
from experiments.base.errors import UsageError
from experiments.declare.behaviour import BLIND
from experiments.draw.video import Reel
from experiments.paper.scenarios import SCENARIOS
from experiments.show.episodes import ROW_PX, EpisodeTrial, play_swarm, raster
from experiments.store.recordings import pictures

BRIEF = {"swarm.robots": [2, 3], "swarm.seconds": 1.0}
OPTIONS = {"arena": "bright"}
TRAFFIC, FOLLOW = SCENARIOS


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return run("traffic", repeats=2, models=["lgmd2"], only=True, settings=BRIEF, workers=0, quiet=True,
               out=tmp_path_factory.mktemp("swarm") / "whole")  # fmt: skip


def test_tables_are_equal_by_workers_and_resumed(whole, tmp_path):
    """On no worker and on two; and where a part is done, the rest is as it would have been."""
    for workers in (2,):
        there = run("traffic", repeats=2, models=["lgmd2"], only=True, settings=BRIEF, workers=workers, quiet=True,
                    out=tmp_path / str(workers))  # fmt: skip
        assert there.trials.equals(whole.trials) and there.frames.equals(whole.frames)
    assert whole.trials["robots"].to_list() == [2, 3, 2, 3]
    frames = whole.frames.group_by("trial", "robot", maintain_order=True).len()
    assert frames["len"].to_list() == [30] * 5, "a row per robot and frame of the first repeat"
    assert {"figure.png", "summary.csv", "claims.json"} <= {path.name for path in whole.folder.iterdir()}


def played(scenario, number, seed=0, models=(), frames=20, options=OPTIONS):
    trial = EpisodeTrial(scenario.name, 0, 0, seed, "", models)
    return play_swarm(trial, scenario, (number, 8.0), options, frames)


def line(rng, number):
    return [Pose(0.1 * k - 0.1, 0.0, math.pi if k else 0.0) for k in range(number)]


def test_a_drive_that_raises_ends_its_own_robot_with_its_traceback():
    def make(number, ahead, channels, rng):
        def drive(seen, body):
            if number == 1 and body.time_s > 0.3:
                raise RuntimeError("lost its way")
            return 0.1 * (number - 1), 0.1 * (number - 1)

        return drive

    record = played(Scenario(name="lost", summary="", start=lambda rng, n: line(rng, n), make=make), 3)
    ((robot, text),) = record.troubles.items()
    assert robot == "blind, robot1" and "lost its way" in text and "in drive" in text
    x = {name: rows["x_cm"].to_list() for (name,), rows in record.frames.group_by("robot")}
    assert abs(x["robot2"][-1] - 10) > 1 and len(record.frames) == 60


def test_collisions_are_counted_once_until_robots_have_parted():
    """Two robots meet, push each other for a while, back off, and meet again."""
    reverse = (12, 30)

    def make(number, ahead, channels, rng):
        def drive(seen, body):
            way = -0.1 if reverse[0] <= body.time_s * 30 < reverse[1] else 0.1
            return (way, way)

        return drive

    pair = Scenario(
        name="pair", summary="", start=lambda rng, n: [Pose(-0.03, 0, 0), Pose(0.03, 0, math.pi)], make=make
    )
    record = played(pair, 2, frames=60)
    (row,) = record.rows
    starts = record.frames.filter(pl.col("touches").is_not_null(), robot="robot0")
    assert row["collisions"] == 2 == starts.height and set(starts["touches"]) == {"robot1"}
    assert starts["frame"].diff()[1] > APART and row["wall_a_min"] == 0
    assert row["collisions_a_min"] == pytest.approx(2 * 2 / 2 / (60 / 30 / 60))


def test_claims_are_judged_by_repeat_and_a_swarm_is_no_trial(tmp_path):
    claim = Claim(id="all-there", says="three", on="swarm",
                  judge=lambda rows, *_: [Check("robots", max(row["robots"] for row in rows), 2)])  # fmt: skip
    mine = replace(TRAFFIC, claims=(claim,), models=(BLIND,), design=SwarmDesign(robots=(3,), seconds=1.0))
    done = run(mine, repeats=3, workers=0, quiet=True, out=tmp_path / "mine")
    (verdict,) = done.verdicts
    assert (verdict.id, verdict.count.holds, verdict.experiment) == ("all-there", 3, "traffic")
    with pytest.raises(UsageError, match="sweeps swarm"):
        sweep("traffic", over=["dsnn.n_con=4,6"], models=["dsnn"], quiet=True)


def test_a_recording_has_every_way_and_view_and_collision(whole):
    """Of the first repeat's trials; a film shows the first four views beside the plan."""
    first, second = whole.recordings
    rows = whole.frames.filter(trial=1)
    reel = Reel(second)
    assert list(reel.tracks) == ["robot0", "robot1", "robot2"] and len(reel.eyes) == 3
    for name, track in reel.tracks.items():
        own = rows.filter(robot=name)
        np.testing.assert_allclose(track[1:3], own.select("x_cm", "y_cm").to_numpy().T, atol=1e-4)
    seen = pictures(second)
    assert {eye: images.shape for eye, images in seen.items()} == {
        f"camera_robot{k}": (10, 72, 99) for k in range(3)
    }  # a picture each three frames
    assert len(pictures(first)) == 2
    assert raster([[-1.0, 1.0], [0.0, 0.5]]).shape == (2 * ROW_PX, 2)
