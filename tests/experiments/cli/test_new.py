"""Every file that ``colias new`` writes runs as it is, and its comments' commands too; bad names write nothing."""

import re

import pytest

import experiments
from experiments.base.errors import UsageError
from experiments.base.user_code import declared
from experiments.cli import main
from experiments.cli.new import KINDS, write
from experiments.store import workers
from tests.helpers.envs import end_after

NAME, STEM = "of-my-own2", "of_my_own2"
SHORT = {
    "behave": ["--episodes", "1", "--no-recordings", "--no-baselines"],
    "run": ["--no-recordings"],
    "watch": ["--no-view"],
    "run speed": ["--no-recordings", "--repeats", "1", "--set", "experiment.speeds_cm_s=30"],
}
"""Command, or with its first argument -> what makes it short, and asks for no screen."""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workers, "worker_count", lambda given: 0)
    end_after(30, monkeypatch)
    return tmp_path


def commands(text: str) -> list[list[str]]:
    """The commands that a file's comments name."""
    lines = re.findall(r"colias ((?:[\w./=-]*[\w/=])(?: [\w./=-]*\w)*)", "\n".join(re.findall(r"^# .*", text, re.M)))
    return [line.split() for line in lines]


@pytest.mark.parametrize("kind", KINDS)
def test_the_file_declares_what_it_was_asked_for_by_its_name(kind, folder):
    assert write(kind, NAME, folder) == folder / f"{STEM}.py"
    entry = declared(folder / f"{STEM}.py", kind.upper())
    if kind == "arena":
        assert f'model="{NAME}"' in entry()
    else:
        assert NAME in (getattr(entry, "name", ""), getattr(entry, "id", ""))


@pytest.mark.parametrize("kind", KINDS)
def test_its_three_comments_name_commands_that_work(kind, folder, capsys):
    assert main.command(["new", kind, NAME]) == 0
    text = (folder / f"{STEM}.py").read_text()
    assert re.findall(r"^# (\d)\. ", text, re.MULTILINE) == ["1", "2", "3"]
    first = ["colias", KINDS[kind][1], f"{STEM}.py"]
    assert " ".join(first) in capsys.readouterr().out
    named = commands(text)
    assert named[0][:2] == first[1:], "the command that is told is the first of the file"
    for words in named:
        more = SHORT.get(" ".join(words[:2]), SHORT.get(words[0], []))
        assert main.command([*words, *more]) == 0, words
    for run in map(experiments.load, (folder / "runs").glob("*")):
        claims = [row for row in run.claims.to_dicts() if row["experiment"] == NAME]
        assert run.name != NAME or claims, "an experiment to begin with has a claim"
        assert all(row["unjudged"] == 0 for row in claims), claims


def test_nothing_is_overwritten(folder):
    (folder / "mine.py").write_text("x = 1\n")
    with pytest.raises(UsageError):
        main.command(["new", "model", "mine"])
    assert (folder / "mine.py").read_text() == "x = 1\n"
