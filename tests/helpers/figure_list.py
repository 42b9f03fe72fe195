"""Every figure of the bench from fixed rows: `FIGURES`, name -> a function from names of models to the figure."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import numpy as np
import polars as pl
from matplotlib.figure import Figure

from colias_sim.envs import ENVS
from experiments.bench import sweep, sweep_plan, tune
from experiments.bench.leaderboard import CHANCE, DIRECTION, LOOMING, NOTE, PANELS, finding
from experiments.bench.report import behaviours as behaviours_report
from experiments.bench.report import scoreboard
from experiments.bench.report import sweep as sweep_figure
from experiments.bench.report import tuning as tuning_report
from experiments.bench.stats.curves import points_schema
from experiments.bench.stats.verdict import Outcome
from experiments.bench.study import TOGETHER
from experiments.bench.study import Study as GridStudy
from tests.helpers.figure_others import (
    eyes_and_wheels,
    fit,
    range_of_eyes,
    sensitivity,
    video,
)
from tests.helpers.figure_rows import (
    FRAMES,
    OWN,
    SET,
    background,
    contrast,
    edges,
    excitation,
    mechanism,
    peaks,
    ranges,
    robot,
    robot_words,
    strength,
    traces,
)

# --- tuning curves and boards -----------------------------------------------------------------------------------------


def tuning(curve: str) -> Callable[[Sequence[str]], Figure]:
    def draw(models: Sequence[str]) -> Figure:
        family = tune.FAMILIES[curve]
        rows = [
            {"curve": curve, "line": probe.line, "x": probe.x, "y": probe.y, "repeat": probe.repeat, "model": model,
             "direction_deg": probe.direction_deg, "response": response, "hs": 0.8 * response,
             "vs": 0.2 * response, "looming": 0.3, "spikes": round(10 * response),
             "contact_s": probe.x / response if model != "emd" else None}
            for model in models
            for i, probe in enumerate(family.probes)
            for response in [strength(model) * (0.3 + math.sin(i + len(model)) ** 2)]
        ]  # fmt: skip
        points = pl.DataFrame(rows, points_schema(tune.AXES))
        channels = ("looming",) if family.kind == "approach" else ("hs", "vs")
        preferences = [tune.preferences(points, model, channels) for model in models]
        return tuning_report.draw(family.kind, points, preferences, family.x, family.y, family.summary, SET)

    return draw


def leaderboard(board: str) -> Callable[[Sequence[str]], Figure]:
    def draw(models: Sequence[str]) -> Figure:
        measures = [name for names in PANELS[board].values() for name in names]
        rows = [
            {"model": model} | {
                f"{name}{end}": None if model == "emd" else part * strength(model)
                for name in measures
                for end, part in (("", 1.0), ("_low", 0.8), ("_high", 1.1))
            }
            for model in models
        ]  # fmt: skip
        table = pl.DataFrame(rows)
        return scoreboard.draw(table, PANELS[board], CHANCE, finding(board, table), NOTE)

    return draw


def behaviours_of(models: Sequence[str]) -> list[str]:
    """The behaviours that stand for models: one's own first, then baselines, then others."""
    known = ["hybrid", "random-walk", "straight", "oracle-ways"]
    return [OWN, *known[1:], *models[1:]][: len(models)] if OWN in models else known[: len(models) + 1]


def behaviours(env: str, episodes: int = 20) -> Callable[[Sequence[str]], Figure]:
    def draw(models: Sequence[str]) -> Figure:
        rows, frames = [], []
        for place, name in enumerate(behaviours_of(models)):
            for episode in range(episodes):
                trial, turn = place * episodes + episode, np.linspace(0.0, 2.0 + 0.1 * place, FRAMES)
                x, y = 30 * np.cos(turn + episode) - 5, 28 * np.sin(turn + episode)
                frames.append(pl.DataFrame({"trial": [trial] * FRAMES, "x_cm": x, "y_cm": y}))
                measured = {m.column: 0.1 * episode + strength(name) for m in ENVS[env].all_measures}
                row = {"trial": trial, "repeat": episode, "touched": episode % 3 == 0, "seed": episode, "model": name}
                rows.append({"driven_m": 1.0, **measured, **row, "env": env})
        caption = behaviours_report.caption(env, {"camera": {"preset": "ov7670"}, "robots": 5}, episodes, 0)
        return behaviours_report.of_episodes(pl.DataFrame(rows), pl.concat(frames), caption)

    return draw


