"""One Rerun recording per episode of a behaviour."""

from __future__ import annotations

import numpy as np

from colias_sim.config import CameraConfig, SceneConfig
from colias_sim.simulation import TRIAL_ROBOTS
from experiments.bench.closed_loop.episode import Episode
from experiments.bench.run import record as rerun
from experiments.bench.run.record import Content, Frames, Model

JPEG_QUALITY = 85


def record(episode: Episode, title: str = "") -> bytes:
    """Return the bytes of the .rrd file: the observer's view, the arena, the neurons, the wheels and the rewards.

    Frames are JPEG. An episode with a ``title`` cannot be played again by its behaviour's name and its seed, so that it
    is like no other. Raises ``ValueError`` on an episode without a step.
    """
    if episode.steps == 0:
        raise ValueError("an episode without a step cannot be recorded")
    env = episode.env.partition("/")[2]
    outcome = {
        "behaviour": episode.name, "env": episode.env,
        "reset seed": "none" if episode.seed is None else str(episode.seed),  # which may be any whole number
        "ended by": {True: "touched something", False: "time", None: "left"}[episode.touched],
        "return": float(episode.rewards.sum()),
    }  # fmt: skip
    return rerun.write(
        _content(episode), _frames(episode), title or f"{episode.name} in {env}, seed {episode.seed}",
        None if title else f"{episode.name}-{env}-{episode.seed}", {"episode": rerun.known(outcome)},
    )  # fmt: skip


def _content(episode: Episode) -> Content:
    models = [Model(episode.model, episode.channels, tuple(episode.thresholds.items()))] if episode.series else []
    seen = len(episode.frames) > 0
    terms = tuple(name.removeprefix("reward_") for name in _rewards(episode))
    plots = (
        ("world/observer/wheels", ("left", "right"), "wheels, shares of 35 cm/s"),
        ("reward", terms, "terms of the reward"),
    )
    height, width = episode.frames.shape[1:]
    return Content(
        models=tuple(models), eyes=("",) if seen else (), scene=SceneConfig(), above=True,
        plots=plots if terms else plots[:1], obstacles=rerun.outlines(episode.obstacles),
        camera=CameraConfig(width=width, height=height) if seen else None,
        robots=tuple((name, _variant(name)) for name in episode.paths),
    )  # fmt: skip


def _variant(robot: str) -> str:
    """Return what a robot of an env looks like."""
    return "colias_parked" if robot.startswith("parked") else TRIAL_ROBOTS.get(robot, TRIAL_ROBOTS["stimulus"])


def _rewards(episode: Episode) -> list[str]:
    return [name for name in episode.infos if name.startswith("reward_")]


def _frames(episode: Episode) -> Frames:
    plots: dict[str, np.ndarray] = {"world/observer/wheels": episode.wheels}
    if rewards := _rewards(episode):
        plots["reward"] = np.column_stack([episode.infos[name] for name in rewards])
    return Frames(
        episode.time_s, np.arange(episode.steps), {episode.model: episode.series} if episode.series else {},
        {"": rerun.jpegs(episode.frames, JPEG_QUALITY)} if len(episode.frames) else {}, episode.paths, plots=plots,
    )  # fmt: skip
