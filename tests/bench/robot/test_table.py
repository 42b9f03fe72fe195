"""What a run ends with on a terminal of 80 columns: few lines, whole words, deciding numbers, no idle p."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from experiments import Check, Outcome
from experiments.bench import registry
from experiments.bench.engine.terminal import out_console
from experiments.bench.judging.verdict import Verdict
from experiments.bench.robot.plan import plan
from experiments.bench.robot.summary import Report
from experiments.bench.robot.table import show
from tests.bench.judging.test_replicates import rows_of

CHECKS = {
    "C15": Check("59.5 spikes at 6 cm/s, +14.2 against 45.2 at 10", 14.2, 1.0, "at least", asks="+1 or more"),
    "C29": Check("window from centre to centre: 33.0 spikes at 6 cm/s, -0.5 against 33.5 at 10", -0.5, 1.0, "at least",
                 asks="+1 or more"),
}  # fmt: skip
"""The checks of the speed tests at their longest."""
MEASURED = "mean spikes at 2 cm/s: 0.0 [0.0, 0.0], 4 cm/s: 44.2 [41.0, 47.5]"


@pytest.fixture
def narrow(monkeypatch):
    monkeypatch.setattr(out_console, "width", 80)
    monkeypatch.setattr(out_console, "width_known", True)


def report(models=("dsnn",), comparisons=()):
    """A run of the paper's speed tests, with a verdict on each of its two claims."""
    rows = rows_of(plan(registry.load("speed"), list(models), (), 4, 0).specs())
    verdicts = [
        Verdict.of((claim, "in the paper's words", "paper"), [Outcome.of([check], MEASURED, "tau +0.90, p = 0.0286")])
        for claim, check in CHECKS.items()
    ]
    folder = Path("runs/speed-20260101-120000")
    return Report(folder, "speed_cm_s", "spikes", rows, [], verdicts, list(comparisons), "", [], [])


def test_a_run_is_told_in_twelve_lines_of_whole_words(narrow, capsys):
    show(report(), recordings=True)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) <= 12 and all(len(line) <= 80 for line in lines), "\n".join(lines)
    assert {line.split()[0] for line in lines[1:5]} == {"2", "4", "6", "10"}, "a row for each speed"
    words = " ".join(" ".join(lines).split())
    for claim, check in CHECKS.items():
        assert re.search(rf"{claim} held in [01] of 1 replicate: [A-Z][^;]+; {re.escape(check.text)}", words)
    assert "p = " not in words and MEASURED not in words, "claims.json has these"
    assert "runs/speed-20260101-120000: figure.png, trials.parquet, claims.json" in words


def test_in_a_pipe_no_line_is_longer_than_100_and_no_word_is_broken(monkeypatch, capsys):
    monkeypatch.setattr(out_console, "width_known", False)
    monkeypatch.setattr(out_console, "width", 100)
    show(report(), recordings=True)
    text = capsys.readouterr().out
    assert 80 < max(map(len, text.splitlines())) <= 100, text
    for check in CHECKS.values():
        assert set(check.text.split()) <= set(text.replace(";", " ").split())


def test_verdicts_of_a_model_that_failed_in_every_trial_are_told_apart(narrow, capsys):
    usual = report()
    lost = [replace(verdict, model=model) for model in ("dsnn", "lost") for verdict in usual.verdicts]
    show(replace(usual, verdicts=lost), recordings=False)
    words = capsys.readouterr().out
    assert "C15 (dsnn)" in words and "C15 (lost)" in words


@pytest.mark.parametrize(("n", "shown"), [(4, "-"), (5, "-"), (6, "0.0312")])
def test_pairs_that_can_carry_no_p_have_a_dash(narrow, capsys, n, shown):
    row = {"speed_cm_s": 6.0, "model": "dsnn", "against": "emd", "n": n, "mean_difference": 2.0, "rank_biserial": 1.0,
           "test": "Wilcoxon signed-rank, exact", "p": 2.0 ** (1 - n), "p_holm": 2.0 ** (1 - n)}  # fmt: skip
    show(report(comparisons=[row]), recordings=False)
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "dsnn - emd" in line]
    assert line.split()[-1] == shown
