"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.figures.media import Medium, choose

if TYPE_CHECKING:
    from experiments.bench.engine.pictures import Pictures
    from experiments.bench.run.runs import Resources

EXIT_FAILED = 1
"""Exit status of a command some of whose jobs failed."""

Models = Annotated[
    list[str] | None,
    typer.Option(
        "--model",
        metavar="MODEL",
        help="Show this model beside the command's own: a name or a .py file; under other settings as"
        " dsnn:w_i=1,n_con=6. Repeatable.",
    ),
]
Only = Annotated[bool, typer.Option("--only", help="Show just the models of --model, none of the command's own.")]
Assignments = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Set a parameter; see [b]colias parameters[/b]. Repeatable."),
]
Workers = Annotated[
    int | None, typer.Option(help="Worker processes; otherwise one for each core. 0: none, for debuggers.")
]
Cluster = Annotated[str | None, typer.Option(help="Run on the Dask scheduler at this address (tcp://...) instead.")]
For = Annotated[
    Medium,
    typer.Option(
        "--for",
        callback=choose,
        help="What figures are for: paper (7.16 inches wide, type of 8 points), talk (a slide) or web. Their layout is"
        " the same.",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Neither progress nor tables, only errors.")]
Seed = Annotated[int, typer.Option(help="Seed of the whole run, 0 or more.")]
OtherCode = Annotated[
    bool,
    typer.Option("--other-code", help="Go on with a run that other code began; the column [b]code[/b] marks its rows."),
]
Out = Annotated[
    Path | None,
    typer.Option(
        help="Folder of the results; otherwise a new one, runs/NAME-TIME. Where this very run was begun there, just"
        " what is missing is done."
    ),
]
OwnPictures = Annotated[
    Path | None,
    typer.Option(
        "--pictures",
        metavar="FOLDER",
        help="Your own pictures, replicate r the r-th by name: behind the objects of clips that name no background, in"
        " place of the scenes, and on the arena's wall.",
    ),
]
Repeats = Annotated[int | None, typer.Option(help="Trials of each condition; otherwise the experiment's own number.")]


def experiment_names(incomplete: str) -> list[str]:
    """Return the experiments whose names begin so, for the shell's completion."""
    from experiments import NAMES, OFFLINE

    return [name for name in (*NAMES, *OFFLINE) if name.startswith(incomplete)]


def resources(workers: int | None, cluster: str | None, quiet: bool, other_code: bool) -> Resources:
    """Return what these options say a run is done with."""
    from experiments.bench.run.runs import Resources, worker_count

    return Resources(worker_count(workers), cluster, quiet, other_code)


def own_pictures(folder: Path | None) -> Pictures | None:
    """Return the pictures of a folder, where one is given; `UsageError` in one line for a bad one."""
    from experiments.bench.engine.pictures import folder_pictures

    return None if folder is None else folder_pictures(folder)


def results_folder(out: Path | None, name: str) -> Path:
    """Return the folder asked for, or a new one under ``runs``, whatever it holds: the command judges that itself.

    The folder is not made.
    """
    from experiments.bench.store import files

    return files.new_folder(name) if out is None else out


def run_folder(out: Path | None, name: str) -> Path:
    """Return the folder of a run, as `results_folder` does; one asked for may hold what this run has done already.

    Raises
    ------
    UsageError
        It holds other files and no run.
    """
    from experiments.bench.store import description, files

    folder = files.new_folder(name) if out is None else out
    description.check_own(folder, f"--out {folder}")
    return folder
