"""A wrong use is told in one line: what was given, and what is legal. Called in this process, as `colias` calls it."""

from __future__ import annotations

import pytest

from experiments import UsageError
from experiments.bench.cli import main as cli_main

BIG, HUGE = str(10**12), str(10**30)


def refusal(*arguments: str) -> str:
    """The one line in which a command line is refused."""
    with pytest.raises(UsageError) as refused:
        cli_main.command([*arguments])
    assert "\n" not in str(refused.value)
    return str(refused.value)


# --- numbers that no machine can plan --------------------------------------------------------------------------------

COUNTS = {
    "run speed --repeats": "4 trials each; a run has up to 100,000",
    "run clean --repeats": "12 clips each",
    "sweep speed --over dsnn.n_con=4,5 --repeats": "4 trials each",
    "map speed --over dsnn.n_con=4,5 --repeats": "4 trials each",
    "map speed --over dsnn.n_con=4,5 --replicates": "from 1 to 100000",
    "map clean --over dsnn.n_con=4,5 --replicates": "from 1 to 100000",
    "leaderboard --repeats": "18 trials each",
    "behave straight --no-baselines --episodes": "from 1 to 100000",
    "behave fixation --episodes": "behaviours each",
}


@pytest.mark.parametrize("command", COUNTS)
def test_a_number_that_cannot_be_planned_is_refused_at_once(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    option = command.split()[-1]
    message = refusal(*command.split(), BIG)
    assert message.startswith(f"{option} {BIG}: legal is a whole number from 1 to ") and COUNTS[command] in message
    assert list(tmp_path.iterdir()) == []


def test_replicates_are_counted_with_the_points_of_the_grid():
    """Each number is legal by itself; their product is not."""
    axis = ",".join(str(value / 100) for value in range(100))
    asked = ("map", "general", "--over", f"camera.read_noise={axis}", "--claims", "C14", "--replicates", "9999")
    message = refusal(*asked)
    assert message.startswith("--replicates 9999: legal is a whole number from 1 to ")


SEEDED = (
    "run speed", "run clean", "sweep speed --over dsnn.n_con=4,5", "map speed --over dsnn.n_con=4,5", "leaderboard",
    "map clean --over dsnn.n_con=4,5", "leaderboard --atlas", "tune", "reproduce", "behave fixation", "train",
)  # fmt: skip


@pytest.mark.parametrize("command", SEEDED)
def test_a_seed_that_no_table_holds_is_refused_at_once(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in (HUGE, "-1"):
        message = refusal(*command.split(), "--seed", seed)
        assert message.startswith(f"--seed {seed}: legal is a whole number from 0 to ")
    assert list(tmp_path.iterdir()) == []