def training(models: Sequence[str]) -> Figure:
    env = "colias_sim/Optomotor-v0"
    measures = [measure.name for measure in ENVS[env].all_measures]
    rows = [
        {"env": env, "behaviour": name, "measure": measure, "episodes": 20, "value": value, "ci_low": 0.7 * value,
         "ci_high": 1.4 * value}
        for name in ("PPO", *behaviours_of(models))
        for place, measure in enumerate(measures)
        for value in [strength(name) + place]
    ]  # fmt: skip
    seeds = [{"behaviour": "PPO", "measure": name, "value": 0.1 * seed} for name in measures for seed in range(5)]
    return behaviours_report.draw(pl.DataFrame(rows), pl.DataFrame(seeds), "Optomotor-v0", things="training seeds")


# --- maps -------------------------------------------------------------------------------------------------------------


def maps(models: Sequence[str]) -> Figure:
    """Two axes, two claims and all together, a measure with a threshold."""
    study = GridStudy(
        "sweep", "a grid", over=("cluttered.grey=0,32,64,255", "cluttered.start=0,90,180"), measures=("peak-hs",),
        claims=("C6",), experiments=("clutter-translation",), repeats=None, replicates=5,
    )  # fmt: skip
    plan = sweep_plan.planned(study)
    words = ("holds", "fails", "silent model", "not shown", "holds", "holds")

    class Turns(sweep.Sweep):
        @cached_property
        def outcomes(self) -> dict[Any, tuple[Outcome, ...]]:
            return {
                (point, "dsnn", claim): tuple(Outcome(words[(place + i) % 6], "") for i in range(5))  # type: ignore
                for claim in ("C6", TOGETHER)
                for place, point in enumerate(plan.points)
            }

        @cached_property
        def numbers(self) -> pl.DataFrame:
            values = {"measure": "peak-hs", "threshold": 0.16, "mark": "", "lowest": 0.0, "highest": 0.3}
            return pl.DataFrame(
                [
                    {
                        **self._at(point, "dsnn"),
                        **values,
                        "value": 0.02 * place,
                        "lowest": 0.01 * place,
                        "highest": 0.03 * place,
                    }
                    for place, point in enumerate(plan.points)
                ]
            )

    return sweep_figure.draw(Turns(plan, {}))


FIGURES: dict[str, Callable[[Sequence[str]], Figure]] = {
    "robot": robot,
    "robot, words": robot_words,
    "mechanism": mechanism,
    "excitation": excitation,
    "traces": traces,
    "peaks": peaks,
    "background": background,
    "ranges": ranges,
    "contrast": contrast,
    "edges": edges,
    **{f"tuning, {curve}": tuning(curve) for curve in tune.FAMILIES},
    "leaderboard": leaderboard(DIRECTION),
    "leaderboard, looming": leaderboard(LOOMING),
    "behaviours, paths": behaviours("colias_sim/Avoidance-v0"),
    "behaviours, one episode": behaviours("colias_sim/Pursuit-v0", 1),
    "behaviours, no paths": behaviours("colias_sim/Optomotor-v0"),
    "training": training,
    "maps": maps,
    "eyes and drives": eyes_and_wheels,
    "range of eyes": range_of_eyes,
    "sensitivity": sensitivity,
    "fit": fit,
    "video": video,
}
OF_ONE_MODEL = ("excitation", "maps", "eyes and drives", "range of eyes", "sensitivity", "fit")
"""Figures that are the same whatever models there are."""


def shown(name: str, models: Sequence[str]) -> list[str]:
    """The names that a figure draws a series, a panel or a row of."""
    if name.startswith("behaviours"):
        return behaviours_of(models)
    if name == "training":
        return ["PPO", *behaviours_of(models)]
    return list(models)
