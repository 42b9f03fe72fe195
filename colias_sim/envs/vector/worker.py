"""Main loop in a process of a vector env: it hosts envs and answers requests until its pipe ends."""

from __future__ import annotations

import contextlib
import gc
import mmap
import os
import pickle
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any

import cv2
from threadpoolctl import threadpool_limits

from colias_sim.envs.vector.buffers import Buffers
from colias_sim.envs.vector.host import Host
from colias_sim.envs.vector.info import pack_infos
from colias_sim.envs.vector.pickling import cloudpickled, pack_error

Reply = tuple[bool, Any]
"""Reply to a request: whether it succeeded; then its answer, otherwise the error as `PackedError`."""


def serve(pipe: Connection, memory: int, content: bytes) -> None:
    """Host envs, and answer requests until one fails or the other end of the pipe is closed.

    Parameters
    ----------
    pipe
        Carries requests in, (method of `Host`, arguments), and replies out, `Reply`; the first reply is the envs'
        metadata.
    memory
        File descriptor of the memory of `Buffers`.
    content
        The pickle of the task, the options of the envs, their observation space and their action space.
    """
    hosts: list[Host] = []

    def begin() -> dict[str, Any]:
        task, options, observation_space, action_space = pickle.loads(content)
        block = mmap.mmap(memory, Buffers.size(observation_space, action_space, task.of))
        os.close(memory)
        hosts.append(Host(task, options, Buffers(block, observation_space, action_space, task.of)))
        _tune()
        return hosts[0].metadata

    try:
        fine, answer = _tried(begin)
        with contextlib.suppress(EOFError, ConnectionError):  # the other process has closed the pipe, or died
            pipe.send((fine, answer))
            while fine:
                method, arguments = pipe.recv()
                fine, answer = _tried(_answer, hosts[0], method, arguments)
                pipe.send((fine, answer))
    finally:
        for host in hosts:
            host.close()


def answer_of(host: Host, method: str, arguments: tuple[Any, ...]) -> Any:
    """Call ``reset``, ``step`` or ``render`` of a host; return the infos packed, or the pictures."""
    given = getattr(host, method)(*arguments)
    return given if method == "render" else pack_infos(given)


def _answer(host: Host, method: str, arguments: tuple[Any, ...] | bytes) -> Any:
    """Answer a request. Arguments that are a user's own come pickled; errors of these requests are answers."""
    if isinstance(arguments, bytes):
        return _tried(_called, host, method, arguments)
    return answer_of(host, method, arguments)


def _called(host: Host, method: str, content: bytes) -> bytes:
    given = getattr(host, method)(*pickle.loads(content))
    try:
        return cloudpickled(given)
    except Exception as error:
        raise ValueError(
            f"what {host.who} gave does not pickle, which another process needs ({error}): "
            "ask for something that does, or give workers=0"
        ) from None


def _tried(function: Callable[..., Any], *arguments: Any) -> Reply:
    try:
        return True, function(*arguments)
    except (Exception, SystemExit) as error:  # sys.exit in a user's model is no end of the process
        return False, pack_error(error)


def _tune() -> None:
    """Use one thread, as there is a process for each core; exempt what is there to stay from garbage collection."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    gc.collect()
    gc.freeze()
