"""The public names of the packages: what the API pages have, and what the tests of docstrings look at."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Mapping

OURS = ("experiments", "colias_sim", "dsnn", "scenes")
PACKAGES = ("experiments", "colias_sim", "colias_sim.envs", "colias_sim.calibrate", "dsnn", "dsnn.stimuli")
"""Packages whose ``__all__`` is public."""

BEYOND: Mapping[str, tuple[str, ...]] = {
    "colias_sim.envs.base": ("ColiasEnv",),
    "colias_sim.envs.options": ("STRICT", "EnvOptions"),
    "colias_sim.gl": ("renderer",),
    "dsnn.frames": ("luma",),
    "dsnn.onboard.dead_zone": ("DeadZone", "dead_zone"),
    "dsnn.onboard.error": ("ErrorReport", "compare"),
    "dsnn.video": ("Video",),
    "experiments.behaviours": ("BEHAVIOURS", "ProportionalIntegral", "escape"),
    "scenes": ("ARENAS", "ROBOTS", "arena_path"),
}
"""Module -> its names that are public without an ``__all__``, as chapters of the documentation import them."""


def exported() -> dict[str, object]:
    """Return every public name in full -> its object, in the order of the packages."""
    listed = [(module, name) for module in PACKAGES for name in importlib.import_module(module).__all__]
    listed += [(module, name) for module, names in BEYOND.items() for name in names]
    return {f"{module}.{name}": getattr(importlib.import_module(module), name) for module, name in listed}


def public() -> dict[str, object]:
    """Return the names that have a page -> their objects. A class or function that two packages export has one page."""
    by_name: dict[str, object] = {}
    for name, thing in exported().items():
        twice = not is_constant(thing) and any(thing is other for other in by_name.values())
        if not twice:
            by_name[name] = thing
    return by_name


def is_constant(thing: object) -> bool:
    """Tell whether an object is neither a class nor a function."""
    return not inspect.isclass(thing) and not inspect.isfunction(thing)


def places(names: Mapping[str, object]) -> dict[str, str]:
    """Return where each class and function is defined -> its public name, both in full."""
    return {
        f"{thing.__module__}.{thing.__qualname__}": name
        for name, thing in names.items()
        if inspect.isclass(thing) or inspect.isfunction(thing)
    }
