"""What this machine has of what the bench needs, for ``colias doctor``."""

import importlib.metadata
import shutil
import sys
from collections.abc import Iterator

from packaging.requirements import Requirement

from dsnn import forms
from experiments.store.tables import cpu_features

Finding = tuple[str, str, str]
"""Whether it is there (``ok``, ``optional`` or ``missing``), what was looked at, and what was found or what to do."""

PROJECT = "colias-sim"
TOOLS = {"arm-none-eabi-gcc": "gcc-arm-none-eabi", "qemu-system-arm": "qemu-system-arm"}
"""Program -> the package that has it."""


def examine() -> Iterator[Finding]:
    """Yield what is found, one thing after another."""
    yield "ok", "python", f"{sys.version.split()[0]} at {sys.executable}"
    yield from packages()
    yield from rendering()
    yield "ok", "cpu", cpu_features()
    note = forms.note()
    yield "optional" if note else "ok", "network", note or forms.chosen()
    for program, package in TOOLS.items():
        place = shutil.which(program)
        yield ("ok", program, place) if place else ("optional", program, f"for colias firmware: install {package}")


def packages() -> Iterator[Finding]:
    """Compare the packages that are installed with the ranges that this release and its extras declare."""
    needed = [Requirement(text) for text in importlib.metadata.requires(PROJECT) or []]
    for extra in ("", *(importlib.metadata.metadata(PROJECT).get_all("Provides-Extra") or ())):
        asked = [one for one in needed if one.marker is None or one.marker.evaluate({"extra": extra})]
        wrong = ", ".join(f"{one.name}{one.specifier}" for one in asked if not _installed(one))
        state = "ok" if not wrong else "optional" if extra else "missing"
        package = f"{PROJECT}[{extra}]" if extra else PROJECT
        there = package if extra else f"{PROJECT} {importlib.metadata.version(PROJECT)}"
        remedy = f"lacks {wrong}: pip install '{package}'"
        yield state, f"extra [{extra}]" if extra else "packages", remedy if wrong else there


def _installed(needed: Requirement) -> bool:
    try:
        return needed.specifier.contains(importlib.metadata.version(needed.name), prereleases=True)
    except importlib.metadata.PackageNotFoundError:
        return False


def rendering() -> Iterator[Finding]:
    """Draw the reference frame, and compare it with those that are known."""
    try:
        from colias_sim import gl, reference  # not before: this chooses what draws

        pixels = reference.reference_hash()
    except OSError as error:
        yield "missing", "renderer", str(error)
        return
    yield "ok", "renderer", gl.renderer()
    known = f"as on {reference.KNOWN[pixels]}" if pixels in reference.KNOWN else "not known: numbers may differ"
    yield "ok", "reference frame", f"{pixels}, {known}"
