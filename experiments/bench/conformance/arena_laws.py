"""The laws that every arena keeps, tried on one: what ``colias check`` asks of an .xml file, or one with an ``ARENA``.

Trials and envs take them for granted. Those of one's own trials in it are checked when these are planned.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.arena import Arena
from colias_sim.scene import compile_arena
from colias_sim.streams import world
from experiments.bench.conformance.laws import Finding, tried

Frame = npt.NDArray[np.uint8]

AWAY_CM, ASIDE_DEG = (8.0, 6.0, 10.0, 14.0, 20.0), (0.0, 15.0, -15.0, 28.0, -28.0)
"""Places of the stimulus from the camera at which it is looked for."""
BEHIND = Pose(-0.3, 0.0, 0.0)
"""A place of the stimulus out of view; others are tried where an obstacle stands there."""
SEEN_GREY, SEEN_PX = 8, 12
"""Grey levels by which so many pixels change where the camera sees the stimulus."""


def check(source: str) -> list[Finding]:
    """Try the laws on an arena, those that need a picture only where it can be compiled."""
    findings = []
    for law, (asks, question) in LAWS.items():
        findings.append(Finding(law, asks, tried(question, source)))
        if findings[-1].trouble and law in FIRST:
            break
    return findings


def _refused(question: Callable[[], object]) -> str:
    try:
        question()
    except ValueError as error:
        return str(error)
    return ""


def _reads(source: str) -> str:
    return _refused(lambda: Arena.read(source))


def _form(source: str) -> str:
    return _refused(lambda: Arena.read(source).spec())


def _room(source: str) -> str:
    return _refused(lambda: compile_arena(source))


def _again(source: str) -> str:
    return "" if Arena.read(source) == Arena.read(source) else "it, or a file that it names, is another when read again"


def _scene(source: str) -> SceneConfig:
    return SceneConfig(arena=source, light_sd=0.0, turn_wall=False)


def _robots(source: str) -> str:
    with Simulation(scene=_scene(source), robots={"observer": "colias"}, seeing=False) as simulation:
        return _refused(lambda: simulation.reset({}, world(0)))


def _look(simulation: Simulation, stimulus: Pose) -> Frame:
    """Return what the observer in the middle sees of a stimulus there; ``ValueError`` where that cannot stand there."""
    generator = world(0)
    simulation.reset({"stimulus": stimulus}, generator)
    return simulation.step(generator).luma


def _without(simulation: Simulation) -> Frame:
    for turn in range(8):
        angle = math.pi * (1 + turn / 8)
        try:
            return _look(simulation, Pose(0.3 * math.cos(angle), 0.3 * math.sin(angle), 0.0))
        except ValueError:
            continue
    return _look(simulation, BEHIND)


def _camera(source: str) -> str:
    forward = CameraConfig().forward_cm
    with Simulation(scene=_scene(source)) as simulation:
        empty = _without(simulation).astype(int)
        for away in AWAY_CM:
            for aside in ASIDE_DEG:
                angle = math.radians(aside)
                place = Pose((forward + away * math.cos(angle)) / 100, away * math.sin(angle) / 100, -math.pi / 2)
                try:
                    changed = np.abs(_look(simulation, place) - empty) >= SEEN_GREY
                except ValueError:  # an obstacle stands there
                    continue
                if changed.sum() >= SEEN_PX:
                    return ""
    return (
        f"a black robot at {len(AWAY_CM) * len(ASIDE_DEG)} places, {min(AWAY_CM):g} to {max(AWAY_CM):g} cm before the"
        f" camera, changes no picture by {SEEN_GREY} grey levels (the picture's mean is {empty.mean():.0f} of 255):"
        " give it light, and move what stands before the middle"
    )


def _pixels(source: str) -> str:
    with Simulation(scene=_scene(source)) as simulation:
        first = _without(simulation)
    with Simulation(scene=_scene(source)) as simulation:
        second = _without(simulation)
    return "" if np.array_equal(first, second) else "the camera's picture is another when the arena is compiled again"


LAWS: Mapping[str, tuple[str, Callable[[str], str]]] = MappingProxyType(
    {
        "files": ("the MJCF can be read, and all that it names lies in its folder or ships", _reads),
        "form": ("it has floor and wall, nothing in it moves, and its physics are those of every arena", _form),
        "room": ("it can be compiled, and stands in the room of 45 cm radius, in metres", _room),
        "again": ("it is the same whenever it is read", _again),
        "robots": ("the observer fits into its middle", _robots),
        "camera": ("the camera sees a black robot before it", _camera),
        "pixels": ("the same file gives the same pixels", _pixels),
    }
)
"""Name -> what it asks in words, and what says how an arena breaks it."""
FIRST = ("files", "form", "room", "again", "robots")
"""Laws without which the others cannot be tried."""
