"""The command ``colias live``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli.options import Assignments, Models, Only, Seed


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Drive the stimulus by hand, in a browser, and watch the network.")(live)


def live(
    model: Models = None,
    only: Only = False,
    assignments: Assignments = None,
    seed: Seed = 0,
    host: Annotated[
        str, typer.Option(help="Where the page listens. Anything but this machine itself is protected by nothing.")
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Of the page.")] = 8099,
    dark: Annotated[bool, typer.Option("--dark", help="Begin with a dark page.")] = False,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
) -> int:
    """Show a trial while it runs, in a page: the camera's frame, HS and VS against T, spikes, and what a frame costs.

    Keys W and S drive the stimulus forward and backward, A and D turn it, X stops it; with shift they drive the
    observer. Space pauses, N is one frame, R begins again, E records. The model's parameters are sliders.

    [b]record[/b] writes a run of what was done since the trial began, which [b]colias rerun[/b] repeats bit for bit.
    The command's own model is dsnn. Needs viser: the extra [b]\\[live][/b]. Ctrl-C ends it.
    """
    import webbrowser

    from experiments.bench.engine.models import shown_models
    from experiments.bench.engine.settings import check_counts
    from experiments.bench.engine.terminal import error_console, out_console
    from experiments.bench.live import run

    check_counts(seed)
    run.require_viser()
    if warning := run.check_host(host, port):
        error_console.print(warning, soft_wrap=True, markup=False)

    def ready(address: str) -> None:
        out_console.print(f"{address}  (Ctrl-C ends it)", soft_wrap=True, markup=False)
        if browser:
            webbrowser.open(address)

    return run.run(shown_models(["dsnn"], model, only), assignments or (), seed, host, port, dark=dark, ready=ready)
