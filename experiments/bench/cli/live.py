"""The command ``colias live``. Heavy imports happen when it runs."""

from __future__ import annotations

from typing import Annotated

import typer

from experiments.bench.cli import options


def live(
    model: options.Models = None,
    only: options.Only = False,
    assignments: options.Assignments = None,
    seed: options.Seed = 0,
    port: Annotated[int, typer.Option(min=1, max=65535, help="Of the page, on this machine.")] = 8099,
) -> int:
    r"""Show a trial while it runs, in a page: the camera's frame, HS and VS against T, spikes, and what a frame costs.

    Keys I and K drive the stimulus ahead and back, J and L turn it, X stops it; with shift they drive the observer.
    Space pauses, N is one frame, R begins again, C records. The model's parameters are sliders.

    record writes a run of the trial since it began, which colias run --again repeats bit for bit. The command's own
    model is dsnn. Needs viser: the extra [live]. Open the
    address that it prints in a browser; Ctrl-C ends it.
    """
    import importlib.util

    from threadpoolctl import threadpool_limits

    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.models import shown_models
    from experiments.bench.run.settings import check_counts

    check_counts(seed)
    if importlib.util.find_spec("viser") is None:
        raise UsageError("colias live needs viser: run 'sh tools/setup.sh --live', or install colias-sim[live]")
    from experiments.bench.live.page import Page
    from experiments.bench.live.session import Session

    page = Page(Session(shown_models(["dsnn"], model, only), assignments or (), seed), port)
    with threadpool_limits(1):
        page.serve()
    return 0
