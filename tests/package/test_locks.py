"""The locks: of the bench and its tests, and of the documentation, which is installed over it."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).parents[2]
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s;\\]+)", re.MULTILINE)


def pins(lock: str) -> dict[str, set[str]]:
    versions: dict[str, set[str]] = {}
    for name, version in PIN.findall((ROOT / lock).read_text()):
        versions.setdefault(canonicalize_name(name), set()).add(version)
    return versions


def wanted(requirements: list[str]) -> dict[str, Requirement]:
    return {canonicalize_name(requirement.name): requirement for requirement in map(Requirement, requirements)}


def test_the_documentation_s_packages_change_none_of_the_bench():
    bench, docs = pins("requirements.lock"), pins("docs/requirements.lock")
    shared = bench.keys() & docs.keys()
    assert len(shared) > 5
    assert {name: docs[name] for name in shared if docs[name] != bench[name]} == {}


def test_the_locks_have_what_pyproject_asks_for():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())
    groups = project["dependency-groups"]
    asked = {"requirements.lock": project["project"]["dependencies"] + groups["dev"],
             "docs/requirements.lock": groups["docs"]}  # fmt: skip
    for lock, requirements in asked.items():
        pinned = pins(lock)
        for name, requirement in wanted(requirements).items():
            assert any(requirement.specifier.contains(version) for version in pinned[name]), (lock, name)
