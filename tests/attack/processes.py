"""Commands as a person starts them: real processes, in a session of their own, marked so that none is lost sight of.

A command is a copy of a process that has the large libraries (`tests.helpers.warm`), where its start is not what is
attacked: where it is to be interrupted, Python itself starts.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from tests.conftest import one_core, own_core, server

ROOT = Path(__file__).parents[2]
ENTRY = "experiments.bench.cli"
"""The module that is the command line."""

MARK = "COLIAS_ATTACK"
"""The environment variable by which the processes of one command are found, whoever their parent is by then."""

GRACE_S = 8.0
"""How long a command's other processes may take to end after it."""

CRASHES = (
    "Traceback",
    "Exception ignored",
    "Exception in thread",
    "initialization failed",
    "Fatal Python error",
    "leaked",
    "core dumped",
)
"""What no command may ever say."""


@dataclass(frozen=True, slots=True)
class Ended:
    """What became of a command: exit status (negative: a signal), what it said, the processes it left (killed since).

    ``status`` is ``None`` where it had to be killed because it did not end.
    """

    status: int | None
    out: str
    err: str
    left: tuple[str, ...]

    def crashes(self) -> list[str]:
        """The words of `CRASHES` that it said."""
        return [word for word in CRASHES if word in self.err or word in self.out]


@dataclass(frozen=True, slots=True)
class Interrupt:
    """SIGINT, ``after_s`` from the start: to the process alone, or to its whole group as a terminal does."""

    after_s: float
    group: bool


def colias(
    folder: Path,
    arguments: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    interrupt: Interrupt | None = None,
    timeout_s: float = 150.0,
) -> Ended:
    """Run ``colias ARGUMENTS`` in ``folder`` to its end."""
    if interrupt is None and hasattr(os, "fork"):
        return _warm(folder, arguments, environment, timeout_s)
    return python(folder, ("-m", ENTRY, *arguments), environment=environment, interrupt=interrupt, timeout_s=timeout_s)


def python(
    folder: Path,
    arguments: Sequence[str],
    *,
    environment: Mapping[str, str] | None = None,
    interrupt: Interrupt | None = None,
    timeout_s: float = 150.0,
) -> Ended:
    """Run Python in ``folder``; its output goes to files, as a pipe would wait for whoever still holds it."""
    mark = uuid.uuid4().hex
    with _streams(folder, mark) as (out, err):
        process = subprocess.Popen(
            [sys.executable, *arguments], cwd=folder, env=_environment(mark, environment), stdin=subprocess.DEVNULL,
            stdout=out, stderr=err, start_new_session=True, preexec_fn=_prepare,
        )  # fmt: skip
        try:
            status = _wait(process, interrupt, timeout_s)
        finally:
            left = _left_behind(mark, process.pid)
        return Ended(status, _text(out), _text(err), tuple(left))


def _warm(folder: Path, arguments: Sequence[str], environment: Mapping[str, str] | None, timeout_s: float) -> Ended:
    """Run ``colias ARGUMENTS`` as a copy of a process that has its libraries."""
    mark, status, session = uuid.uuid4().hex, None, 0
    with _streams(folder, mark) as (out, err):
        try:
            session = server().start(
                [*arguments], folder, _environment(mark, environment), own_core(), (out.fileno(), err.fileno()),
                session=True,
            )  # fmt: skip
            status = server().wait(timeout_s)
        finally:
            left = _left_behind(mark, session)
        return Ended(status, _text(out), _text(err), tuple(left))


@contextlib.contextmanager
def _streams(folder: Path, mark: str) -> Iterator[tuple[IO[bytes], IO[bytes]]]:
    """Files beside ``folder`` for what a command prints, while it runs."""
    paths = [folder.parent / f"{folder.name}.{mark[:8]}.{end}" for end in ("out", "err")]
    with paths[0].open("w+b") as out, paths[1].open("w+b") as err:
        yield out, err
    for path in paths:
        path.unlink()


def _prepare() -> None:
    one_core()
    signal.signal(signal.SIGINT, signal.SIG_DFL)  # a shell starts what is in its background with SIGINT ignored


def _environment(mark: str, more: Mapping[str, str] | None) -> dict[str, str]:
    inherited = {
        name: value for name, value in os.environ.items() if "DISPLAY" not in name and not name.startswith("PYTEST")
    }
    return {
        **inherited,
        "PYTHONPATH": str(ROOT),
        "COLUMNS": "100",
        "BROWSER": "/bin/true",
        "PYTHONFAULTHANDLER": "",
        MARK: mark,
        **(more or {}),
    }


def _wait(process: subprocess.Popen[bytes], interrupt: Interrupt | None, timeout_s: float) -> int | None:
    deadline = time.monotonic() + timeout_s
    try:
        if interrupt is not None:
            try:
                return process.wait(interrupt.after_s)
            except subprocess.TimeoutExpired:
                (os.killpg if interrupt.group else os.kill)(process.pid, signal.SIGINT)
        return process.wait(max(deadline - time.monotonic(), 0.0))
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return None
    except BaseException:
        process.kill()
        process.wait()
        raise


def _left_behind(mark: str, session: int) -> list[str]:
    """The processes with this mark or of this session that do not end within the grace; they are killed."""
    deadline = time.monotonic() + GRACE_S
    while (there := _there(mark, session)) and time.monotonic() < deadline:
        time.sleep(0.05)
    for pid in there:
        with contextlib.suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)
    return sorted(there.values())


def _there(mark: str, session: int) -> dict[int, str]:
    """The living processes with this mark in their environment, or of this session: process id -> command line."""
    wanted = f"{MARK}={mark}".encode()
    command_lines = {}
    for place in Path("/proc").iterdir():
        if place.name.isdigit():
            try:
                state, _, _, number = (place / "stat").read_text().rsplit(")", 1)[1].split()[:4]
                ours = int(number) == session or wanted in (place / "environ").read_bytes().split(b"\0")
                if ours and state != "Z":
                    command_lines[int(place.name)] = (
                        (place / "cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
                    )
            except OSError:  # it has ended, or is another user's
                continue
    return command_lines


def _text(stream: IO[bytes]) -> str:
    stream.seek(0)
    return stream.read().decode("utf-8", errors="replace")
