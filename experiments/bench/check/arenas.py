"""The laws of every arena, of an .xml file or a .py file with an ``ARENA``: trials and envs take them for granted."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import numpy.typing as npt

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.scene import compile_arena
from colias_sim.streams import world
from experiments.bench.check.laws import LawBroken

Frame = npt.NDArray[np.uint8]

AWAY_CM, ASIDE_DEG = (8.0, 6.0, 10.0, 14.0, 20.0), (0.0, 15.0, -15.0, 28.0, -28.0)
"""Places of the stimulus from the camera at which it is looked for."""
SEEN_GREY, SEEN_PX = 8, 12
"""Grey levels by which so many pixels change where the camera sees the stimulus."""


def room(source: str) -> None:
    """It can be read and compiled, and stands in the room of 45 cm radius, in metres."""
    compile_arena(source)


def _scene(source: str) -> SceneConfig:
    return SceneConfig(arena=source, light_sd=0.0, turn_wall=False)


def robots(source: str) -> None:
    """The observer fits into its middle."""
    with Simulation(scene=_scene(source), robots={"observer": "colias"}, seeing=False) as simulation:
        simulation.reset({}, world(0))


def _look(simulation: Simulation, stimulus: Pose) -> Frame | None:
    """Return what the observer in the middle sees of a stimulus there; ``None`` where an obstacle stands there."""
    generator = world(0)
    try:
        simulation.reset({"stimulus": stimulus}, generator)
    except ValueError:
        return None
    return simulation.step(generator).luma


def _empty(simulation: Simulation) -> Frame:
    """Return what the observer sees of the arena alone: the stimulus is behind it, where no obstacle stands."""
    angles = (math.pi * (1 + turn / 8) for turn in range(8))
    seen = (_look(simulation, Pose(0.3 * math.cos(angle), 0.3 * math.sin(angle), 0.0)) for angle in angles)
    picture = next((frame for frame in seen if frame is not None), None)
    if picture is None:
        raise LawBroken("obstacles leave no place for a robot 30 cm behind the observer")
    return picture


def camera(source: str) -> None:
    """The camera sees a black robot before it."""
    forward = CameraConfig().forward_cm
    with Simulation(scene=_scene(source)) as simulation:
        empty = _empty(simulation).astype(int)
        for away, aside in product(AWAY_CM, map(math.radians, ASIDE_DEG)):
            place = Pose((forward + away * math.cos(aside)) / 100, away * math.sin(aside) / 100, -math.pi / 2)
            seen = _look(simulation, place)
            if seen is not None and (np.abs(seen - empty) >= SEEN_GREY).sum() >= SEEN_PX:
                return
    raise LawBroken(
        f"a black robot {min(AWAY_CM):g} to {max(AWAY_CM):g} cm before the camera changes no picture by {SEEN_GREY}"
        f" grey levels (their mean is {empty.mean():.0f} of 255): give it light, and move what stands before the middle"
    )


def pixels(source: str) -> None:
    """The same file gives the same pixels."""
    pictures = []
    for _ in range(2):
        with Simulation(scene=_scene(source)) as simulation:
            pictures.append(_empty(simulation))
    if not np.array_equal(pictures[0], pictures[1]):
        raise LawBroken("the camera's picture is another when the arena is compiled again")


LAWS = (room, robots, camera, pixels)
