"""The commands ``colias list`` and ``colias parameters``. Heavy imports happen when it runs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import Models, Only

if TYPE_CHECKING:
    from experiments.bench.run.settings import Parameter


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(
        "list", short_help="Name the experiments, studies, fits, models, scenes, stimuli, envs, behaviours, claims."
    )(list_all)
    app.command(short_help="List every parameter that --set reaches.")(parameters)


def list_all() -> None:
    """Name what there is: experiments, studies, fits, models, arenas, presets, stimuli, envs, behaviours, claims."""
    from colias_sim.config import CameraConfig, RobotConfig
    from colias_sim.envs import ENVS
    from dsnn import MODELS
    from dsnn.stimuli import STIMULI
    from experiments import NAMES, OFFLINE
    from experiments.behaviours import BEHAVIOURS, GROUPS
    from experiments.bench import registry, study
    from experiments.bench.engine.terminal import out_console, show_line
    from experiments.bench.stats.claim import PAPER, claim_ids, words
    from scenes import ARENAS

    experiments = {name: registry.find(name).summary for name in (*NAMES, *OFFLINE)}
    named = {name: study.shipped(name).summary for name in study.names()}
    named["model-claims"] = "the claims of the looming models' own papers, on clips"
    fits = {name: study.shipped(name, "FIT").study.summary for name in study.fits()}
    models = {name: entry.summary for name, entry in MODELS.items()}
    stimuli = {name: entry.summary for name, entry in STIMULI.items()}
    envs = {name.partition("/")[2]: entry.summary for name, entry in ENVS.items()}
    groups = {name: f"a group: {', '.join(members)}" for name, members in GROUPS.items()}
    behaviours = {name: entry.summary for name, entry in BEHAVIOURS.items()} | groups
    kinds = {
        "experiments": experiments, "studies": named, "fits": fits, "models": models, "scenes": ARENAS,
        "presets of camera": CameraConfig.preset_summaries(), "presets of robot": RobotConfig.preset_summaries(),
        "stimuli": stimuli,
        "envs": envs, "behaviours": behaviours,
        "claims of the paper": {
            name: f"{words(name).title}{' (the equations imply it)' if words(name).implied else ''}"
            for name in claim_ids(PAPER)
        },
    }  # fmt: skip
    for title, items in kinds.items():
        out_console.print(title, style="b")
        for name, summary in items.items():
            show_line(f"  {name:<20}{summary}", 22)


def parameters(
    experiment: Annotated[str, typer.Argument(help="The experiment whose parameters to list.")] = "speed",
    model: Models = None,
    only: Only = False,
) -> None:
    """List every parameter that --set reaches: key, default, legal range, unit, meaning. The command's own model is
    dsnn, or those that the experiment declares.
    """
    from experiments.bench import registry
    from experiments.bench.run.models import shown_models
    from experiments.bench.trials import parameters as listed

    declared = registry.load(experiment)
    show_parameters(listed(declared, shown_models(declared.models, model, only)))


def show_parameters(rows: Iterable[Parameter]) -> None:
    """Print parameters: key, value, legal range, unit, meaning."""
    from rich.text import Text

    from experiments.bench.engine.terminal import show_line

    for row in rows:
        notes = "; ".join(filter(None, (row.legal, row.unit and f"in {row.unit}")))
        legal = f"  ({notes})" if notes else ""
        show_line(Text.assemble(f"{row.key}=", (row.value, "b"), (legal, "dim")), 8)
        show_line(f"    {row.description}", 4)
