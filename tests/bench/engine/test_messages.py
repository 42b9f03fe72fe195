"""A wrong use is told in one line: what was given, and what is legal. Called in this process, as `colias` calls it."""

from __future__ import annotations

import pytest

from experiments import UsageError
from experiments.bench.cli import main as cli_main

HUGE = str(10**30)


def refusal(*arguments: str) -> str:
    """The one line in which a command line is refused."""
    with pytest.raises(UsageError) as refused:
        cli_main.command([*arguments])
    assert "\n" not in str(refused.value)
    return str(refused.value)


# --- numbers that no machine can plan --------------------------------------------------------------------------------


def test_replicates_are_counted_with_the_points_of_the_grid():
    """Each number is legal by itself; their product is not."""
    axis = ",".join(str(value / 100) for value in range(100))
    asked = ("sweep", "general", "--over", f"camera.read_noise={axis}", "--claims", "C14", "--replicates", "9999")
    message = refusal(*asked)
    assert message.startswith("--replicates must be between 1 and ")


SEEDED = (
    "run speed", "run clean", "sweep speed --over dsnn.n_con=4,5", "leaderboard",
    "sweep clean --over dsnn.n_con=4,5", "tune", "reproduce", "behave fixation", "train",
)  # fmt: skip


@pytest.mark.parametrize("command", SEEDED)
def test_a_seed_that_no_table_holds_is_refused_at_once(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in (HUGE, "-1"):
        message = refusal(*command.split(), "--seed", seed)
        assert message.startswith("--seed must be between 0 and ")
    assert list(tmp_path.iterdir()) == []
