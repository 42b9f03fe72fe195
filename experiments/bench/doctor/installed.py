"""Checks of what is installed: Python, the packages, the network's forms, the viewer, the extras."""

from __future__ import annotations

import importlib.metadata
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import InvalidRequirement, Requirement

from experiments.bench.doctor.finding import Finding
from experiments.bench.run.streams import stream

PROJECT = "colias-sim"
LEAST_PYTHON = (3, 11)
CHECKOUT = Path(__file__).parents[3]
"""The folder of the packages: a checkout where it has ``pyproject.toml``, otherwise of an environment."""
SHOWN = 5
"""Packages that a line names; it counts the others."""
STEPS = 100
"""Frames by which a form of the network is timed."""
TOOLS = {
    "arm-none-eabi-gcc": ("gcc-arm-none-eabi", "colias firmware"),
    "qemu-system-arm": ("qemu-system-arm", "colias firmware"),
    "chromium": ("chromium", "the tests of the report's page"),
}
"""Program -> Debian's package that has it, and what needs it."""


def _install(extra: str = "") -> str:
    """Return the command that installs this release here, with its dependencies or with those of an extra."""
    name = "." if (CHECKOUT / "pyproject.toml").is_file() else PROJECT
    return f"pip install '{name}[{extra}]'" if extra else f"pip install --upgrade {name}"


def _setup() -> str:
    """Return what to do where this release lacks something that it depends on."""
    if (CHECKOUT / "pyproject.toml").is_file():
        return f"run 'make setup' in the checkout, or '{_install()}' in an environment of your own"
    return f"run '{_install()}'"


def python() -> Finding:
    """Look at Python's own version."""
    text = f"{sys.version.split()[0]} at {sys.executable}"
    if sys.version_info[:2] < LEAST_PYTHON:
        return Finding("python", "fails", text, f"install Python 3.11 or later; then {_setup()}")
    return Finding("python", "ok", text)


def packages() -> Finding:
    """Compare the packages that are installed with the ranges that this release declares."""
    try:
        declared = importlib.metadata.requires(PROJECT) or []
    except importlib.metadata.PackageNotFoundError:
        return Finding("packages", "fails", f"{PROJECT} is not installed in this environment", _setup())
    wrong = [problem for text in declared if (problem := _unmet(text))]
    version = importlib.metadata.version(PROJECT)
    if wrong:
        return Finding("packages", "fails", f"{PROJECT} {version}: {_some(wrong)}", _setup())
    return Finding("packages", "ok", f"{PROJECT} {version}, and all that it depends on")


def _unmet(text: str, extra: str = "") -> str:
    """Return what is wrong with one requirement of the project's own, in words; empty where it is met, or is not one of
    the extra; without an extra those are looked at that everything needs.
    """
    needed = Requirement(text)
    if extra and needed.marker is None:
        return ""
    if needed.marker is not None and not needed.marker.evaluate({**_environment(), "extra": extra}):
        return ""
    try:
        installed = importlib.metadata.version(needed.name)
    except importlib.metadata.PackageNotFoundError:
        return f"{needed.name} is missing"
    fits = needed.specifier.contains(installed, prereleases=True)
    return "" if fits else f"{needed.name} is {installed}, needed is {needed.specifier}"


def lock() -> Finding:
    """Compare the packages that are installed with ``requirements.lock``, by which the documented numbers were made."""
    path = CHECKOUT / "requirements.lock"
    if not path.is_file():
        return Finding("lock", "ok", "no requirements.lock beside the packages: not a checkout")
    try:
        wanted = dict(_locked(path))
    except (OSError, ValueError) as error:
        return Finding("lock", "fails", f"{path} cannot be read: {error}", "restore it: git checkout requirements.lock")
    differing = []
    for name, version in wanted.items():
        try:
            installed = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            installed = "missing"
        if installed != version:
            differing.append(f"{name} is {installed}, locked is {version}")
    if differing:
        return Finding("lock", "notice", f"{len(differing)} of {len(wanted)} differ: {_some(differing)}", _setup())
    return Finding("lock", "ok", f"{len(wanted)} packages as in requirements.lock")


