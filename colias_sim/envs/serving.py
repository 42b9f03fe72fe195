"""What a vector env's worker does all its life: host envs, and answer."""

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

from colias_sim.envs.hosting import Board, Host
from colias_sim.envs.infos import packed
from colias_sim.envs.telling import cloudpickled, told

Reply = tuple[bool, Any]
"""Whether all went well, and then the answer, otherwise the error as `told`."""


def serve(pipe: Connection, board: int, content: bytes) -> None:
    """Host what ``content`` says, on the board's memory; answer until an error, or until nobody is there to ask."""
    hosts: list[Host] = []

    def begin() -> dict[str, Any]:
        task, options, seen, acted = pickle.loads(content)
        memory = mmap.mmap(board, Board.size(seen, acted, task.of))
        os.close(board)
        hosts.append(Host(task, options, Board(memory, seen, acted, task.of)))
        _tune()
        return hosts[0].metadata

    try:
        fine, answer = _tried(begin)
        with contextlib.suppress(EOFError, ConnectionError):  # the parent died, or closed
            pipe.send((fine, answer))
            while fine:
                what, arguments = pipe.recv()
                fine, answer = _tried(_answer, hosts[0], what, arguments)
                pipe.send((fine, answer))
    finally:
        for host in hosts:
            host.close()


def answered(host: Host, what: str, arguments: tuple[Any, ...]) -> Any:
    """What the host's method ``what`` gives; infos are packed."""
    given = getattr(host, what)(*arguments)
    return given if what == "render" else packed(given)


def _answer(host: Host, what: str, arguments: tuple[Any, ...] | bytes) -> Any:
    """Questions of the user's own wording come pickled. Their errors are answers: the envs go on."""
    if isinstance(arguments, bytes):
        return _tried(_called, host, what, arguments)
    return answered(host, what, arguments)


def _called(host: Host, what: str, content: bytes) -> bytes:
    given = getattr(host, what)(*pickle.loads(content))
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
    except Exception as error:
        return False, told(error)


def _tune() -> None:
    """One thread, as there is a process for each core already; and no look-out for garbage in what is there to stay."""
    cv2.setNumThreads(1)
    threadpool_limits(1)
    gc.collect()
    gc.freeze()
