"""What a public host runs is what a person types: the workflows' steps, and .ci/run, call the Makefile alone."""

import re
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).parents[2]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TARGETS = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))


def jobs(path):
    return yaml.safe_load(path.read_text())["jobs"]


def unknown(command):
    """What of a command is not ``make`` with targets of the Makefile."""
    words = command.split()
    return [word for word in words[1:] if word not in TARGETS] if words[:1] == ["make"] and words[1:] else [command]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_each_step_runs_make_or_somebody_elses_action(path):
    for name, job in jobs(path).items():
        for step in job.get("steps", ()):
            assert not [word for line in step.get("run", "").splitlines() for word in unknown(line)], (name, step)


def test_the_machine_that_judges_changes_calls_the_makefile_too():
    lines = [line for line in (ROOT / ".ci" / "run").read_text().splitlines() if line.startswith("make ")]
    assert lines and not [word for line in lines for word in unknown(line)]
