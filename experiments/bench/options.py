"""Options that several commands share."""

from __future__ import annotations

import os
from typing import Annotated

import typer

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
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Neither progress nor tables, only errors.")]
Seed = Annotated[int, typer.Option(help="Seed of the whole run, 0 or more.")]
OtherCode = Annotated[
    bool,
    typer.Option("--other-code", help="Go on with a run that other code began; the column [b]code[/b] marks its rows."),
]
Repeats = Annotated[int | None, typer.Option(help="Trials of each condition; otherwise the experiment's own number.")]


def worker_count(given: int | None) -> int:
    """The worker processes asked for, or one for each core this process may use."""
    from experiments.bench.files import UsageError

    if given is None:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not 0 <= given <= 256:
        raise UsageError(f"--workers {given}: legal is a whole number from 0 to 256")
    return given
