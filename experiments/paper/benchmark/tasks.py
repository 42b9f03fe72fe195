"""CB-1, the frozen tasks of the benchmark, as ``cb-1.json`` declares them, and the digest that holds them.

Nothing there changes without a new name: `tests/experiments/paper/test_benchmark.py` compares the digest.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import scenes
from dsnn.stimuli import background
from experiments.base.files import plain, read_json
from experiments.base.user_code import sha256
from experiments.declare.clip import Clip, OfflineExperiment
from experiments.declare.conditions import Condition
from experiments.declare.experiment import Experiment, Listed
from experiments.kinds.result import plan_of
from experiments.settings.settings import watchers
from experiments.store.asked import Asked
from experiments.store.plan import Plan

NAME, FILE = "CB-1", Path(__file__).with_name("cb-1.json")
CONTROLS = ("frozen", "absent", "reversed")
"""The controls that a score is held against: a looming potential has no sign that a mirror turns."""


@dataclass(frozen=True)
class Task:
    """A task: what is shown, and which models it is for.

    Parameters
    ----------
    seconds
        What it costs the DSNN on two idle cores, s.
    channels
        It applies to models with any of these.
    declared
        The trials. Their name is the task's, and its folder's.
    values, options
        As of an `Asked`.
    """

    seconds: float
    channels: tuple[str, ...]
    declared: Any
    values: Mapping[str, Any]
    options: Mapping[str, Any]

    def plan(self, models: Sequence[str], seed: int, repeats: int | None = None) -> Plan[Any]:
        """Return the plan of its trials, shown to the models."""
        kept = {"recordings": False, "frames": hasattr(self.declared, "clips"), **self.options}
        asked = Asked(kind=self.declared.kind, declared=self.declared, models=tuple(models), only=True,
                      values=self.values, repeats=repeats, seed=seed, options=kept)  # fmt: skip
        return plan_of(asked)


def tasks_of(file: Path) -> dict[str, Task]:
    """Return the tasks that a file declares, by name, in the order in which they are done.

    Trials with the robot have ``conditions``, or the name of a task that has them; others have ``clips``.
    """
    found: dict[str, Task] = {}
    for kept in read_json(file):
        name, shown, repeats = kept["name"], kept.get("conditions"), kept["repeats"]
        about = (name, kept["summary"])
        if shown is None:
            clips = [Clip(*clip) for clip in kept["clips"]]
            declared: Any = OfflineExperiment(*about, clips, ("dsnn",), (), repeats)
        else:
            own = Listed(tuple(Condition(**one) for one in shown)) if isinstance(shown, list) else None
            declared = Experiment(*about, own or found[shown].declared.design, "speed_cm_s", repeats)
        values, options = kept.get("values", {}), kept.get("options", {})
        found[name] = Task(kept["seconds"], tuple(kept["channels"]), declared, values, options)
    return found


TASKS: Mapping[str, Task] = tasks_of(FILE)


def document(channels: Collection[str]) -> dict[str, Any]:
    """Return what the tasks for models with some channels are made of: what is declared, and digests of pictures."""
    parts = {}
    for name, task in TASKS.items():
        if {*channels} & {*task.channels}:
            resolved = task.plan(("dsnn",), 0).resolved
            settings = resolved.get("settings")
            apparatus = settings and [settings.robot, settings.camera, settings.scene]
            kept = {name: resolved[name] for name in ("experiment", "repeats", "clips") if name in resolved}
            parts[name] = {"channels": task.channels, "options": task.options, "apparatus": apparatus, **kept}
    files = (*Path(scenes.__file__).parent.rglob("*.xml"), *Path(background.__file__).parent.glob("*.png"))
    return {"name": NAME, "tasks": parts, "files": {path.name: sha256(path) for path in sorted(files)}}


def digest_of(*parts: Any) -> str:
    """Return the SHA-256 of values as JSON has them."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True, default=plain).encode()).hexdigest()


def plans(model: str, beacon: str = "") -> dict[str, Plan[Any]]:
    """Return the plans of the tasks that apply to a model: ``public/TASK``, and ``round/TASK`` where there is a round.

    Parameters
    ----------
    model
        As ``--model`` takes it.
    beacon
        The round's number that nobody chose; empty: none. The seed of the round's trials is made of it.
    """
    seeds = {"public": 0, **({"round": int(digest_of(beacon)[:7], 16)} if beacon else {})}
    applies = {name: task for name, task in TASKS.items() if {*watchers((model,))[0].channels} & {*task.channels}}
    return {f"{folder}/{name}": task.plan((model,), seed)
            for (folder, seed), (name, task) in product(seeds.items(), applies.items())}  # fmt: skip
