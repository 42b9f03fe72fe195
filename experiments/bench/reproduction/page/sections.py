"""The experiments of the report: figure, numbers and claims of each."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from colias_sim.envs import ENVS
from experiments.bench.closed_loop.run import Played
from experiments.bench.offline import OfflineReport
from experiments.bench.reproduction.page.cards import Card
from experiments.bench.reproduction.page.pictures import Seen, seen
from experiments.bench.robot.summary import Report
from experiments.bench.sources.conditions import CONDITION_COLUMNS
from experiments.bench.sources.experiment import Drawing
from experiments.bench.sources.rows import varying
from experiments.bench.stats.claim import PAPER, claim_ids
from experiments.bench.stats.verdict import Verdict
from experiments.bench.store.rows import Failure, group
from experiments.bench.trials import Plan

ALTS: Mapping[Drawing, str] = {
    "spikes": "Spikes of every trial of {name}, and the HS potential over each",
    "mechanism": "Spikes, time in view, firing rate and HS potential of {name}",
    "excitation": "Excitation, weighted inhibition, HS and spikes over the trials of {name}",
}
"""What a figure is, for who cannot see it."""


@dataclass(frozen=True, slots=True)
class Picture:
    """A figure inside the page: its anchor, a data URI, and what it is in words."""

    anchor: str
    uri: str
    alt: str


@dataclass(frozen=True, slots=True)
class RobotSection:
    """An experiment with the robot.

    Parameters
    ----------
    name, summary
        Of the experiment.
    figure
        Its figure; ``None`` without rows.
    judged, explained
        The claims that are judged on it, and those whose mechanism it shows.
    seen
        What the robot saw in replicate 0.
    columns, conditions, spikes
        Names and values of what tells the conditions apart, and their rows of ``summary.csv`` about spikes.
    condition_names, comparisons, tests
        The conditions of the comparisons of models, the rows of ``comparisons.csv``, and the tests' names.
    recordings
        Paths of the recordings, from the page.
    failures, flaws
        Trials that failed, and what is to be known of the others.
    """

    name: str
    summary: str
    figure: Picture | None
    judged: tuple[Card, ...]
    explained: tuple[Card, ...]
    seen: Seen
    columns: list[str]
    conditions: list[list[str]]
    spikes: list[dict[str, Any]]
    condition_names: list[str]
    comparisons: list[dict[str, Any]]
    tests: str
    recordings: list[str]
    failures: list[Failure]
    flaws: str


@dataclass(frozen=True, slots=True)
class ClipSection:
    """An off-line experiment.

    Parameters
    ----------
    name, summary, models, clips, seeds
        Of the experiment: what it is, who saw it, how many clips at how many seeds.
    drawn
        How the seeds bear on its figure, in words.
    figure
        Its figure; ``None`` without rows.
    judged, explained
        As of `RobotSection`.
    own
        The verdicts on claims that are not the paper's.
    failures
        Clips that failed.
    """

    name: str
    summary: str
    models: str
    clips: int
    seeds: int
    drawn: str
    figure: Picture | None
    judged: tuple[Card, ...]
    explained: tuple[Card, ...]
    of_users: tuple[Verdict, ...]
    failures: list[Failure]


@dataclass(frozen=True, slots=True)
class LoopSection:
    """Behaviours in one env: a row each, with the measures in ``measures``."""

    name: str
    env: str
    measures: list[str]
    rows: list[tuple[str, list[str]]]
    figure: Picture | None
    failures: Sequence[Failure]


def robot_section(plan: Plan, report: Report, cards: Sequence[Card]) -> RobotSection:
    """Return what the page shows of an experiment with the robot."""
    name = plan.experiment.name
    names = varying(report.rows, report.varies) if report.rows else []
    measured = group(report.summary, "model", *CONDITION_COLUMNS).values()
    none = {"mean": None, "ci_low": None}  # of a model that does not spike
    spikes = [
        dict(next((r for r in quantities if r["quantity"] == "spikes"), {**quantities[0], **none}))
        for quantities in measured
    ]
    return RobotSection(
        name=name,
        summary=plan.experiment.summary,
        figure=_figure(report.folder, f"experiment-{name}", ALTS[plan.experiment.figure].format(name=name))
        if report.rows
        else None,
        judged=_judged(name, cards),
        explained=_explained(name, cards),
        seen=seen(plan, report.folder),
        columns=names,
        conditions=[[_cell(row[name]) for name in names] for row in spikes],
        spikes=spikes,
        condition_names=[name for name in names if name != "model"],
        comparisons=report.comparisons,
        tests="; ".join(sorted({row["test"] for row in report.comparisons})),
        recordings=sorted(f"{name}/recordings/{path.name}" for path in (report.folder / "recordings").glob("*.rrd")),
        failures=report.failures,
        flaws=report.flaws,
    )


def clip_section(report: OfflineReport, cards: Sequence[Card]) -> ClipSection:
    """Return what the page shows of an off-line experiment."""
    experiment = report.plan.experiment
    return ClipSection(
        name=experiment.name,
        summary=experiment.summary,
        models=", ".join(model.label for model in report.plan.models),
        clips=len(experiment.clips),
        seeds=report.plan.repeats,
        drawn=_drawn(report),
        figure=_figure(report.folder, f"experiment-{experiment.name}", f"Membrane potentials of {experiment.name}")
        if report.rows else None,
        judged=_judged(experiment.name, cards),
        explained=_explained(experiment.name, cards),
        of_users=tuple(verdict for verdict in report.verdicts if verdict.id not in claim_ids(PAPER)),
        failures=report.failures,
    )  # fmt: skip


def loop_section(played: Played) -> LoopSection:
    """Return what the page shows of the behaviours in one env."""
    standings, env = played.standings, played.env.partition("/")[2]
    alt = f"Measures of every behaviour in {env}{', and where they drove' if ENVS[played.env].draws_paths else ''}"
    return LoopSection(
        name=played.folder.name,
        env=env,
        measures=list(standings[0].scores) if standings else [],
        rows=[(standing.name, [str(score) for score in standing.scores.values()]) for standing in standings],
        figure=_figure(played.folder, f"loop-{played.folder.name}", alt) if standings else None,
        failures=played.failures,
    )


def figure_of(path: Path, anchor: str, alt: str) -> Picture:
    """Return an SVG file as a figure inside the page. ``anchor`` begins with its kind: a map and an experiment may have
    one name.
    """
    uri = f"data:image/svg+xml;base64,{base64.b64encode(path.read_bytes()).decode()}"
    return Picture(f"figure-{anchor}", uri, alt)


def _figure(folder: Path, anchor: str, alt: str) -> Picture:
    return figure_of(folder / "figure.svg", anchor, alt)


def _judged(name: str, cards: Sequence[Card]) -> tuple[Card, ...]:
    return tuple(card for card in cards if name in card.experiments)


def _explained(name: str, cards: Sequence[Card]) -> tuple[Card, ...]:
    return tuple(card for card in cards if card.mechanism[0] == name and name not in card.experiments)


def _drawn(report: OfflineReport) -> str:
    if report.plan.repeats > 1:
        return f" in each of {report.plan.repeats} replicates, of which replicate 0 is drawn"
    return ", of replicate 0 alone" if report.plan.is_random() else "; nothing in them is random"


def _cell(value: Any) -> str:
    return "" if value is None else value if isinstance(value, str) else f"{value:g}"
