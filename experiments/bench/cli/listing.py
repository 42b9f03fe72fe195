"""The commands ``colias list ...``. Heavy imports happen when they run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import Models, Only

if TYPE_CHECKING:
    from experiments.bench.run.settings import Parameter

KINDS = ("experiments", "studies", "fits", "models", "scenes", "presets", "stimuli", "envs", "behaviours", "claims")
app = typer.Typer(invoke_without_command=True)


@app.callback()
def show_all(context: typer.Context) -> None:
    """Name what there is: of every kind, or of one."""
    if context.invoked_subcommand is None:
        for kind, items in _names().items():
            _show(kind, items)


def _show_kind(context: typer.Context) -> None:
    _show(str(context.info_name), _names()[str(context.info_name)])


for _kind in KINDS:
    app.command(_kind, help=f"Name the {_kind}.")(_show_kind)


def _show(kind: str, items: Mapping[str, str]) -> None:
    from experiments.bench.report.terminal import out_console, show_line

    out_console.print(kind, style="b")
    for name, summary in items.items():
        show_line(f"  {name:<20}{summary}", 22)


def _names() -> dict[str, dict[str, str]]:
    """Return what there is: kind -> name -> what it is."""
    from colias_sim.config import CameraConfig, RobotConfig
    from colias_sim.envs import ENVS
    from dsnn import MODELS
    from dsnn.stimuli import STIMULI
    from experiments import NAMES, OFFLINE
    from experiments.behaviours import BEHAVIOURS, GROUPS
    from experiments.bench import registry, study
    from experiments.bench.stats.claim import PAPER, claim_ids, words
    from scenes import ARENAS

    cameras = {f"camera.preset={name}": text for name, text in CameraConfig.preset_summaries().items()}
    robots = {f"robot.preset={name}": text for name, text in RobotConfig.preset_summaries().items()}
    implied = {name: " (the equations imply it)" if words(name).implied else "" for name in claim_ids(PAPER)}
    return {
        "experiments": {name: registry.find(name).summary for name in (*NAMES, *OFFLINE)},
        "studies": {
            **{name: study.shipped(name).summary for name in study.names()},
            "model-claims": "the claims of the looming models' own papers, on clips",
        },
        "fits": {name: study.shipped(name, "FIT").study.summary for name in study.names("FIT")},
        "models": {name: entry.summary for name, entry in MODELS.items()},
        "scenes": dict(ARENAS),
        "presets": cameras | robots,
        "stimuli": {name: entry.summary for name, entry in STIMULI.items()},
        "envs": {name.partition("/")[2]: entry.summary for name, entry in ENVS.items()},
        "behaviours": {
            **{name: entry.summary for name, entry in BEHAVIOURS.items()},
            **{name: f"a group: {', '.join(members)}" for name, members in GROUPS.items()},
        },
        "claims": {name: words(name).title + note for name, note in implied.items()},
    }


@app.command(short_help="List every parameter that --set reaches.")
def parameters(
    experiment: Annotated[
        str, typer.Argument(help="The experiment, or the stimulus, whose parameters to list.")
    ] = "speed",
    model: Models = None,
    only: Only = False,
) -> None:
    """List every parameter that --set reaches: key, default, legal range, unit, meaning. The command's own model is
    dsnn, or those that the experiment declares.
    """
    from dsnn.stimuli import STIMULI
    from experiments.bench import registry
    from experiments.bench.run.models import shown_models
    from experiments.bench.run.settings import described
    from experiments.bench.run.user_code import declares, is_file
    from experiments.bench.sources.clips import find_stimulus
    from experiments.bench.trials import parameters as listed

    if experiment in STIMULI or (is_file(experiment) and declares(Path(experiment), "STIMULUS")):
        entry = find_stimulus(experiment)
        return show_parameters(described({entry.name: entry.params}))
    declared = registry.load(experiment)
    show_parameters(listed(declared, shown_models(declared.models, model, only)))


def show_parameters(rows: Iterable[Parameter]) -> None:
    """Print parameters: key, value, legal range, unit, meaning."""
    from rich.text import Text

    from experiments.bench.report.terminal import show_line

    for row in rows:
        notes = "; ".join(filter(None, (row.legal, row.unit and f"in {row.unit}")))
        legal = f"  ({notes})" if notes else ""
        show_line(Text.assemble(f"{row.key}=", (row.value, "b"), (legal, "dim")), 8)
        show_line(f"    {row.description}", 4)


@app.command(short_help="List the runs in a folder: when, what, seed, changed parameters, verdicts.")
def runs(folder: Annotated[Path, typer.Argument(help="Where runs are.")] = Path("runs")) -> int:
    """List the runs in a folder, oldest first, down to the parts of sweeps and reproductions.

    For each: when it was begun, its experiment, seed and models, the parameters that are not at their defaults, how
    many of its trials are finished, how its claims came out, and the commit it was begun with. Imported logs are
    marked. A run of another version is named in a line, with the version that reads it.
    """
    from rich.table import Table
    from rich.text import Text

    from experiments.bench.report.terminal import error_console, show_table
    from experiments.bench.result import runs as listed

    rows = listed(folder).to_dicts()
    table = Table(box=None, header_style="bold", pad_edge=False)
    imported = any(row["provenance"] not in (None, "simulated") for row in rows)
    columns = ("run", "begun", "experiment", "seed", "trials", "models", "changed", "verdicts", "commit")
    for name in (*columns, *(["provenance"] if imported else [])):
        table.add_column(name, no_wrap=name in ("run", "begun"))
    for row in (row for row in rows if row["trouble"] is None):
        place = Path(row["run"])
        name = str(place.relative_to(folder)) if place != folder and place.is_relative_to(folder) else row["run"]
        failed = f", {row['failures']} failed" if row["failures"] else ""
        whole = row["done"] == row["planned"]
        trials = f"{row['done']}" if whole else Text(f"{row['done']} of {row['planned']}", "yellow")
        begun = f"{row['when'].astimezone():%Y-%m-%d %H:%M}"
        table.add_row(
            name, begun, row["experiment"], "-" if row["seed"] is None else f"{row['seed']}",
            Text.assemble(trials, failed), row["models"], row["changed"], row["verdicts"], row["commit"] or "-",
            *([row["provenance"]] if imported else []),
        )  # fmt: skip
    if table.row_count:
        show_table(table)
    elif not rows:
        error_console.print(f"no runs in {folder}", soft_wrap=True, markup=False)
    for row in (row for row in rows if row["trouble"] is not None):
        error_console.print(f"{row['trouble']}", soft_wrap=True, markup=False)
    return 0
