"""What this machine has of what the bench needs, for ``colias doctor``."""

from __future__ import annotations

import importlib.metadata
import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Literal

import numpy as np
from packaging.requirements import Requirement

from dsnn import DSNN, DSNNParams, forms
from experiments.bench.run.streams import stream

State = Literal["ok", "optional", "missing"]
Finding = tuple[State, str, str]
"""Whether it is there, what was looked at, and what was found or what to do."""

PROJECT = "colias-sim"
FRAMES = 100
"""Frames by which the network and the camera are timed."""
TOOLS = {
    "rerun": ("rerun-sdk", "colias view"),
    "arm-none-eabi-gcc": ("gcc-arm-none-eabi", "colias firmware"),
    "qemu-system-arm": ("qemu-system-arm", "colias firmware"),
}
"""Program -> the package that has it, and what needs it."""


def examine() -> Iterator[Finding]:
    """Yield what is found, one thing after another."""
    yield "ok", "python", f"{sys.version.split()[0]} at {sys.executable}"
    yield from packages()
    yield from rendering()
    yield network()
    places = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    for program, (package, needing) in TOOLS.items():
        place = shutil.which(program, path=places)
        yield ("ok", program, place) if place else ("optional", program, f"only for {needing}: install {package}")


def packages() -> Iterator[Finding]:
    """Compare the packages that are installed with the ranges that this release and its extras declare."""
    needed = [Requirement(text) for text in importlib.metadata.requires(PROJECT) or []]
    for extra in ("", *(importlib.metadata.metadata(PROJECT).get_all("Provides-Extra") or ())):
        wrong = ", ".join(
            f"{one.name}{one.specifier}" for one in needed if _extra_of(one, extra) and not _installed(one)
        )
        name = f"extra [{extra}]" if extra else "packages"
        remedy = f"pip install '{PROJECT}[{extra}]'" if extra else f"pip install --upgrade {PROJECT}"
        state: State = "optional" if extra else "missing"
        version = f"{PROJECT} {importlib.metadata.version(PROJECT)}"
        yield (state, name, f"lacks {wrong}: {remedy}") if wrong else ("ok", name, "installed" if extra else version)


def _extra_of(needed: Requirement, extra: str) -> bool:
    """Return whether an extra needs a package that is not needed without it; of no extra, whether all need it."""
    asked, always = (needed.marker is None or needed.marker.evaluate({"extra": name}) for name in (extra, ""))
    return asked and bool(always != bool(extra))


def _installed(needed: Requirement) -> bool:
    try:
        return needed.specifier.contains(importlib.metadata.version(needed.name), prereleases=True)
    except importlib.metadata.PackageNotFoundError:
        return False


def rendering() -> Iterator[Finding]:
    """Draw the reference frame, compare it with those that are known, and time the robot's camera."""
    try:
        from colias_sim import Pose, Simulation, gl, reference  # not before: this chooses what draws

        pixels = reference.reference_hash()
    except OSError as error:
        yield "missing", "renderer", str(error)
        return
    renderer = gl.renderer()
    yield "ok", "renderer", f"{renderer}: in software" if gl.is_software(renderer) else renderer
    known = reference.KNOWN.get(pixels)
    yield (
        "ok",
        "reference frame",
        f"{pixels}, {f'as on {known}' if known else 'not known: numbers may differ a little'}",
    )
    with Simulation() as simulation:
        draw = stream("doctor.frames", 0)
        simulation.reset({"stimulus": Pose(0.1, 0.0, 0.0)}, draw)
        spent = _milliseconds(lambda: simulation.step(draw))
    yield "ok", "robot's camera", f"{spent:.2f} ms a frame of 99x72, physics included"


def network() -> Finding:
    """Time a frame of the network, in the form that runs."""
    frame = stream("doctor.frames", 0).integers(0, 256, (72, 99), dtype=np.uint8)
    model = DSNN((72, 99), DSNNParams())
    found = f"{forms.chosen()}, {_milliseconds(lambda: model.step(frame)):.3f} ms a frame of 99x72"
    return ("optional", "network", f"{found}; {note}") if (note := forms.note()) else ("ok", "network", found)


def _milliseconds(step: Callable[[], object]) -> float:
    step()
    begun = time.perf_counter()
    for _ in range(FRAMES):
        step()
    return 1e3 * (time.perf_counter() - begun) / FRAMES
