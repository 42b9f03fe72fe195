"""The processes of a vector env: started together, asked together, and gone when it is closed, whatever happens."""

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

from colias_sim.envs.vector.buffers import Buffers
from colias_sim.envs.vector.host import Host, Task
from colias_sim.envs.vector.launch import shared_memory, start_worker
from colias_sim.envs.vector.pickling import check_pickles, cloudpickled, unpack_error
from colias_sim.envs.vector.worker import answer_of

PATIENCE_S = 5.0
"""Seconds that processes may take to end before they are killed."""

CallResults = list[list[Any] | Exception]
"""The result of a call in each process: an entry for each of its envs, or the exception that was raised."""


class InProcess:
    """All envs in this process, with the methods of `Processes`.

    Parameters
    ----------
    task
        The envs.
    options
        The keyword arguments of each env.
    observation_space, action_space
        The spaces of one env.
    """

    def __init__(
        self,
        task: Task,
        options: Mapping[str, Any],
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
    ) -> None:
        memory = bytearray(Buffers.size(observation_space, action_space, task.of))
        self.buffers = Buffers(memory, observation_space, action_space, task.of)
        self._host = Host(task, options, self.buffers)
        self.metadata = self._host.metadata

    def ask(self, method: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """Call ``reset``, ``step`` or ``render`` of the host; return its answer in a list of one."""
        return [answer_of(self._host, method, arguments[0] if arguments else ())]

    def call(self, method: str, arguments: Sequence[tuple[Any, ...]]) -> CallResults:
        """Call a method of the host with a user's own arguments; return its result or exception in a list of one."""
        try:
            return [getattr(self._host, method)(*arguments[0])]
        except Exception as error:
            return [error]

    def close(self) -> None:
        """Close the envs."""
        self._host.close()


class Processes:
    """One process for each task, and the buffers that all of them share.

    A process ends when its pipe does: on `close`, and when this process is gone, however it ends.

    Parameters
    ----------
    tasks
        The envs of each process.
    options
        The keyword arguments of each env.
    observation_space, action_space
        The spaces of one env.

    Raises
    ------
    ValueError
        For options that do not pickle.
    RuntimeError
        If a process dies.
    Exception
        Whatever the envs raise, with a note that has the traceback in the other process. No process is left then.
    """

    def __init__(
        self,
        tasks: Sequence[Task],
        options: Mapping[str, Any],
        observation_space: spaces.Space[Any],
        action_space: spaces.Space[Any],
    ) -> None:
        check_pickles(options)
        self._tasks = tasks
        self._pipes: list[Connection] = []
        self._processes: list[subprocess.Popen[bytes]] = []
        count = tasks[0].of
        size = Buffers.size(observation_space, action_space, count)
        memory = shared_memory(size)
        _ALL.add(self)
        try:
            self.buffers = Buffers(mmap.mmap(memory, size), observation_space, action_space, count)
            for _ in tasks:
                self._start(memory)
            # Sent after all have started: a message that does not fit into the pipe waits until it is read.
            places = [entry for entry in sys.path if isinstance(entry, str)]
            contents = [cloudpickled((task, dict(options), observation_space, action_space)) for task in tasks]
            self._send([(places, content) for content in contents])
            answers = self._receive()
        except BaseException:
            self.close()
            raise
        finally:
            os.close(memory)
        self.metadata: dict[str, Any] = answers[0]

    def ask(self, method: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """Call ``reset``, ``step`` or ``render`` of every host, all at once.

        Parameters
        ----------
        method
            Name of the method.
        arguments
            Arguments for each host.

        Returns
        -------
        list
            The answer of each host.

        Raises
        ------
        RuntimeError
            If a process dies, and in a forked copy of the process that made this object.
        Exception
            Whatever an env raises.
        """
        self._send([(method, arguments[k] if arguments else ()) for k in range(len(self._tasks))])
        return self._receive()

    def call(self, method: str, arguments: Sequence[tuple[Any, ...]]) -> CallResults:
        """Call a method of every host with a user's own arguments, all at once.

        Parameters
        ----------
        method
            Name of the method: ``call`` or ``assign``.
        arguments
            Arguments for each host, of any type that pickles.

        Returns
        -------
        list
            The result of each host, or the exception that it raised.

        Raises
        ------
        RuntimeError
            If a process dies.
        """
        try:
            contents = [cloudpickled(argument) for argument in arguments]
        except Exception as error:
            message = f"what {arguments[0][0]!r} is given does not pickle, which another process needs ({error})"
            return [ValueError(f"{message}: give something that does, or workers=0")]
        self._send([(method, content) for content in contents])
        return [self._result(k, *reply) for k, reply in enumerate(self._receive())]

    def close(self) -> None:
        """End the processes, and kill those that do not end in time.

        A second call does nothing, nor does one in a forked copy of this process.
        """
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
        """Forget the processes, in a forked copy of this process: they must not wait for the copy's end too."""
        for pipe in self._pipes:
            pipe.close()
        for process in self._processes:
            process.returncode = 0  # marked as ended, or `subprocess` would warn that it is still running
        self._pipes, self._processes = [], []

    def _start(self, memory: int) -> None:
        ours, theirs = multiprocessing.Pipe()
        self._pipes.append(ours)
        with theirs:
            self._processes.append(start_worker(theirs.fileno(), memory))

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
                raise unpack_error(answer, self._tasks[k].who)
            answers.append(answer)
        return answers

    def _result(self, k: int, fine: bool, answer: Any) -> list[Any] | Exception:
        if not fine:
            return unpack_error(answer, self._tasks[k].who)
        try:
            given: list[Any] = pickle.loads(answer)
        except Exception as error:
            return ValueError(f"what {self._tasks[k].who} gave cannot be read here ({type(error).__name__}: {error})")
        return given

    def _death(self, k: int) -> RuntimeError:
        try:
            how = _cause(self._processes[k].wait(PATIENCE_S))
        except subprocess.TimeoutExpired:
            how = "without an exit status"
        return RuntimeError(f"the process of {self._tasks[k].who} died, {how}: this vector env is closed")


_ALL: weakref.WeakSet[Processes] = weakref.WeakSet()


def _disown_all() -> None:
    for processes in _ALL:
        processes.disown()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_disown_all)


def _cause(code: int) -> str:
    """Return the return code of a process in words."""
    if code >= 0:
        return f"exit status {code}"
    try:
        return f"signal {signal.Signals(-code).name}"
    except ValueError:  # a real-time signal has no name
        return f"signal {-code}"
