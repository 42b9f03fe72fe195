"""The time left: what jobs are counted as, and what is told of the rest. No clock but a simulated one is read."""

import contextlib
from pathlib import Path

import pytest

from experiments.bench.closed_loop import run as closed_loop_run
from experiments.bench.closed_loop.episode import Setting
from experiments.bench.closed_loop.run import BehaviourPlan, batch
from experiments.bench.engine import batch as engine
from experiments.bench.engine.batch import Resources
from experiments.bench.engine.jobs import Workload
from experiments.bench.engine.terminal import Pace

LONGEST, SHORT = 1800.0, 65.0


def kinds_of(counts):
    """Index of a job -> its kind, kind by kind."""
    kinds = [kind for kind, number in counts.items() for _ in range(number)]
    return dict(enumerate(kinds))


def test_what_is_left_goes_by_what_jobs_of_the_kind_took():
    """Once one job of each kind is back, and jobs of a kind are alike, what is left is exact."""
    takes, kinds = {"far": LONGEST, "hits": SHORT}, kinds_of({"far": 4, "hits": 8})
    load = Workload(dict.fromkeys(kinds, LONGEST), kinds)
    assert load.left() == 12 * LONGEST, "before any is back: as planned"
    done = {index for index, kind in kinds.items() if index in (0, 4)}
    for index in sorted(done):
        assert load.back(index, takes[kinds[index]]) == takes[kinds[index]]
    for index in sorted(kinds.keys() - done):
        assert load.left() == pytest.approx(sum(takes[kinds[job]] for job in kinds.keys() - done))
        load.back(index, takes[kinds[index]])
        done.add(index)
    assert load.left() == pytest.approx(0.0)


def test_a_kind_of_which_none_is_back_goes_by_all():
    load = Workload(dict.fromkeys(range(4), 100.0), kinds_of({"a": 1, "b": 1, "c": 2}))
    load.back(0, 50.0)
    load.back(1, 10.0)
    assert load.left() == pytest.approx(2 * 100.0 * 60.0 / 200.0)


def test_a_job_that_failed_counts_as_one_like_it_and_teaches_nothing():
    load = Workload(dict.fromkeys(range(3), 100.0), kinds_of({"a": 3}))
    load.back(0, 20.0)
    assert load.back(1, None) == pytest.approx(20.0)
    assert load.left() == pytest.approx(20.0)


def told(order, takes, kinds, learned, width=2):
    """What is said and what is true of the time left, in simulated seconds, after each job; a step takes a second."""
    load = Workload(dict.fromkeys(kinds, LONGEST), kinds)
    pace = Pace(LONGEST * len(kinds), width, min(load.kinds, len(kinds) // 2))
    now, rest = 0.0, sum(takes[kind] for kind in kinds.values())
    for index in order:
        took = takes[kinds[index]]
        now, rest = now + took, rest - took
        size = load.back(index, took)
        pace.add(size if learned else LONGEST, now, load.left() if learned else None)
        yield pace.left_s(), rest


def test_episodes_of_other_lengths_do_not_deceive_the_time_left():
    """Nine behaviours, of which those in front hit something after a few steps, as those of ``escape`` do."""
    takes = {f"hits-{i}": SHORT for i in range(4)} | {f"far-{i}": LONGEST for i in range(5)}
    kinds = kinds_of(dict.fromkeys(takes, 10))
    mixed = sorted(kinds, key=lambda index: (index % 10, index))
    estimates = [(seconds, rest) for seconds, rest in told(mixed, takes, kinds, learned=True) if seconds is not None]
    assert len(estimates) > 0.8 * len(kinds), "it is told early"
    assert all(seconds == pytest.approx(rest) for seconds, rest in estimates)
    blind = [pair for pair in told(kinds, takes, kinds, learned=False) if pair[0] is not None]
    assert max(rest / max(seconds, 1.0) for seconds, rest in blind) > 10, "counted alike, in order: wrong by ten times"


@pytest.fixture
def counted(monkeypatch):
    """What `engine` tells the progress bar: (planned whole, fewest jobs, [(size, left)])."""
    calls, told = [], {}

    @contextlib.contextmanager
    def progress(name, total, quiet, things, *, width, whole, least):
        told.update(whole=whole, least=least)
        yield lambda size, left: calls.append((size, left))

    monkeypatch.setattr(engine, "progress", progress)
    return calls, told


def test_episodes_count_by_the_steps_that_they_really_ran(tmp_path: Path, counted):
    """A robot that drives straight on hits something long before one that stands still is through."""
    calls, whole = counted
    settings = tuple(Setting(name, "colias_sim/Avoidance-v0", steps=150) for name in ("straight", "still"))
    resources = Resources(0, quiet=True)
    with resources.pool() as pool:
        played = closed_loop_run.run(BehaviourPlan(settings, 2, 0), tmp_path / "out", pool, resources)
    steps = {
        name: [row["frames"] for row in standing.rows]
        for name, standing in zip(("straight", "still"), played.standings, strict=True)
    }
    assert max(steps["straight"]) < 150 == min(steps["still"]), "the two differ, or this shows nothing"
    sizes = [size for size, _ in calls]
    for repeat in range(2):  # two are under way at a time, and either may be the first that is back
        assert sorted(sizes[2 * repeat :][:2]) == sorted(lengths[repeat] for lengths in steps.values()), (
            "by its own steps"
        )
    assert whole == {"whole": 4 * 150, "least": 2}
    assert calls[1][1] == pytest.approx(steps["straight"][0] + steps["still"][0]), "each like the one before"
    assert calls[-1][1] == pytest.approx(0.0)


def test_the_first_episodes_are_of_every_behaviour():
    behaviour_plan = closed_loop_run.plan("escape", None, (), 3, 0, True)
    order = batch(behaviour_plan, 0).specs
    assert sorted(spec.index for spec in order) == list(range(len(order)))
    several = len(behaviour_plan.settings)
    for repeat in range(3):
        specs = order[repeat * several : (repeat + 1) * several]
        assert {spec.condition.behaviour for spec in specs} == {
            setting.behaviour for setting in behaviour_plan.settings
        }


def test_the_time_left_is_told_from_the_least_on():
    pace = Pace(100.0, 1, least=4)
    for now in range(1, 5):
        assert pace.left_s() is None
        pace.add(10.0, float(now))
    assert pace.left_s() == pytest.approx(6.0)
