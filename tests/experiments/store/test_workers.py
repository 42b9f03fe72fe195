"""Workers: jobs that raise, jobs whose process dies, the end of a pool."""

import contextlib
import os
import signal
import time
from pathlib import Path

import pytest

import experiments
from experiments.store.workers import DIED, Workers, finished


def die_or_double(job):
    """Kill this process: always for 13; once, leaving a mark, for 7."""
    number, folder = job
    mark = Path(folder) / f"died-{number}"
    with (Path(folder) / f"tried-{number}").open("a") as tries:
        tries.write("x")
    if number == 13 or (number == 7 and not mark.exists()):
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return 2 * number


def complain(job):
    if job[0] == 3:
        raise ValueError("three is not a number I like")
    return 2 * job[0]


def started(number, cluster=None):
    return Workers(number, cluster).running(rendering=False)


def run(workers, work, numbers, folder="", fatal=()):
    done, failed = [], {}
    for job, result, trouble in finished([(number, str(folder)) for number in numbers], work, workers, fatal):
        if result is None:
            failed[job[0]] = trouble
        else:
            done.append(result)
    return sorted(done), failed


def test_a_job_whose_worker_dies_is_repeated_and_named_if_it_dies_again(tmp_path):
    with started(2) as pool:
        done, failed = run(pool, die_or_double, range(20), tmp_path)
    assert done == [2 * n for n in range(20) if n != 13]
    assert failed == {13: DIED}
    tries = {number: len((tmp_path / f"tried-{number}").read_text()) for number in range(20)}
    assert tries[7] == 2 and max(tries.values()) == 2, "13 may have waited in the pool that 7 broke"


def local_cluster():
    from distributed import LocalCluster

    return LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0", protocol="tcp://")


@contextlib.contextmanager
def dask():
    with local_cluster() as cluster, started(0, cluster.scheduler_address) as pool:
        yield pool


POOLS = {"here": lambda: started(0), "one worker": lambda: started(1), "two": lambda: started(2), "dask": dask}


@pytest.mark.parametrize("kind", POOLS)
def test_a_job_that_raises_fails_alone_with_its_traceback(kind):
    with POOLS[kind]() as pool:
        done, failed = run(pool, complain, range(6))
    assert done == [0, 2, 4, 8, 10]
    (why,) = failed.values()
    assert why.endswith("ValueError: three is not a number I like")
    assert f'File "{__file__}", line {complain.__code__.co_firstlineno + 2}, in complain' in why


def doze(job):
    time.sleep(0.05)
    return job[0]


def test_a_cluster_that_is_lost_ends_the_run():
    """What was finished by then has been handed over."""
    done = []
    jobs = [(number, "") for number in range(10_000)]
    with (
        local_cluster() as cluster,
        started(0, cluster.scheduler_address) as pool,
        pytest.raises(OSError, match="cluster"),
    ):
        for job, _, trouble in finished(jobs, doze, pool):
            assert not trouble
            done.append(job[0])
            if len(done) == 3:
                cluster.close()
    assert len(done) >= 3


def test_a_cluster_plays_a_run_to_equal_rows(tmp_path):
    shape = {"rows": 40, "columns": 60, "width": 9, "height": 20, "speed": 240.0}
    small = experiments.OfflineExperiment("small", "small", (experiments.Clip("right", "plain", shape),), ("dsnn",))
    with local_cluster() as cluster:
        there, here = (
            experiments.run(small, repeats=3, recordings=False, quiet=True, out=tmp_path / name, **where).trials
            for name, where in (("there", {"cluster": cluster.scheduler_address}), ("here", {"workers": 0}))
        )
    assert there.drop("wall_s").equals(here.drop("wall_s"))


@pytest.mark.parametrize("workers", [0, 1])
def test_a_fatal_error_ends_the_run(workers):
    with pytest.raises(ValueError, match="three"), started(workers) as pool:
        run(pool, complain, range(6), fatal=(ValueError,))
