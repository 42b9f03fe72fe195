"""What a plan tells of a run before it is done."""

from dataclasses import dataclass

import polars as pl
import pytest

from experiments.base.errors import UsageError
from experiments.cli.main import command
from experiments.store.asked import Asked
from experiments.store.plan import SAMPLED, Plan, forecast
from experiments.store.tables import TrialRecord


@dataclass
class Job:
    index: int
    seed: int = 0
    fps: float = 30.0
    models: tuple = ()

    def label(self):
        return f"condition {self.index % 3}"


def test_a_forecast_is_that_of_a_few_trials_as_many_times_as_there_are():
    """Spread over the whole run: a trial of number n leaves a recording of n bytes here, and no tables."""
    played = []

    def work(job):
        played.append(job.index)
        return TrialRecord(job.index, (), pl.DataFrame(), bytes(job.index))

    told = forecast(Plan(Asked(kind="trials"), "made", [Job(index) for index in range(1000)], work), width=2)
    assert len(set(played)) == SAMPLED and len(played) == 2 * SAMPLED
    assert (told["conditions"], told["trials"]) == (3, 1000) and told["minutes"] > 0.0
    assert told["MB"] == pytest.approx(sum(range(1000)) / 1e6, rel=0.01)


def test_a_dry_run_writes_nothing_and_counts_what_a_run_has(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    few = ["--set", "experiment.speeds_cm_s=25,30", "--set", "experiment.distances_cm=5", "--dry-run", "--workers", "0"]
    assert command(["run", "speed", "--repeats", "2", *few]) == 0
    swept = ["--over", "processor.every=1,2", "--repeats", "2", "--replicates", "3"]
    assert command(["sweep", "speed", *swept, *few]) == 0
    lines = capsys.readouterr().out.splitlines()
    counted = [[int(word) for word in line.split() if word.isdigit()][:2] for line in lines]
    assert counted == [[2, 4], [2, 12]] and not list(tmp_path.iterdir())
    with pytest.raises(UsageError):
        command(["sweep", "model-claims", "--dry-run"])
