"""Run ``colias live``: a session and its page, until Ctrl-C."""

from __future__ import annotations

import importlib.util
import ipaddress
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from experiments.bench.run.errors import TrialError, UsageError

if TYPE_CHECKING:
    from experiments.bench.live.page import Page
    from experiments.bench.live.session import Session

LOOPBACK = "127.0.0.1"
IDLE_S = 0.02
"""Time between two looks at what is asked for, while nothing moves."""
RATE_FRAMES = 30
"""Frames over which simulated and wall time are compared."""


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
    session: Session, host: str, port: int, *, dark: bool, ready: Callable[[str], None]
) -> None:  # fmt: skip
    """Serve the page of a session until Ctrl-C.

    Parameters
    ----------
    session
        What the page shows.
    host, port
        Where it listens.
    dark
        Whether the page begins dark.
    ready
        Called with the page's address.
    """
    from threadpoolctl import threadpool_limits

    from experiments.bench.live.page import Page

    page = Page(session, host, port, dark=dark)
    try:
        ready(page.address)
        with threadpool_limits(1):
            serve(page)
    finally:
        page.close()
        session.close()


def serve(page: Page) -> None:
    """Compute and show frame after frame at the page's pace. A slow machine slows it down; no frame is skipped."""
    session, due = page.session, time.perf_counter()
    times: deque[float] = deque(maxlen=RATE_FRAMES)
    while True:
        page.inputs.heed()
        if not page.due():
            time.sleep(IDLE_S)
            due = time.perf_counter()
            times.clear()
            continue
        try:
            view = session.step()
        except (TrialError, UsageError) as error:
            page.tell(str(error))
            if not page.paused:
                page.time("pause")
            continue
        times.append(time.perf_counter())
        rate = (len(times) - 1) * session.interval_s / max(times[-1] - times[0], 1e-6)
        page.show(view, rate)
        wait = session.interval_s / page.pace if session.paced else 0.0
        due = max(due + wait, time.perf_counter() - session.interval_s)
        while (left := due - time.perf_counter()) > 0.0:
            time.sleep(min(left, IDLE_S))
            page.inputs.heed()
