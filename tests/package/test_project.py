"""What several files say of the project is the same in each: dependencies, the release, the commands of its hosts."""

import re
import tomllib
from pathlib import Path

import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parents[2]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
GROUPS = PYPROJECT["dependency-groups"]
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)", re.MULTILINE)


def pins(lock):
    """The versions of each package that a lock has, one for each Python or system."""
    versions = {}
    for name, version in PIN.findall((ROOT / lock).read_text()):
        versions.setdefault(canonicalize_name(name), set()).add(version)
    return versions


def test_the_documentation_s_packages_change_none_of_the_bench():
    """They are installed over it."""
    bench, docs = pins("requirements.lock"), pins("docs/requirements.lock")
    shared = bench.keys() & docs.keys()
    assert len(shared) > 5
    assert {name: docs[name] for name in shared if docs[name] != bench[name]} == {}


def test_the_locks_have_what_pyproject_asks_for():
    asked = {"requirements.lock": PYPROJECT["project"]["dependencies"] + GROUPS["dev"],
             "docs/requirements.lock": GROUPS["docs"]}  # fmt: skip
    for lock, requirements in asked.items():
        pinned = pins(lock)
        for requirement in map(Requirement, requirements):
            versions = pinned[canonicalize_name(requirement.name)]
            assert any(requirement.specifier.contains(version) for version in versions), (lock, requirement)


def test_the_latest_release_and_its_day_are_one():
    citation = (ROOT / "CITATION.cff").read_text()
    cited = [re.search(rf"^{key}: (\S+)$", citation, re.MULTILINE)[1] for key in ("version", "date-released")]
    latest = re.search(r"^## \[(\d\S*)\] - (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert cited == [latest[1], latest[2]]
    assert Version(PYPROJECT["project"]["version"]) >= Version(latest[1])


def test_hosts_run_targets_of_the_makefile_alone():
    """So that what a public host runs is what a person types."""
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    commands = [line for line in (ROOT / ".ci" / "run").read_text().splitlines() if line.startswith("make ")]
    for path in (ROOT / ".github" / "workflows").glob("*.yml"):
        for job in yaml.safe_load(path.read_text())["jobs"].values():
            commands += [line for step in job.get("steps", ()) for line in step.get("run", "").splitlines()]
    assert len(commands) > 5
    for command in commands:
        program, *words = command.split()
        assert program == "make" and words and {*words} <= targets, command
