"""A small part of the attack for every run of the tests; `make attack` is the whole of it."""

from __future__ import annotations

import pytest

from tests.attack import commands, interrupts, models
from tests.attack.commands import show
from tests.attack.damages import DAMAGES, Damage
from tests.attack.folders import problems as damaged
from tests.attack.judging import expect_none, problems, refusal
from tests.attack.model_files import Case
from tests.attack.processes import Interrupt

TOGETHER = (
    "raises-at-5", "raises-system-exit-in-build", "raises-keyboard-interrupt", "raises-markup", "answers-none",
    "answers-hs-string", "answers-spikes-1.5", "writes-through-base", "raises-on-float-errors",
)  # fmt: skip
DECLARED = ("channels-a-string", "called-newline")
DAMAGED = (
    ("robot", "trials.parquet-flipped-3"), ("robot", "experiment.json-brackets"), ("robot", "trial-999-in-both"),
    ("robot", "failures.json-trial-list"), ("robot", "frame-gone"), ("robot", "trials.parquet-dangles"),
)  # fmt: skip
MOMENTS = (
    ("run", 0.4, True),
    ("run", 1.6, True),
    ("watch", 0.7, False),
    ("stimulus", 0.3, False),
    ("list", 0.2, False),
)


def _models(*names: str) -> tuple[Case, ...]:
    return tuple(case for case in models.EVERY if case.name in names)


@pytest.mark.parametrize("command", [commands.RUN, commands.WATCH], ids=lambda command: command.name)
def test_models_lose_their_own_part_alone(command, folder, honest):
    cases = _models(*TOGETHER)
    assert len(cases) == len(TOGETHER)
    expect_none(problems(command, cases, folder, honest(command)))


@pytest.mark.parametrize("name", DECLARED)
def test_a_wrong_declaration_is_refused(name, folder):
    (case,) = _models(name)
    commands.furnish(folder)
    expect_none(refusal(show(commands.WATCH, folder, [case.write(folder)])))


def _damage(kind: str, name: str) -> Damage:
    return next(damage for damage in DAMAGES if (damage.kind, damage.name) == (kind, name))


@pytest.mark.parametrize(("kind", "name"), DAMAGED)
def test_a_damaged_folder_is_refused_or_mended(kind, name, run_of, tmp_path):
    folder, whole = run_of(kind)
    expect_none(damaged(_damage(kind, name), folder, tmp_path / "work", whole))


@pytest.mark.parametrize(("name", "after_s", "group"), MOMENTS)
def test_an_interrupt_ends_a_command_quietly(name, after_s, group, folder):
    (job,) = [job for job in interrupts.JOBS if job.name == name]
    interrupts.furnish(folder)
    commands.film(folder / "film.avi", 1500)
    expect_none(interrupts.problems(job, Interrupt(after_s, group), folder))
