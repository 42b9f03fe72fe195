"""CB-1, the frozen tasks of the benchmark: a table of declared experiments, and the digest that holds them.

Nothing here changes without a new name: `tests/experiments/paper/test_benchmark.py` compares the digest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from typing import Any

import scenes
from dsnn.stimuli import background
from experiments.base.files import plain
from experiments.base.user_code import sha256
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.declare.experiment import Angular, Design, Egomotion, Experiment, Listed, Translation
from experiments.judge.judge import SIGNED
from experiments.kinds import clips, trials
from experiments.paper.clips import SHADES
from experiments.settings.settings import watchers
from experiments.store.asked import Asked
from experiments.store.plan import Plan

NAME = "CB-1"
DIRECTION, LOOMING = ("hs", "vs"), ("looming",)
CONTROLS = ("frozen", "absent", "reversed")
"""The controls that a score is held against: a looming potential has no sign that a mirror turns."""
SPEEDS_CM_S, ANGLES_DEG, L_OVER_V_S = (4.0, 6.0, 10.0), (-15.0, 0.0, 15.0), (0.04, 0.08, 0.16, 0.32)
BACKGROUND_PX = (0.067, 0.25, 0.5, 1.0, 2.0, 5.0)
"""Leftward speeds of the background, px a frame."""
SQUARE = {"rows": 72, "columns": 99, "width": 25.0, "height": 25.0, "speed": 60.0}
GRATING = {"grey": 40.0, "background_grey": 127.5, "background": "grating"}
TRUE = {"truth": True, "controls": True}


@dataclass(frozen=True)
class Task:
    """A task: what is shown, and which models it is for.

    Parameters
    ----------
    name
        Its folder, and its name in tables.
    seconds
        What it costs the DSNN on two idle cores, s.
    channels
        It applies to models with any of these.
    declared
        The trials.
    values, options
        As of an `Asked`.
    """

    name: str
    seconds: float
    channels: tuple[str, ...]
    declared: Experiment | OfflineExperiment
    values: Mapping[str, Any] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    def plan(self, models: Sequence[str], seed: int) -> Plan[Any]:
        """Return the plan of its trials, shown to the models."""
        on_robot = self.declared.kind == "trials"
        kept = {"recordings": False, "frames": not on_robot, **self.options}
        asked = Asked(kind=self.declared.kind, declared=self.declared, models=tuple(models), only=True,
                      values=self.values, seed=seed, options=kept)  # fmt: skip
        return (trials if on_robot else clips).plan(asked)


DEPTHS = (Angular(motion, ANGLES_DEG, speed_cm_s=speed)
          for motion, speed in product(("approach", "recession"), (4.0, 10.0)))  # fmt: skip
CROSSINGS = Translation(SPEEDS_CM_S, (6.0, 10.0), "both")
MOTIONS = Listed(tuple(condition for design in (CROSSINGS, *DEPTHS) for condition in design.conditions()))
"""Twelve crossings, six approaches and six recessions, each from three angles at two speeds."""
TURNS = Egomotion((-5.0, -2.5, 2.5, 5.0), (), direction="both")


def _robot(name: str, summary: str, seconds: float, repeats: int = 1, design: Design = MOTIONS,
           channels: tuple[str, ...] = (*DIRECTION, *LOOMING), options: Mapping[str, Any] | None = None,
           values: Mapping[str, Any] | None = None) -> Task:  # fmt: skip
    declared = Experiment(name, summary, design, "speed_cm_s", repeats)
    return Task(name, seconds, channels, declared, values or {}, options or {})


def _clips(name: str, summary: str, seconds: float, channels: tuple[str, ...], shown: Iterator[Clip],
           repeats: int = 1) -> Task:  # fmt: skip
    return Task(name, seconds, channels, OfflineExperiment(name, summary, tuple(shown), ("dsnn",), (), repeats))


def _clutter() -> Iterator[Clip]:
    """Yield black rectangles that cross before a scene of the seed, four ways by six speeds of the background."""
    for speed, motion in product(BACKGROUND_PX, SIGNED):
        look = {"grey": 0.0, "columns": 320, "background_speed": -30.0 * speed, "motion": motion}
        size = (50.0, 90.0) if motion in ("rightward", "leftward") else (90.0, 50.0)
        yield Clip(
            f"{motion} at {speed:g} px", "cluttered", {**look, **dict(zip(("width", "height"), size, strict=True))}
        )


def _looming() -> Iterator[Clip]:
    """Yield dark and light squares on an even ground: looming, receding, crossing."""
    for shade, (grey, ground) in SHADES.items():
        greys = {"grey": grey, "background_grey": ground}
        for motion, ratio in product(("looming", "receding"), L_OVER_V_S):
            yield Clip(f"{shade} {motion} {ratio:g} s", "looming", {**greys, "motion": motion, "l_over_v_s": ratio})
        for motion in SIGNED:
            yield Clip(f"{shade} {motion}", "plain", {**SQUARE, **greys, "motion": motion})


def _moving() -> Iterator[Clip]:
    """Yield squares before a grating and before scenes, and backgrounds alone for 5 s."""
    for motion, ratio in product(("looming", "receding"), L_OVER_V_S):
        yield Clip(
            f"{motion} {ratio:g} s before a grating", "looming", {**GRATING, "motion": motion, "l_over_v_s": ratio}
        )
    for motion in ("looming", "receding", *SIGNED):
        yield Clip(f"{motion} before a scene", "cluttered", {**SQUARE, "grey": 0.0, "motion": motion})
    alone = {"rows": 72, "columns": 99, "duration_s": 5.0, "rest_s": 0.0}
    for name, speed, jitter_px in (("left", -8.0, 0.0), ("right", 8.0, 0.0), ("jitter", 0.0, 0.3)):
        more = {"object": "absent", "motion": "looming", "background_speed": speed}
        yield Clip(f"scene alone, {name}", "cluttered", {**alone, **more}, jitter_px)
    yield Clip("foliage", "foliage", alone)


TASKS: Mapping[str, Task] = {task.name: task for task in (
    _robot("robot", "default eye, with true motion and controls", 53.0, 2, options=TRUE),
    _robot("gamma", "eye ov7670-gamma", 8.0, values={"camera.preset": "ov7670-gamma"}),
    _robot("turns", "the robot turns by itself", 4.0, 3, TURNS, DIRECTION),
    _robot("dim", "a quarter of the light", 3.0, values={"scene.light": 0.25}),
    _robot("pale", "low contrast: a grey shell", 3.0, values={"scene.shell_grey": 0.3}),
    _robot("noise", "four times the noise", 3.0, values={"camera.shot_noise": 5.12, "camera.read_noise": 2.56}),
    _robot("15-fps", "15 frames/s", 2.0, values={"camera.fps": 15.0}),
    _robot("60-fps", "60 frames/s", 6.0, values={"camera.fps": 60.0}),
    _clips("clutter", "crossings before scenes that shift", 12.0, DIRECTION, _clutter(), 8),
    _clips("looming", "squares on an even ground", 1.0, LOOMING, _looming()),
    _clips("moving", "squares before what moves, and what moves alone", 2.0, LOOMING, _moving(), 6),
)}  # fmt: skip
"""Name -> task, in the order in which they are done."""


def document(channels: Collection[str]) -> dict[str, Any]:
    """Return what the tasks for models with some channels are made of: what is declared, and digests of pictures."""
    parts = {}
    for task in (task for task in TASKS.values() if {*channels} & {*task.channels}):
        resolved = task.plan(("dsnn",), 0).resolved
        settings = resolved.get("settings")
        apparatus = settings and [settings.robot, settings.camera, settings.scene]
        kept = {name: resolved[name] for name in ("experiment", "repeats", "clips") if name in resolved}
        parts[task.name] = {"channels": task.channels, "options": task.options, "apparatus": apparatus, **kept}
    files = (*Path(scenes.__file__).parent.rglob("*.xml"), *Path(background.__file__).parent.glob("*.png"))
    return {"name": NAME, "tasks": parts, "files": {path.name: sha256(path) for path in sorted(files)}}


def digest_of(*parts: Any) -> str:
    """Return the SHA-256 of values as JSON has them."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=plain).encode()).hexdigest()


def plans(models: Sequence[str], beacon: str = "") -> dict[str, Plan[Any]]:
    """Return the plans of all tasks by their folder: ``public/TASK``, and ``round/TASK`` where there is a round.

    Parameters
    ----------
    models
        As ``--model`` takes them. A task is shown to those that it applies to.
    beacon
        The round's number that nobody chose; empty: none. The seed of the round's trials is made of it.
    """
    seeds = {"public": 0, **({"round": int(digest_of(beacon)[:7], 16)} if beacon else {})}
    channels = {text: {*watchers((text,))[0].channels} for text in models}
    found = {}
    for (name, seed), task in product(seeds.items(), TASKS.values()):
        if applies := [text for text, has in channels.items() if has & {*task.channels}]:
            found[f"{name}/{task.name}"] = task.plan(applies, seed)
    return found
