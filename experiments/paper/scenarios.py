"""The scenarios that ship: many robots that all see. Each has a reflex that works without training."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from colias_sim import RobotConfig
from colias_sim.envs.crowd import RING_M, Pedestrian, by_chance, chain, links
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.swarm import Body, Drive
from dsnn import Response
from experiments.declare.behaviour import Wheels
from experiments.declare.claim import Claim
from experiments.declare.outcome import Check
from experiments.declare.scenario import BLIND, Scenario, SwarmDesign
from experiments.paper.behaviours import ProportionalIntegral, turn


def pedestrian(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make a robot in traffic: a looming spike turns it to a side by chance, or HS alone away from what moves."""

    def looms(seen: Response) -> float:
        return (1.0 if rng.random() < 0.5 else -1.0) if seen.looming_spikes else 0.0

    def moves(seen: Response) -> float:
        return -math.copysign(1.0, seen.hs_spikes) if seen.hs_spikes else 0.0

    return Pedestrian(looms if "looming" in channels else moves, ahead, rng)


def halved(model: str) -> Callable[[Sequence[Mapping[str, Any]]], list[Check]]:
    """Make the judge of a claim that a swarm collides at most half as often as a blind one, over all densities."""

    def judge(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
        seeing, blind = (sum(row["collisions"] for row in rows if row["model"] == name) for name in (model, BLIND))
        share = seeing / blind if blind else math.inf
        return [Check(f"{seeing} collisions of {model}, {blind} of blind ones: {share:.2f}", share, 0.5, "at most")]

    return judge


def kept(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
    """Judge by how much fewer links break with HS than without, as a share of all, over all speeds."""
    seeing, blind = (
        float(np.mean([row["breaks"] for row in rows if row["model"] == name])) for name in ("dsnn", BLIND)
    )
    return [Check(f"{seeing:.2f} of links broken by HS, {blind:.2f} blind", blind - seeing, 0.5, "at least")]


TRAFFIC = Scenario(
    name="traffic",
    summary="robots cross a square and turn away from what looms, or are blind, or see by HS alone",
    start=random_poses,
    make=pedestrian,
    models=("lgmd2", "dsnn", BLIND),
    design=SwarmDesign(robots=(4, 8, 12), seconds=30.0),
    chance=by_chance,
    claims=(
        Claim(
            id="B5",
            on="swarm",
            judge=halved("lgmd2"),
            models=frozenset({"lgmd2", BLIND}),
            title="Looming halves collisions in traffic",
            says="robots that turn away from what looms to LGMD2 collide at most half as often as blind ones",
        ),
        Claim(
            id="B6",
            on="swarm",
            judge=halved("dsnn"),
            models=frozenset({"dsnn", BLIND}),
            title="HS alone halves collisions in traffic",
            says="robots that turn away from motion by the DSNN's HS alone collide at most half as often as blind ones",
        ),
    ),
)

GAINS = 1.0, 8.0
"""Proportional and integral gains of a follower (1, 1/s), of five pairs tried with four robots at seed 0."""


def follower(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make the leader, which drives on its circle, or a robot that turns to null HS, or a blind one that drives on."""
    circle = ahead * (RobotConfig().track_cm / 200) / RING_M
    rule = ProportionalIntegral(lambda seen: seen.hs, *GAINS)

    def drive(seen: Response | None, body: Body) -> Wheels:
        if number == 0:
            return turn(-circle, ahead)
        left, right = rule(seen) if seen is not None else (0.0, 0.0)
        return ahead + left, ahead + right

    return drive


FOLLOW = Scenario(
    name="follow",
    summary="a chain on a circle, each keeps the one ahead in its view by HS, or is blind",
    start=chain,
    make=follower,
    models=("dsnn", BLIND),
    design=SwarmDesign(robots=(5,), speeds_cm_s=(4.0, 8.0), seconds=8.0),
    measure=links,
    figure=("breaks", "share of links broken"),
    along="speed_cm_s",
    arena="plain",
    claims=(
        Claim(
            id="B7",
            on="swarm",
            judge=kept,
            models=frozenset({"dsnn", BLIND}),
            title="HS keeps a chain together",
            says="of a chain that nulls HS the share of links that break is lower by half or more than of a blind one",
        ),
    ),
)

EXPERIMENTS = (TRAFFIC, FOLLOW)
