"""Rerun's viewer, or its web server, as a process that ends with the command that opened it."""

from __future__ import annotations

import re
import signal
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

from experiments.bench.engine.terminal import program
from experiments.bench.run import interrupts
from experiments.bench.run.errors import UsageError

PATIENCE_S = 5.0
"""How long a viewer may take to end before it is killed."""
ENDING = ("SIGTERM", "SIGHUP")


def show(files: Sequence[Path], *, web: bool = False, instead: str) -> int:
    """Open recordings in Rerun, listening on 127.0.0.1 only, and wait until it is closed; returns its exit status.

    When this process ends, the viewer ends too, unless this is killed. Raises `UsageError`, which tells ``instead``,
    where its window does not open.
    """
    paths = [str(file.absolute()) for file in files]  # a name such as --save=a.rrd is no option
    command = [*program(), "--bind", "127.0.0.1", *(["--web-viewer"] if web else []), *paths]
    if web:  # what it says has the address in it
        return _attend(command, None)
    with tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace") as output:
        status = _attend(command, output)
        output.seek(0)
        # Without the place in its source.
        why = [re.sub(r"^Error: (.*\.rs:\d+: )?", "", line.strip()) for line in output if line.startswith("Error: ")]
    if status > 0:
        reason = why[-1] if why else f"exit status {status}"
        raise UsageError(f"Rerun's viewer did not open, or broke off ({reason}): {instead}")
    return status


def _attend(command: Sequence[str], output: IO[str] | None) -> int:
    """Run a command until it ends, and no longer than this process; ``output`` takes what it writes."""
    with _ended_in_order(), interrupts.held():
        # In a session of its own a terminal's Ctrl-C comes to this process alone, which then ends the viewer.
        child = subprocess.Popen(command, stdout=output, stderr=output, start_new_session=True)
        try:
            with interrupts.window():
                status = child.wait()
        finally:
            _end(child)
    return status if status >= 0 else 128 - status


def _end(child: subprocess.Popen[Any]) -> None:
    child.terminate()
    try:
        child.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        child.kill()
        child.wait()


@contextmanager
def _ended_in_order() -> Iterator[None]:
    """While this lasts, a signal that asks this process to end lets it end what it has started first."""

    def leave(number: int, _: Any) -> None:
        raise SystemExit(128 + number)

    numbers = [getattr(signal, name) for name in ENDING if hasattr(signal, name)]
    heeded = [number for number in numbers if signal.getsignal(number) is not signal.SIG_IGN]  # nohup's stays ignored
    before = {number: signal.signal(number, leave) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
