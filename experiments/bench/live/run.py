"""Run ``colias live``: the trial and its page, until Ctrl-C."""

from __future__ import annotations

import importlib.util
import ipaddress
import socket
import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from experiments.bench.engine.errors import UsageError

if TYPE_CHECKING:
    from experiments.bench.live.page import Page

LOOPBACK = "127.0.0.1"
IDLE_S = 0.02
"""Time between two looks at what is asked for, while nothing moves."""


def require_viser() -> None:
    """Raise `UsageError` where the extra is not installed."""
    if importlib.util.find_spec("viser") is None:
        raise UsageError(
            "colias live needs viser, which is not installed: run 'sh tools/setup.sh --live', or install"
            " colias-sim[live]"
        )


def check_host(host: str, port: int) -> str:
    """Return a warning of an address that others reach; empty of one of this machine alone.

    Raises
    ------
    UsageError
        The address is none, or something listens there already.
    """
    try:
        address = ipaddress.ip_address(LOOPBACK if host == "localhost" else host)
    except ValueError:
        raise UsageError(f"--host {host}: legal is an address of this machine, for example {LOOPBACK}") from None
    with socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((str(address), port))
        except OSError as error:
            raise UsageError(f"--host {host} --port {port}: {error.strerror}; choose another port") from None
    if address.is_loopback:
        return ""
    return (
        f"warning: the page listens on {host}: whoever reaches this machine can drive it and write runs here; nothing"
        " protects it"
    )


def run(
    models: Sequence[str], assignments: Sequence[str], seed: int, host: str, port: int, *,
    dark: bool = False, frames: int | None = None, ready: Callable[[str], None] = lambda address: None,
) -> int:  # fmt: skip
    """Serve the page until Ctrl-C, or for a number of frames.

    Parameters
    ----------
    models, assignments, seed
        As of a `Session`.
    host, port
        Where it listens.
    dark
        Whether the page begins dark.
    frames
        After how many frames it ends; ``None``: never.
    ready
        Called with the page's address.

    Returns
    -------
    int
        The exit status.

    Raises
    ------
    UsageError
        viser is not installed, or the session cannot be had.
    """
    require_viser()
    from threadpoolctl import threadpool_limits

    from experiments.bench.live.page import Page
    from experiments.bench.live.session import Session

    session = Session(models, assignments, seed)
    page = Page(session, host, port, dark=dark)
    try:
        ready(page.address)
        with threadpool_limits(1):
            serve(page, frames)
    finally:
        page.close()
    return 0


def serve(page: Page, frames: int | None = None) -> None:
    """Compute and show frame after frame at the page's pace. A slow machine slows it down; no frame is skipped.

    Parameters
    ----------
    page
        The `Page`.
    frames
        How many; ``None``: without an end.
    """
    from experiments.bench.robot.trial import TrialError

    due, rate, shown = time.perf_counter(), 0.0, 0
    while frames is None or shown < frames:
        page.heed()
        if not page.due():
            time.sleep(IDLE_S)
            due = time.perf_counter()
            continue
        began = time.perf_counter()
        try:
            view = page.session.step()
        except (TrialError, UsageError) as error:
            page.tell(str(error))
            page.paused = True
            continue
        interval = page.session.trial.sim.frame_interval
        page.show(view, rate)
        shown += 1
        due = max(due + interval / page.pace, time.perf_counter() - interval)
        while (left := due - time.perf_counter()) > 0.0:
            time.sleep(min(left, IDLE_S))
            page.heed()
        rate += 0.1 * (interval / max(time.perf_counter() - began, 1e-6) - rate)
