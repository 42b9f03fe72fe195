"""Many robots that all see: plan a scenario's trials, play them, and conclude, draw and show a run of them."""

from __future__ import annotations

import itertools
import pickle
from collections.abc import Mapping
from contextlib import closing
from functools import partial
from typing import TYPE_CHECKING, Any

import cloudpickle
import numpy as np
import polars as pl

from colias_sim.config import CameraConfig, RobotConfig
from colias_sim.envs.crowd import Tracks
from colias_sim.envs.options import FPS, checked
from colias_sim.envs.swarm import WALL, Swarm, SwarmOptions
from dsnn import ResponseSeries
from experiments.base.console import count, show as show_table, show_files
from experiments.base.streams import KEYS, stream
from experiments.base.user_code import traced
from experiments.declare.outcome import Outcome
from experiments.declare.scenario import BLIND, Scenario
from experiments.draw.terminal import show_verdicts
from experiments.judge.tests import summary_rows
from experiments.judge.verdict import document, verdict_of
from experiments.kinds import registry
from experiments.kinds.result import Kind, Run, concluding, load
from experiments.settings.models import look_up, shown_models
from experiments.settings.parameters import differing
from experiments.settings.settings import applied, by_section, check_counts, sections, with_values
from experiments.show.play import FIELDS, FRAMES, Trial, one_thread
from experiments.show.swarm import EVERY, write
from experiments.store import provenance
from experiments.store.asked import Asked
from experiments.store.folder import RunFolder
from experiments.store.plan import Plan
from experiments.store.tables import JOB, TrialRecord, drawn_here, group, recording_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MEASURED: Mapping[str, type] = dict.fromkeys(
    ("collisions_a_min", "wall_a_min", "driven_m", "spread_cm", "breaks"), float
)
"""Measures of a trial, a robot and minute where they are rates. Null where a scenario has no such."""
TRIALS = pl.Schema({**JOB, "robots": int, "speed_cm_s": float, "seconds": float, "collisions": int, **MEASURED})
"""Columns of ``trials.parquet``: a row per trial, of all its robots."""
STEPS = FRAMES | pl.Schema(
    {"robot": str, "touches": str}
    | dict.fromkeys(("time_s", "x_cm", "y_cm", "heading_deg", "left_wheel", "right_wheel"), float)
)
"""Columns of ``frames.parquet``: a row per frame and robot of the first repeat; ``touches`` is whom it has begun to."""


class SwarmTrial(Trial):
    """A trial of a scenario. Its condition is (robots, speed in cm/s); its model is that of all robots, or none."""

    def label(self) -> str:
        """Return the swarm, the number of robots and their speed."""
        robots, speed = self.condition
        return f"{self.models[0].label if self.models else BLIND}, {robots} robots at {speed:g} cm/s"

    @property
    def fps(self) -> float:
        """The frame rate of the cameras, 1/s."""
        return FPS


