"""Runs of many robots: equal tables whoever plays them, exchanged and lost robots, what is counted and judged."""

import math
from dataclasses import replace

import cloudpickle
import numpy as np
import polars as pl
import pytest

from colias_sim import Pose
from colias_sim.envs.swarm import APART, Body
from experiments import Check, Claim, Scenario, SwarmDesign, load, run, sweep
from experiments.base.errors import UsageError
from experiments.declare.scenario import BLIND
from experiments.kinds.swarm import SwarmTrial, play
from experiments.paper.scenarios import FOLLOW, TRAFFIC, Pedestrian, by_chance, chain, links
from experiments.settings.models import choose
from experiments.settings.settings import applied, look_up
from experiments.store.folder import RunFolder

BRIEF = {"swarm.robots": [2, 3], "swarm.seconds": 1.0}
OPTIONS = {"arena": "bright"}


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


def test_a_run_of_swarms_resumes(whole, tmp_path, monkeypatch):
    out, added, done = tmp_path / "part", RunFolder.add, []

    def until_two(folder, *record):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(record)
        added(folder, *record)

    asked = {"repeats": 2, "models": ["lgmd2"], "only": True, "settings": BRIEF, "workers": 0, "quiet": True}
    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(RunFolder, "add", until_two)
        run("traffic", **asked, out=out)
    assert load(out).done == 2
    assert run("traffic", **asked, out=out).trials.equals(whole.trials)


def played(scenario, number, seed=0, models=(), frames=20, options=OPTIONS):
    trial = SwarmTrial(scenario.name, 0, 0, seed, (number, 8.0), models)
    return play(trial, source=cloudpickle.dumps(scenario), options=options, frames=frames)


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


def test_a_model_s_settings_reach_the_robots():
    """A threshold that nothing reaches leaves a swarm without a spike."""
    (usual,) = applied(look_up(["lgmd2"]), {})
    assert usual.label == "lgmd2"
    dark = Scenario(name="dark", summary="", start=lambda rng, n: [Pose(-0.06, 0, 0), Pose(0.06, 0, math.pi)],
                    make=lambda number, ahead, channels, rng: lambda seen, body: (ahead, ahead))  # fmt: skip
    loud = played(dark, 2, models=(usual,)).frames
    assert loud["looming"].null_count() == 0 and loud["looming"].n_unique() > 10
    assert played(dark, 2).frames["looming"].null_count() == 40


def test_chance_is_that_of_discs_that_meet_in_a_gas():
    """Against straight ways of random discs without turning, counted on a torus of the same area."""
    rng, number, speed, diameter = np.random.default_rng(0), 12, 8.0, 4.0
    side = math.sqrt(math.pi * 43.0**2)
    place, way = rng.uniform(0, side, (number, 2)), rng.uniform(0, 2 * np.pi, number)
    velocity, met, before, step = speed * np.stack([np.cos(way), np.sin(way)], 1), 0, None, 0.02
    steps = 60_000
    for _ in range(steps):
        place = (place + velocity * step) % side
        apart = np.abs(place[:, None] - place[None])
        near = np.hypot(*np.minimum(apart, side - apart).transpose(2, 0, 1)) < diameter
        met += 0 if before is None else int((near & ~before).sum())
        before = near
    assert met / number / (steps * step / 60) == pytest.approx(by_chance(number, speed), rel=0.25)


def test_a_pedestrian_turns_away_from_the_wall_backs_off_and_heeds_its_alarm():
    rng = np.random.default_rng(0)
    far = Body(number=0, time_s=0.0, touched=False, wall_m=0.2, wall_bearing=0.0)
    walk = Pedestrian(lambda seen: seen, 0.2, rng)
    assert walk(0.0, far) == (0.2, 0.2)
    left, right = walk(1.0, far)
    assert left > 0 > right, "a turn to the right, as the alarm says"
    for _ in range(Pedestrian.FRAMES - 1):
        assert walk(-1.0, far) == (left, right), "it does not look while it turns"
    assert walk(-1.0, far) == (0.2, 0.2)
    near = replace(far, wall_m=0.01, wall_bearing=0.3)
    left, right = Pedestrian(lambda seen: 0.0, 0.2, rng)(0.0, near)
    assert left < 0 < right, "to the left of a wall on the right"
    assert Pedestrian(lambda seen: 0.0, 0.2, rng)(None, replace(far, touched=True)) == (-0.2, -0.2)


def test_links_of_a_chain():
    """Robots that drive on as they stand break no link; one that turns round, and one that falls behind, do."""
    start = np.array([(pose.x, pose.y, pose.heading) for pose in chain(np.random.default_rng(0), 4)])
    still = np.repeat(start[None], 40, axis=0)
    assert links(still) == {"spread_cm": 0.0, "breaks": 0.0}
    turned, behind = still.copy(), still.copy()
    turned[:, 2, 2] += math.pi
    behind[20:, 3, :2] *= 3
    assert links(turned)["breaks"] == pytest.approx(1 / 3) == links(behind)["breaks"]
    assert links(behind)["spread_cm"] > 5


def test_claims_are_judged_by_repeat_and_a_swarm_is_no_trial(tmp_path):
    claim = Claim(id="all-there", says="three", on="swarm",
                  judge=lambda rows, *_: [Check("robots", max(row["robots"] for row in rows), 2)])  # fmt: skip
    mine = replace(TRAFFIC, claims=(claim,), models=(BLIND,), design=SwarmDesign(robots=(3,), seconds=1.0))
    done = run(mine, repeats=3, workers=0, quiet=True, out=tmp_path / "mine")
    (verdict,) = done.verdicts
    assert (verdict.id, verdict.count.holds, verdict.experiment) == ("all-there", 3, "traffic")
    with pytest.raises(UsageError, match="of many robots"):
        sweep("traffic", over=["dsnn.n_con=4,6"], models=["dsnn"], quiet=True)


def test_what_ships_is_found_and_starts_apart():
    for scenario in (TRAFFIC, FOLLOW):
        for number in scenario.design.robots:
            starts = scenario.start(np.random.default_rng(1), number)
            apart = [math.hypot(a.x - b.x, a.y - b.y) for i, a in enumerate(starts) for b in starts[:i]]
            assert len(starts) == number and min(apart) > 0.045
    assert choose("lgmd2").channels == ("looming",)
    assert TRAFFIC.chance(4, 8.0) * 11 / 3 == pytest.approx(TRAFFIC.chance(12, 8.0))
