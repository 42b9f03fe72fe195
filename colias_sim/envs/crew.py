"""The processes of a vector env: started and asked all at once, and gone when it is closed, whatever happens."""

from __future__ import annotations

import mmap
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
import weakref
from collections.abc import Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any

from gymnasium import spaces

from colias_sim.envs.hosting import Board, Host, Task
from colias_sim.envs.launching import launched, shared_memory
from colias_sim.envs.serving import answered
from colias_sim.envs.telling import check_pickles, cloudpickled, restored

PATIENCE_S = 5.0
"""How long processes may take to end before they are killed."""

Replies = list[list[Any] | Exception]
"""What each host gives to a call, an entry for each of its envs; or what it raises."""


class Here:
    """No other process: one host in this one. Offers what `Crew` does."""

    def __init__(self, task: Task, options: Mapping[str, Any], seen: spaces.Space[Any], acted: spaces.Space[Any]):
        self.board = Board(bytearray(Board.size(seen, acted, task.of)), seen, acted, task.of)
        self._host = Host(task, options, self.board)
        self.metadata = self._host.metadata

    def ask(self, what: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """What the host's method ``what`` gives, in a list; infos are packed."""
        return [answered(self._host, what, arguments[0] if arguments else ())]

    def call(self, what: str, arguments: Sequence[tuple[Any, ...]]) -> Replies:
        """What the host's method ``what`` gives or raises, in a list."""
        try:
            return [getattr(self._host, what)(*arguments[0])]
        except Exception as error:
            return [error]

    def close(self) -> None:
        """Close the envs."""
        self._host.close()


class Crew:
    """A process for each task, with a board in memory that all share and that has no name to be left behind.

    Raises what a process raises, in one line and with a note of where; ``RuntimeError`` for one that dies; and
    ``ValueError`` for options that do not pickle. Nothing is left then. A process ends when its pipe does: on close,
    and when this process is gone.
    """

    def __init__(
        self, tasks: Sequence[Task], options: Mapping[str, Any], seen: spaces.Space[Any], acted: spaces.Space[Any]
    ) -> None:
        check_pickles(options)
        self._tasks = tasks
        self._pipes: list[Connection] = []
        self._processes: list[subprocess.Popen[bytes]] = []
        size, of = Board.size(seen, acted, tasks[0].of), tasks[0].of
        memory = shared_memory(size)
        _CREWS.add(self)
        try:
            self.board = Board(mmap.mmap(memory, size), seen, acted, of)
            for _ in tasks:
                self._start(memory)
            # Only now: a process reads what does not fit into a pipe once its interpreter is up.
            places = [entry for entry in sys.path if isinstance(entry, str)]
            self._send([(places, cloudpickled((task, dict(options), seen, acted))) for task in tasks])
            answers = self._receive()
        except BaseException:
            self.close()
            raise
        finally:
            os.close(memory)
        self.metadata: dict[str, Any] = answers[0]

    def ask(self, what: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """What every host's method ``what`` gives, all working at once; arguments are a tuple for each."""
        self._send([(what, arguments[k] if arguments else ()) for k in range(len(self._tasks))])
        return self._receive()

    def call(self, what: str, arguments: Sequence[tuple[Any, ...]]) -> Replies:
        """What every host's method ``what`` gives or raises, of arguments and results that are the user's own.

        Raises only what `ask` does of a process that dies.
        """
        try:
            contents = [cloudpickled(each) for each in arguments]
        except Exception as error:
            said = f"what {arguments[0][0]!r} is given does not pickle, which another process needs ({error})"
            return [ValueError(f"{said}: give something that does, or workers=0")]
        self._send([(what, content) for content in contents])
        return [self._result(k, *reply) for k, reply in enumerate(self._receive())]

    def close(self) -> None:
        """Let all end, kill who does not; a second call does nothing, nor one in a forked copy of this process."""
        for pipe in self._pipes:
            pipe.close()
        self._pipes = []
        deadline = time.monotonic() + PATIENCE_S
        for process in self._processes:
            try:
                process.wait(max(deadline - time.monotonic(), 0.0))
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
        self._processes = []

    def disown(self) -> None:
        """In a forked copy of this process: the processes are not its own, and must not wait for it to end too."""
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.returncode = 0  # nothing to wait for, which `subprocess` would warn of
        self._pipes, self._processes = [], []

    def _start(self, memory: int) -> None:
        ours, theirs = multiprocessing.Pipe()
        self._pipes.append(ours)
        with theirs:
            self._processes.append(launched(theirs.fileno(), memory))

    def _send(self, messages: Sequence[Any]) -> None:
        if not self._pipes:
            raise RuntimeError("this vector env belongs to the process that made it, not to forked copies of that")
        for k, message in enumerate(messages):
            try:
                self._pipes[k].send(message)
            except OSError:
                raise self._death(k) from None

    def _receive(self) -> list[Any]:
        answers = []
        for k, pipe in enumerate(self._pipes):
            try:
                fine, answer = pipe.recv()
            except (EOFError, OSError):
                raise self._death(k) from None
            if not fine:
                raise restored(answer, self._tasks[k].who)
            answers.append(answer)
        return answers

    def _result(self, k: int, fine: bool, answer: Any) -> list[Any] | Exception:
        if not fine:
            return restored(answer, self._tasks[k].who)
        try:
            given: list[Any] = pickle.loads(answer)
        except Exception as error:
            return ValueError(f"what {self._tasks[k].who} gave cannot be read here ({type(error).__name__}: {error})")
        return given

    def _death(self, k: int) -> RuntimeError:
        try:
            how = _said(self._processes[k].wait(PATIENCE_S))
        except subprocess.TimeoutExpired:
            how = "without an exit status"
        return RuntimeError(f"the process of {self._tasks[k].who} died, {how}: this vector env is closed")


_CREWS: weakref.WeakSet[Crew] = weakref.WeakSet()


def _disown_all() -> None:
    for crew in _CREWS:
        crew.disown()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_disown_all)


def _said(code: int) -> str:
    if code >= 0:
        return f"exit status {code}"
    try:
        return f"signal {signal.Signals(-code).name}"
    except ValueError:  # a real-time signal has no name
        return f"signal {-code}"