def _locked(path: Path) -> Iterator[tuple[str, str]]:
    """Yield the packages that a lock names for this machine, with their versions."""
    for line in path.read_text(encoding="utf-8").splitlines():
        text = line.rstrip("\\").strip()
        if not text or text.startswith(("#", "--")):
            continue
        try:
            needed = Requirement(text)
        except InvalidRequirement as error:
            raise ValueError(" ".join(str(error).split())[:120]) from None
        pinned = re.fullmatch(r"==([^,]+)", str(needed.specifier))
        if pinned is None:
            raise ValueError(f"{text[:60]} names no one version")
        if needed.marker is None or needed.marker.evaluate(_environment()):
            yield needed.name, pinned[1]


def _environment() -> dict[str, str]:
    return {name: str(value) for name, value in default_environment().items()}


def _some(problems: list[str]) -> str:
    more = f", and {len(problems) - SHOWN} more" if len(problems) > SHOWN else ""
    return "; ".join(problems[:SHOWN]) + more


def network() -> list[Finding]:
    """Say which forms of the network there are, and time a frame of each."""
    import numpy as np

    from dsnn import DSNN, DSNNParams, forms, native

    frames = stream("doctor.frames", 0).integers(0, 256, (STEPS, 72, 99), dtype=np.uint8)
    findings = []
    for form in forms.FORMS:
        if form == "native" and (reason := native.missing()):
            text = f"the native form {reason}: the DSNN runs as its reference, some 17 times slower"
            remedy = f"install a C compiler and Python's headers (Debian: gcc python3-dev); then {_setup()}"
            findings.append(Finding("network, native", "notice", text, remedy))
            continue
        model = DSNN((72, 99), DSNNParams(), form=form)
        model.step(frames[0])
        begun = time.perf_counter()
        for frame in frames:
            model.step(frame)
        spent = 1e3 * (time.perf_counter() - begun) / STEPS
        findings.append(Finding(f"network, {form}", "ok", f"{spent:.3f} ms a frame of 99x72"))
    try:
        chosen = forms.chosen()
    except forms.FormError as error:
        return [*findings, Finding("network, chosen", "fails", str(error), f"unset {forms.VARIABLE}")]
    return [*findings, Finding("network, chosen", "ok", chosen)]


def viewer() -> Finding:
    """Ask the Rerun viewer for its version."""
    place = shutil.which("rerun", path=str(Path(sys.executable).parent)) or shutil.which("rerun")
    if place is None:
        return Finding("rerun viewer", "fails", "the program rerun is not beside Python", _setup())
    try:
        done = subprocess.run([place, "--version"], capture_output=True, text=True, timeout=60, check=True)
    except (OSError, subprocess.SubprocessError) as error:
        return Finding("rerun viewer", "fails", f"{place} does not run: {type(error).__name__}", _setup())
    return Finding("rerun viewer", "ok", " ".join(done.stdout.split()[:2]))


def extras() -> list[Finding]:
    """Say which extras and tools are there; nothing but the commands named needs them."""
    findings = []
    try:
        names = importlib.metadata.metadata(PROJECT).get_all("Provides-Extra") or []
        declared = importlib.metadata.requires(PROJECT) or []
    except importlib.metadata.PackageNotFoundError:
        names, declared = [], []
    for extra in names:
        lacking = [problem for text in declared if (problem := _unmet(text, extra))]
        message = f"not installed: {_some(lacking)}" if lacking else "installed"
        remedy = _install(extra) if lacking else ""
        findings.append(Finding(f"extra [{extra}]", "optional" if lacking else "ok", message, remedy))
    for program, (package, needing) in TOOLS.items():
        place = shutil.which(program)
        remedy = "" if place else f"only for {needing}: apt-get install {package}"
        findings.append(Finding(program, "ok" if place else "optional", place or "not installed", remedy))
    return findings