def plan(asked: Asked) -> Plan[SwarmTrial]:
    """Return the plan of a scenario: every number of robots and speed, by every model, in equal starts.

    Parameters
    ----------
    asked
        What was asked for. Values are of the sections ``swarm``, ``robot``, ``camera`` and of the models.

    Raises
    ------
    UsageError
        It cannot be run so.
    """
    scenario: Scenario = registry.declaration(asked)
    repeats = scenario.repeats if asked.repeats is None else asked.repeats
    check_counts(asked.seed, repeats)
    shown = shown_models(scenario.models, asked.models, asked.only)
    usual = sections(None, [name for name in shown if name != BLIND])
    usual = {name: value for name, value in usual.items() if name not in ("scene", "processor")}
    usual["swarm"] = scenario.design
    given = by_section(asked.values, usual)
    robot, camera, design = (
        with_values(name, usual[name], given.get(name, {})) for name in ("robot", "camera", "swarm")
    )
    models = applied(look_up([name for name in shown if name != BLIND]), given)
    swarms = [(model,) for model in models] + [()] * (BLIND in shown)
    cases = itertools.product(range(repeats), design.robots, design.speeds_cm_s, swarms)
    trials = [
        SwarmTrial(scenario.name, index, repeat, asked.seed + repeat, (number, speed), seen_by)
        for index, (repeat, number, speed, seen_by) in enumerate(cases)
    ]
    others = {"robot": (RobotConfig(), robot), "camera": (CameraConfig(), camera), "swarm": (scenario.design, design)}
    changed = differing(models, others=others)
    resolved = {
        "experiment": {"name": scenario.name, "summary": scenario.summary, "figure": scenario.figure,
                       "along": scenario.along},
        "repeats": repeats, "seed": asked.seed, "trials": len(trials), "models": models, "swarm": design,
        **({"changed": changed} if changed else {}),
        "thresholds": {model.label: model.thresholds for model in models},
        "chance": scenario.chance and [(number, speed, scenario.chance(number, speed))
                                       for number, speed in itertools.product(design.robots, design.speeds_cm_s)],
        **provenance.of((model.source for model in models), scenario),
    }  # fmt: skip
    # A worker finds the scenario by its name or its file; one of a script travels with its functions.
    own = asked.declared is not None and not scenario.file
    source = cloudpickle.dumps(scenario) if own else scenario.file or scenario.name
    options = {"camera": camera, "robot": robot, "arena": scenario.arena}
    work = partial(
        play,
        source=source,
        options=options,
        frames=round(design.seconds * FPS),
        recorded=bool(asked.option("recordings", True)),
    )
    return Plan(asked, scenario.name, trials, work, resolved, (TRIALS, STEPS), scenario, models)


def play(
    trial: SwarmTrial, *, source: str | bytes, options: Mapping[str, Any], frames: int, recorded: bool = False
) -> TrialRecord:  # fmt: skip
    """Play a trial in a worker; the first repeat with a row per frame and robot."""
    scenario: Any = pickle.loads(source) if isinstance(source, bytes) else registry.find(source)
    (number, speed_cm_s), model = trial.condition, next(iter(trial.models), None)
    senses = {"model": model.build, "observation": "neural"} if model else {"observation": "state"}
    swarm = Swarm(checked(SwarmOptions, {**options, **senses, "robots": number}))
    rng, channels, label = (
        stream("swarm.start", trial.seed),
        model.channels if model else (),
        model.label if model else BLIND,
    )
    seeds = np.random.SeedSequence(trial.seed, spawn_key=KEYS["swarm.drive"]).spawn(number)
    ahead = speed_cm_s / swarm.options.robot.max_speed_cm_s
    tracks, commands = np.empty((frames, number, 3)), np.empty((frames, number, 2))
    images: dict[str, list[Any]] = {}
    with one_thread(), closing(swarm.sim):
        swarm.reset(dict(zip(swarm.agents, scenario.start(rng, number), strict=True)), rng, trial.seed)
        drives = {
            name: scenario.make(k, ahead, channels, np.random.default_rng(seeds[k]))
            for k, name in enumerate(swarm.agents)
        }
        for frame in range(frames):
            swarm.play(drives)
            tracks[frame] = [(pose.x, pose.y, pose.heading) for pose in swarm.sim.poses.values()]
            commands[frame] = [agent.wheels for agent in swarm.agents.values()]
            for name, agent in swarm.agents.items() if recorded and model and frame % EVERY == 0 else ():
                images.setdefault(name, []).append(agent.luma)
    row = {
        **{"experiment": trial.experiment, "trial": trial.index, "repeat": trial.repeat, "seed": trial.seed},
        "model": label, "robots": number, "speed_cm_s": speed_cm_s,
        **dict.fromkeys(MEASURED), **measured(swarm, tracks), **(scenario.measure(tracks) if scenario.measure else {}),
    }  # fmt: skip
    table = STEPS.to_frame() if trial.repeat else steps(trial.index, label, swarm, tracks, commands)
    troubles = {f"{label}, {name}": traced(error) for name, error in swarm.errors.items()}
    recording = recording_of(lambda: write(table, swarm, images, trial.label())) if recorded and table.height else None
    done = TrialRecord(trial.index, (row,), table, recording, troubles)
    return drawn_here(done) if trial.models else done


