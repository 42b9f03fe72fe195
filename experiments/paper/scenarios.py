"""The scenarios that ship: many robots that all see. Each has a reflex that works without training."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from colias_sim import RobotConfig
from colias_sim.envs import crowd
from colias_sim.envs.geometry import random_poses
from colias_sim.envs.swarm import Body, Drive
from dsnn import Response
from experiments.declare.behaviour import BLIND, Scenario, SwarmDesign, Wheels
from experiments.declare.claim import Claim
from experiments.declare.outcome import Check
from experiments.paper.behaviours import ProportionalIntegral, by_chance, turn


def pedestrian(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make a robot in traffic: a looming spike turns it to a side by chance, or HS alone away from what moves."""
    side = by_chance(rng)

    def alarm(seen: Response) -> float:
        if "looming" in channels:
            return side(seen) if seen.looming_spikes else 0.0
        return -math.copysign(1.0, seen.hs_spikes) if seen.hs_spikes else 0.0

    return crowd.Pedestrian(alarm, ahead, rng)


CHAIN_GAINS = 1.0, 8.0
"""Proportional and integral gains of a follower (1, 1/s), of five pairs tried with four robots at seed 0."""


def follower(number: int, ahead: float, channels: Sequence[str], rng: np.random.Generator) -> Drive:
    """Make the leader, which drives on its circle, or a robot that turns to null HS, or a blind one that drives on."""
    rule = ProportionalIntegral(lambda seen: seen.hs, *CHAIN_GAINS)

    def drive(seen: Response | None, body: Body) -> Wheels:
        if number == 0:
            return turn(-ahead * (RobotConfig().track_cm / 200) / crowd.RING_M, ahead)
        left, right = rule(seen) if seen is not None else (0.0, 0.0)
        return ahead + left, ahead + right

    return drive


def halved(model: str, id: str, title: str, says: str) -> Claim:
    """Claim that a swarm of a model collides at most half as often as a blind one, over all densities."""

    def judge(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
        seeing, blind = (sum(row["collisions"] for row in rows if row["model"] == name) for name in (model, BLIND))
        share = seeing / blind if blind else math.inf
        return [Check(f"{seeing} collisions of {model}, {blind} of blind ones: {share:.2f}", share, 0.5, "at most")]

    return Claim(
        id=id, judge=judge, title=f"{title} halves collisions in traffic", on="swarm", models={model, BLIND},
        says=f"robots that turn away from {says} collide at most half as often as blind ones",
    )  # fmt: skip


def kept(rows: Sequence[Mapping[str, Any]]) -> list[Check]:
    """Judge by how much fewer links break with HS than without, as a share of all, over all speeds."""
    seeing, blind = (float(np.mean([row["breaks"] for row in rows if row["model"] == name]))
                     for name in ("dsnn", BLIND))  # fmt: skip
    return [Check(f"{seeing:.2f} of links broken by HS, {blind:.2f} blind", blind - seeing, 0.5, "at least")]


SCENARIOS = (
    Scenario(
        name="traffic", summary="robots cross a square and turn away from what looms, or are blind, or see by HS alone",
        start=random_poses, make=pedestrian, models=("lgmd2", "dsnn", BLIND),
        design=SwarmDesign(robots=(4, 8, 12), seconds=30.0), chance=crowd.by_chance,
        claims=(halved("lgmd2", "B5", "Looming", "what looms to LGMD2"),
                halved("dsnn", "B6", "HS alone", "motion by the DSNN's HS alone")),
    ),
    Scenario(
        name="follow", summary="a chain on a circle, each keeps the one ahead in its view by HS, or is blind",
        start=crowd.chain, make=follower, models=("dsnn", BLIND),
        design=SwarmDesign(robots=(5,), speeds_cm_s=(4.0, 8.0), seconds=8.0),
        measures={"spread_cm": crowd.spread_cm, "breaks": crowd.breaks},
        figure=("breaks", "share of links broken"), arena="plain",
        claims=(Claim(
            id="B7", judge=kept, title="HS keeps a chain together", on="swarm", models={"dsnn", BLIND},
            says="of a chain that nulls HS the share of links that break is lower by half or more than of a blind one",
        ),),
    ),
)  # fmt: skip
