"""Options that several commands share, and the folder and the workers of a run that they ask for."""

import re
from pathlib import Path
from typing import Annotated

import typer

from experiments.base.console import out_console, print_troubles
from experiments.base.errors import UsageError
from experiments.kinds.tables import kind_of
from experiments.store.asked import Asked
from experiments.store.workers import Workers as Pool

EXIT_FAILED = 1
"""Exit status of a command some of whose jobs failed."""


Assignments = Annotated[
    list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter (colias list parameters).")
]
Cluster = Annotated[str | None, typer.Option(help="Address of a Dask scheduler, tcp://HOST:PORT.")]
Models = Annotated[
    list[str] | None,
    typer.Option("--model", metavar="MODEL", help="A model: a name, NAME:PARAM=VALUE or a .py file. Repeatable."),
]
Over = Annotated[
    list[str] | None,
    typer.Option(metavar="KEY=V1,V2", help="Move a parameter over these values; of a fit also KEY=A..B. Repeatable."),
]
Only = Annotated[bool, typer.Option("--only", help="Show the models of --model alone.")]
Out = Annotated[
    Path | None,
    typer.Option(metavar="FOLDER", help="Folder of results, or of a run to resume; otherwise runs/NAME-TIME."),
]
OwnPictures = Annotated[
    Path | None,
    typer.Option("--pictures", metavar="FOLDER", help="Pictures behind objects of clips, and on the arena's wall."),
]
Controls = Annotated[bool, typer.Option("--controls", help="Show each trial again: frozen, mirrored and so on.")]
DryRun = Annotated[
    bool, typer.Option("--dry-run", help="Say how many trials there are, and about how long they take. Run none.")
]
Jitter = Annotated[float, typer.Option(metavar="PX", help="Standard deviation of a trembling camera's shifts, px.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors alone.")]
Recordings = Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")]
Repeats = Annotated[int | None, typer.Option(metavar="N", help="Trials of each condition.")]
Replicates = Annotated[int | None, typer.Option(metavar="N", help="Replicates, each with a seed of its own.")]
Seed = Annotated[int, typer.Option(help="Seed of the run.")]
Size = Annotated[str | None, typer.Option(metavar="WxH", help="Width and height, px.")]
Trial = Annotated[
    int | None, typer.Option(metavar="N", help="Its number in trials.parquet; otherwise the first recorded.")
]
Workers = Annotated[int | None, typer.Option(help="Worker processes; 0: none. Otherwise one a core.")]


def pool(workers: int | None, cluster: str | None, quiet: bool) -> Pool:
    """Return the workers that these options ask for."""
    return Pool(workers, cluster, quiet=quiet)


def width_height(size: str | None) -> tuple[int, int] | None:
    """Return the numbers of a text such as 320x180; ``None`` where none is given."""

    shape = re.fullmatch(r"(\d{1,5})x(\d{1,5})", size or "")
    if size is not None and shape is None:
        raise UsageError(f"--size must be WIDTHxHEIGHT, for example 320x180, got {size}")
    return (int(shape[1]), int(shape[2])) if shape else None


def typed(context: typer.Context) -> set[str]:
    """Return the names of the parameters that the command line gives."""
    sources = {name: context.get_parameter_source(name) for name in context.params}
    return {name for name, source in sources.items() if source and source.name == "COMMANDLINE"}


def check_new(folder: Path) -> None:
    """Raise `UsageError` for a folder that is there and not empty."""
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"{folder} must be a new or an empty folder")


def finish(asked: Asked, out: Path | None, workers: Pool, name: str = "", *, dry: bool = False) -> int:
    """Do the run that was asked for, and print what it comes to.

    Parameters
    ----------
    asked
        What was asked for.
    out, name
        The run's folder; otherwise a new one of this name, or of the name of the plan.
    workers
        Where its trials are done.
    dry
        Whether to say what it comes to, and to do nothing.

    Returns
    -------
    int
        The exit status: 1 if trials or users' judges failed.
    """
    from experiments.base.files import results_folder
    from experiments.kinds.result import perform, plan_of
    from experiments.store.plan import forecast

    plan = plan_of(asked)
    if dry:
        costs = forecast(plan, workers.width)
        minutes, size = (f"{costs[name]:,.{int(costs[name] < 10)}f}" for name in ("minutes", "MB"))
        counts = f"{costs['conditions']:,} conditions, {costs['trials']:,} {plan.things}"
        out_console.print(f"{plan.name}: {counts}, some {minutes} minutes {workers.where()}, {size} MB")
        return 0
    done = perform(plan, results_folder(out, name or plan.name), workers)
    if not workers.quiet:
        kind_of(asked.kind).show(done)
    broken = print_troubles(done.troubles)
    return EXIT_FAILED if done.failures.height or broken else 0
