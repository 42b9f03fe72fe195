"""The processes of a vector env: started by spawn, asked all at once, and gone when it is closed, whatever happens."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import multiprocessing
import os
import pickle
import signal
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from multiprocessing.connection import Connection
from typing import Any

import cv2
from gymnasium import spaces
from gymnasium.vector.utils import CloudpickleWrapper
from threadpoolctl import threadpool_limits

from colias_sim.envs.hosting import Board, Host, Task
from colias_sim.envs.infos import packed

PATIENCE_S = 5.0
"""How long a process may take to end before it is killed."""

_SPAWN = multiprocessing.get_context("spawn")  # a process forked with an OpenGL context hangs


class Here:
    """No other process: one host in this one. Offers what `Crew` does."""

    def __init__(self, task: Task, options: Mapping[str, Any], seen: spaces.Space[Any], acted: spaces.Space[Any]):
        self.board = Board(bytearray(Board.size(seen, acted, task.of)), seen, acted, task.of)
        self._host = Host(task, options, self.board)
        self.metadata = self._host.metadata

    def ask(self, what: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """What the host's method ``what`` gives, in a list; infos are packed."""
        return [_answer(self._host, what, arguments[0] if arguments else ())]

    def close(self) -> None:
        """Close the envs."""
        self._host.close()


class Crew:
    """A process for each task, with a board in memory that all share and that has no name to be left behind.

    Raises what a process raises, in one line and with a note of where; ``RuntimeError`` for one that dies; and
    ``ValueError`` for options that do not pickle. Nothing is left then.
    """

    def __init__(
        self, tasks: Sequence[Task], options: Mapping[str, Any], seen: spaces.Space[Any], acted: spaces.Space[Any]
    ) -> None:
        content = _pickled(options)
        self._owner = os.getpid()
        self._tasks = tasks
        self._pipes: list[Connection] = []
        self._processes: list[Any] = []
        memory = _SPAWN.RawArray(ctypes.c_uint8, Board.size(seen, acted, tasks[0].of))
        self.board = Board(memory, seen, acted, tasks[0].of)
        try:
            for task in tasks:
                self._start(task, content, memory, seen, acted)
            answers = [self._receive(k) for k in range(len(tasks))]
        except BaseException:
            self.close()
            raise
        self.metadata: dict[str, Any] = answers[0]

    def ask(self, what: str, arguments: Sequence[tuple[Any, ...]] | None = None) -> list[Any]:
        """What every host's method ``what`` gives, all working at once; arguments are a tuple for each."""
        for k, pipe in enumerate(self._pipes):
            try:
                pipe.send((what, arguments[k] if arguments else ()))
            except OSError:
                raise self._death(k) from None
        return [self._receive(k) for k in range(len(self._pipes))]

    def close(self) -> None:
        """Ask all to end, kill who does not; a second call does nothing, nor one in a forked copy of this process."""
        if os.getpid() != self._owner:
            return
        for pipe in self._pipes:
            with contextlib.suppress(OSError):
                pipe.send(None)
            pipe.close()
        self._pipes = []
        for process in self._processes:
            process.join(PATIENCE_S)
            if process.is_alive():
                process.kill()
                process.join()
            process.close()
        self._processes = []

    def _start(self, task: Task, *rest: Any) -> None:
        ours, theirs = _SPAWN.Pipe()
        self._pipes.append(ours)
        process = _SPAWN.Process(target=_serve, args=(theirs, task, *rest), daemon=True, name=f"colias {task.who}")
        with theirs, _no_interrupt():  # Ctrl-C goes to all of a terminal's processes: it is this one's to handle
            process.start()
        self._processes.append(process)

    def _receive(self, k: int) -> Any:
        try:
            fine, answer = self._pipes[k].recv()
        except (EOFError, OSError):
            raise self._death(k) from None
        if not fine:
            raise _restored(answer, self._tasks[k].who)
        return answer

    def _death(self, k: int) -> RuntimeError:
        process = self._processes[k]
        process.join(PATIENCE_S)
        code = process.exitcode
        how = f"signal {signal.Signals(-code).name}" if code is not None and code < 0 else f"exit status {code}"
        guard = "" if hasattr(self, "metadata") else "; a script that makes envs needs 'if __name__ == \"__main__\":'"
        return RuntimeError(f"the process of {self._tasks[k].who} died, {how}: this vector env is closed{guard}")


def _serve(
    pipe: Connection, task: Task, content: bytes, memory: Any, seen: spaces.Space[Any], acted: spaces.Space[Any]
) -> None:
    """A worker's life: answer until told to end, or until nobody is there to ask."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    host: Host | None = None
    try:
        host = Host(task, pickle.loads(content).fn, Board(memory, seen, acted, task.of))
        _tune()
        pipe.send((True, host.metadata))
        while (question := pipe.recv()) is not None:
            pipe.send((True, _answer(host, *question)))
    except (EOFError, ConnectionError):
        pass  # the parent died, or closed in the middle
    except Exception as error:
        with contextlib.suppress(OSError):
            pipe.send((False, _told(error)))
    finally:
        if host is not None:
            host.close()


def _answer(host: Host, what: str, arguments: tuple[Any, ...]) -> Any:
    given = getattr(host, what)(*arguments)
    return given if what == "render" else packed(given)


def _tune() -> None:
    """One thread, as there is a process for each core already; and no look-out for garbage in what is there to stay."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    gc.collect()
    gc.freeze()


@contextlib.contextmanager
def _no_interrupt() -> Iterator[None]:
    """Start a process deaf to Ctrl-C from its first moment: it inherits what is blocked."""
    if sys.platform == "win32":
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _pickled(options: Mapping[str, Any]) -> bytes:
    """The options by cloudpickle, which takes functions of a script or notebook along."""
    for name, value in options.items():
        try:
            _cloudpickled(value)
        except Exception as error:
            raise ValueError(
                f"{name}={value!r} does not pickle, which another process needs ({error}): "
                "give something that does, or workers=0"
            ) from None
    return _cloudpickled(dict(options))


def _cloudpickled(value: Any) -> bytes:
    return pickle.dumps(CloudpickleWrapper(value))


def _told(error: Exception) -> tuple[bytes | None, str, str]:
    """An exception for the pipe: itself if it survives pickling, its one line, its traceback."""
    content: bytes | None
    try:
        content = pickle.dumps(error)
        pickle.loads(content)
    except Exception:
        content = None
    return content, f"{type(error).__name__}: {error}", "".join(traceback.format_exception(error))


def _restored(told: tuple[bytes | None, str, str], who: str) -> Exception:
    content, line, trace = told
    error: Exception
    try:
        error = RuntimeError(line) if content is None else pickle.loads(content)
    except Exception:
        error = RuntimeError(line)
    error.add_note(f"in the process of {who}, where it came of:\n{trace}")
    return error