def measured(swarm: Swarm, tracks: Tracks) -> dict[str, Any]:
    """Return the measures that every scenario has: how often robots touched, and how far they went."""
    frames, number, _ = tracks.shape
    minutes = frames / FPS / 60.0
    walls = sum(WALL in pair for _, pair in swarm.collisions)
    met = len(swarm.collisions) - walls
    driven = np.hypot(*np.diff(tracks[..., :2], axis=0).transpose(2, 0, 1)).sum()
    return {
        "seconds": frames / FPS, "collisions": met, "collisions_a_min": 2.0 * met / number / minutes,
        "wall_a_min": walls / number / minutes, "driven_m": float(driven) / number,
    }  # fmt: skip


def steps(index: int, label: str, swarm: Swarm, tracks: Tracks, commands: Tracks) -> pl.DataFrame:
    """Return the rows of `STEPS` of a trial, robot after robot."""
    tables, frames = [], len(tracks)
    for number, (name, agent) in enumerate(swarm.agents.items()):
        touches: list[str | None] = [None] * frames
        for frame, pair in swarm.collisions:
            if name in pair:
                touches[frame] = next(iter(pair - {name}))
        x, y, heading = tracks[:, number].T
        responses: list[Any] = agent.responses
        seen = ResponseSeries.from_responses(responses) if responses else None
        lacking = [None] * (frames - len(responses))
        tables.append(pl.DataFrame({
            "trial": index, "model": label, "frame": range(frames), "robot": name, "touches": touches,
            "time_s": np.arange(1, frames + 1) / FPS,
            "x_cm": 100 * x, "y_cm": 100 * y, "heading_deg": np.degrees(heading),
            "left_wheel": commands[:, number, 0], "right_wheel": commands[:, number, 1],
            **{field: [*getattr(seen, field), *lacking] if seen else None for field in FIELDS},
        }).select(STEPS.names()).cast(STEPS))  # fmt: skip
    return pl.concat(tables)


# What it comes to.


def conclude(plan: Plan[SwarmTrial], folder: RunFolder) -> None:
    """Judge the claims, a repeat being a replicate, and write verdicts, summary and figure."""
    from experiments.draw import style  # not before: workers do without matplotlib

    rows, whole = folder.table("trials").to_dicts(), len(plan.trials)
    repeats = group(rows, "repeat")
    size = whole // len({trial.repeat for trial in plan.trials})
    shown, lost = {row["model"] for row in rows}, Outcome.unjudged("trials of its swarms failed or were not asked for")
    found = [
        verdict_of(claim, [claim.evaluate(part) if len(part) == size and claim.models <= shown else lost
                           for part in repeats.values()],
                   experiment=plan.name)
        for claim in plan.declared.claims if rows
    ]  # fmt: skip
    folder.write_json("claims.json", document(found))
    if rows:
        folder.write_rows("summary.csv", summary_rows(rows, ("model", "robots", "speed_cm_s"), MEASURED, ()))
        style.save(load(folder.folder).figure(), folder.folder / "figure")


# Reading it.


def draw(run: Run) -> Figure:
    """Draw the scenario's column against what it varies, a line a swarm, and what it is by chance."""
    from experiments.draw import swarm  # not before: matplotlib takes its time to load

    return swarm.draw(run.trials, run.description)


def show(run: Run) -> None:
    """Print means over repeats, the verdicts, and where everything is."""
    if run.done:
        column = run.description["experiment"]["figure"][0]
        show_table(run.summary.filter(quantity=column).drop("quantity"), column)
        show_verdicts(run.verdicts)
        show_files(run.folder, count(run.trials.height, "trial"))


def words(run: Run) -> str:
    """Say what a run shows."""
    return f"{run.description['experiment']['summary']}."


KIND = Kind(plan, concluding(conclude), draw, show, chapter="Swarms", words=words)
