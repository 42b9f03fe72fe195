"""Every target of the Makefile, run with programs that note how they are called: each call is one that works.

The scripts themselves run at their smallest: benchmarks and tools/eye.py in test_benchmarks.py, tools/results.py in
test_results.py, tools/sizes.py in test_sizes.py, the documentation's in tests/site, commands in tests/bench.
"""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import tarfile
import tomllib
from pathlib import Path

import pytest
from PIL import Image, ImageSequence

from experiments.cli import main
from tests.helpers.chapters import ROOT, check_options
from tools import release

PROGRAM = """#!/bin/sh
printf '%s\\037' "${0##*/}" "$@" >>"$CALLS"; printf '\\036' >>"$CALLS"
case "${0##*/} $2" in "python import "*) exit 1; esac  # none of the packages is there yet: set-up installs them
"""
PROGRAMS = ("colias", "python", "ruff", "mypy", "sphinx-build")
OUTSIDE = ("python3", "uv", "npm", "node", "apt-get", "sudo", "chromium")
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
TARGETS = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)


@pytest.fixture(scope="module")
def calls(tmp_path_factory) -> dict[str, list[list[str]]]:
    """Each target -> the programs that it calls, with their arguments."""
    folder = tmp_path_factory.mktemp("project")
    for name in ("Makefile", "pyproject.toml", "requirements.lock", "tools/setup.sh", "tools/playground/package.json"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, folder / name)
    bins = [(folder / ".venv/bin", PROGRAMS), (folder / "build/release/bin", ("python",)), (folder / "bin", OUTSIDE)]
    for place, name in ((place, name) for place, names in bins for name in names):
        place.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(PROGRAM)
        (place / name).chmod(0o755)
    noted = {}
    for target in sorted(TARGETS, key=lambda name: (name == "clean", name != "setup")):
        file = folder / "calls"
        file.write_bytes(b"")
        environment = {"PATH": f"{folder / 'bin'}:/usr/bin:/bin", "CALLS": str(file), "HOME": str(folder)}
        done = subprocess.run(
            ["make", target], cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, f"make {target}: {done.stderr}"
        noted[target] = [call.split("\037")[:-1] for call in file.read_text().split("\036")[:-1]]
    assert not (folder / ".venv").exists() and not (folder / "build").exists()
    return noted


def of(calls, program: str, *first: str) -> list[list[str]]:
    """The arguments of a program's calls that begin so."""
    every = (call[1:] for found in calls.values() for call in found if call[0] == program)
    return [arguments[len(first) :] for arguments in every if arguments[: len(first)] == list(first)]


def test_every_target_calls_something(calls):
    assert {target for target, found in calls.items() if not found} == {"clean"}
    assert {call[0] for found in calls.values() for call in found} >= {*PROGRAMS, "npm", "uv"}


def test_commands_and_modules_are_there(calls):
    assert len(of(calls, "colias")) >= 8
    for arguments in of(calls, "colias"):
        check_options(arguments)
    modules = {module for module, *_ in of(calls, "python", "-m")}
    assert modules == {"benchmarks", "pytest", "pip", "venv", "tools.results", "tools.release", "tools.sizes"}
    assert all(importlib.util.find_spec(module) for module in modules)


def test_tests_that_are_named_are_there(calls):
    for arguments in of(calls, "python", "-m", "pytest"):
        files = [ROOT / word for word in arguments if word.startswith("tests/")]
        assert all(file.exists() for file in files)
        if "-k" in arguments:
            words = arguments[arguments.index("-k") + 1].split(" or ")
            assert len(words) == len(files) and all(
                re.search(rf"^def test_\w*{word}", file.read_text(), re.MULTILINE)
                for word, file in zip(words, files, strict=True)
            )


def test_what_is_installed_and_locked_is_declared(calls):
    extras = {
        extra for call in of(calls, "python", "-m", "pip") for extra in re.findall(r"^\.\[(\w+)\]", " ".join(call[-2:]))
    }
    assert extras <= set(PYPROJECT["project"]["optional-dependencies"])
    groups = {call[call.index("--group") + 1] for call in of(calls, "uv", "pip", "compile")}
    assert groups == set(PYPROJECT["dependency-groups"])
    locks = {call[call.index("-o") + 1] for call in of(calls, "uv", "pip", "compile")}
    installed = {call[call.index("-r") + 1] for call in of(calls, "python", "-m", "pip", "install") if "-r" in call}
    assert locks == installed and all((ROOT / lock).is_file() for lock in locks)
    assert {"check"} == {call[-1] for call in of(calls, "npm", "run")}
    assert "check" in json.loads((ROOT / "tools/playground/package.json").read_text())["scripts"]


def test_the_first_picture_opens_in_mid_crossing(calls, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("docs").mkdir()
    pictures = [Image.new("L", (8, 8), grey) for grey in (0, 80, 160, 240)]
    pictures[0].save("docs/hero.webp", save_all=True, append_images=pictures[1:], lossless=True)
    (code,) = [call[2] for call in calls["hero"] if call[:2] == ["python", "-c"]]
    exec(code, {})
    with Image.open("docs/hero.webp") as film:
        greys = [frame.convert("L").getpixel((4, 4)) for frame in ImageSequence.Iterator(film)]
    assert greys == pytest.approx([160, 240, 0, 80], abs=4)


def test_the_source_distribution_has_what_the_wheel_is_built_from(tmp_path):
    release.do(release.sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", tmp_path)
    (path,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert {"pyproject.toml", "dsnn/native/CMakeLists.txt", "scenes/reference.xml", "experiments/speed.py"} <= names


HISTORY = ROOT / "CHANGELOG.md"
PAGES = [page for page in (*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "tools").rglob("*.md"))
         if page != HISTORY and "generated" not in page.parts]  # fmt: skip


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_a_command_in_a_sentence_is_one_that_there_is(page):
    """Those in blocks of code are run, or their options parsed: tests/helpers/chapters.py."""
    text = re.sub(r"^```.*?^```", "", page.read_text(), flags=re.DOTALL | re.MULTILINE)
    for words in (span.split() for span in re.findall(r"`([^`\n]+)`", text)):
        if words[0] == "make" and page.name != "real-robot.md":  # whose Makefile is the chip's
            assert {word for word in words[1:] if "=" not in word} <= {*TARGETS}, words
        elif words[:2] == ["python", "-m"]:
            assert importlib.util.find_spec(words[2]), words
        elif words[0] == "sh":
            assert os.access(ROOT / words[1], os.R_OK) and f"= {words[2]} ]" in (ROOT / words[1]).read_text(), words
        elif words[0] == "colias" and len(words) > 1:
            command, rest = main.parser(), words[1:]
            while rest and rest[0] in getattr(command, "commands", {}):
                command = command.commands[rest.pop(0)]
            known = {option for param in command.params for option in (*param.opts, *param.secondary_opts)}
            nested = rest.index("$(colias") if "$(colias" in rest else len(rest)
            assert command is not main.parser() or rest[0] == "--version", words
            assert {word for word in rest[:nested] if word.startswith("--")} <= known | {"--version"}, words
