"""The command ``colias live``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli import options


def live(
    experiment: Annotated[
        str,
        typer.Argument(
            help="Begin with its first condition in a loop: a name that colias list shows, or a .py file.",
            autocompletion=options.experiment_names,
            show_default=False,
        ),
    ] = "",
    model: options.Models = None,
    only: options.Only = False,
    assignments: options.Assignments = None,
    seed: options.Seed = 0,
    footage: Annotated[
        str | None,
        typer.Option(metavar="FILE|CAMERA", help="Show a video file, or a camera (its index from 0), not the arena."),
    ] = None,
    behaviour: Annotated[
        str,
        typer.Option(
            metavar="NAME|FILE",
            show_default=False,
            help="Begin with the observer driven by it: a name that colias list shows, a .py file or a .npz.",
        ),
    ] = "",
    port: Annotated[int, typer.Option(min=1, max=65535, help="Of the page, on this machine.")] = 8099,
    browser: Annotated[bool, typer.Option(help="Open the page in a browser.")] = True,
) -> int:
    r"""Show a trial while it runs, in a page: the camera's frame, HS and VS against T, spikes, and what a frame costs.

    Keys I and K drive the stimulus ahead and back, J and L turn it, X stops it; with shift they drive the observer.
    Space pauses, N is one frame, R begins again, C records. The model's parameters are sliders.

    record writes a run of what was done since the trial began, which colias run --again repeats bit for bit.
    With --footage there is nothing to drive, and --set reaches the models alone; colias watch records it.
    The command's own model is dsnn, or those that the experiment declares. Needs viser: the extra [live].
    Ctrl-C ends it.
    """
    import importlib.util
    import webbrowser

    from threadpoolctl import threadpool_limits

    from experiments.bench import registry
    from experiments.bench.report.terminal import error_console, out_console
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.models import shown_models
    from experiments.bench.run.settings import check_counts

    check_counts(seed)
    if importlib.util.find_spec("viser") is None:
        raise UsageError("colias live needs viser: run 'sh tools/setup.sh --live', or install colias-sim[live]")
    if footage is not None and (given := experiment or behaviour):
        raise UsageError(f"--footage {footage}: has no arena for {given}; give one of the two")

    from experiments.bench.live.page import Page
    from experiments.bench.live.session import ArenaSession, FootageSession

    session: ArenaSession | FootageSession
    if footage is None:
        declared = registry.load(experiment).models if experiment else ["dsnn"]
        models = shown_models(declared, model, only)
        session = ArenaSession(models, assignments or (), seed, experiment=experiment, behaviour=behaviour)
    else:
        session = FootageSession(footage, shown_models(["dsnn"], model, only), assignments or ())
        for note in session.notes():
            error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    page = Page(session, port)
    out_console.print(f"{page.address}  (Ctrl-C ends it)", soft_wrap=True, markup=False)
    if browser:
        webbrowser.open(page.address)
    with threadpool_limits(1):
        page.serve()
    return 0
