"""Processes that start quickly: each is a copy of one that has imported the large libraries already.

Most of what a short ``colias`` command takes is the import of NumPy, SciPy, Matplotlib, MuJoCo and of the bench. `Warm`
starts a server that has imported them. The server copies itself (fork) for each command, so a command is a process of
its own as a user's is: with its folder, environment, streams and exit status, and with OpenGL imported anew. A command
whose environment is not the server's imports all of this project anew too, since the bench reads some of it when it is
imported: its consoles are as wide as ``COLUMNS``. The tests of starting and of ending
(`tests/helpers/processes.py`, tests/bench/engine/test_interrupts.py, tests/bench/store/test_resume.py) start Python
itself.
"""

from __future__ import annotations

import contextlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

LIBRARIES = (
    "numpy", "numpy.f2py", "scipy.special", "scipy.stats", "scipy.optimize", "pydantic", "pydantic.dataclasses",
    "pydantic.type_adapter", "typer", "rich.console", "rich.markdown", "rich.table", "rich.progress",
    "matplotlib.figure", "matplotlib.backends.backend_agg", "matplotlib.backends.backend_svg", "PIL.PngImagePlugin",
    "pyarrow", "pyarrow.parquet", "pyarrow.csv", "pyarrow.compute", "cv2", "gymnasium", "jinja2", "filelock", "attr",
    "attrs", "psutil", "threadpoolctl", "tomllib", "importlib.resources.readers", "multiprocessing.popen_spawn_posix",
)  # fmt: skip
"""What the server imports; none of it starts a thread or reads an environment variable that tests set."""
OURS = (
    "dsnn", "colias_sim.simulation", "experiments.bench.cli.main", "experiments.bench.trials",
    "experiments.bench.robot.summary", "experiments.bench.offline", "experiments.bench.closed_loop.run",
    "experiments.bench.studies.run",
)  # fmt: skip
"""What it imports of this project, and with it MuJoCo, without its OpenGL."""
PACKAGES = ("dsnn", "colias_sim", "experiments", "scenes")
OTHERWISE = ("PYTEST_CURRENT_TEST", "MUJOCO_GL", "LP_NUM_THREADS", "EGL_LOG_LEVEL", "OPENBLAS_NUM_THREADS")
"""Environment variables that nothing reads at its import, or that are set by what is imported."""
MODULE = "experiments.bench.cli"


class Warm:
    """The server, and the commands that it starts. One test process uses it, for one command at a time."""

    def __init__(self) -> None:
        ours, theirs = socket.socketpair()
        environment = os.environ | {"OPENBLAS_NUM_THREADS": "1"}
        command = [sys.executable, "-m", "tests.helpers.warm", str(theirs.fileno())]
        root = Path(__file__).parents[2]
        self._server = subprocess.Popen(command, cwd=root, env=environment, pass_fds=[theirs.fileno()])
        theirs.close()
        self._socket = ours

    def run(
        self, arguments: list[str], folder: Path, environment: dict[str, str], cores: set[int] | None, timeout_s: float
    ) -> subprocess.CompletedProcess[str]:
        """Do what ``python -m experiments.bench.cli ARGUMENTS`` does, and wait for its end."""
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
            self.start(arguments, folder, environment, cores, (out.fileno(), err.fileno()))
            status = self.wait(timeout_s)
            if status is None:
                raise subprocess.TimeoutExpired(arguments, timeout_s)
            texts = []
            for file in (out, err):
                file.seek(0)
                texts.append(file.read().decode(errors="replace"))
        return subprocess.CompletedProcess(arguments, status, *texts)

    def start(
        self, arguments: list[str], folder: Path, environment: dict[str, str], cores: set[int] | None,
        streams: tuple[int, int], *, session: bool = False,
    ) -> int:  # fmt: skip
        """Start it with these files as its output, in a ``session`` of its own if asked for; return its process id."""
        request = {
            "arguments": arguments,
            "folder": str(folder),
            "environment": environment,
            "cores": sorted(cores or ()),
            "session": session,
        }
        message = json.dumps(request).encode()
        socket.send_fds(self._socket, [len(message).to_bytes(4, "big")], list(streams))
        self._socket.sendall(message)
        self._pid = int(self._line(time.monotonic() + 60))
        return self._pid

    def wait(self, timeout_s: float) -> int | None:
        """Wait for the end of what was started; return its exit status, None where it had to be killed."""
        try:
            return int(self._line(time.monotonic() + timeout_s))
        except TimeoutError:
            with contextlib.suppress(ProcessLookupError):
                os.kill(self._pid, signal.SIGKILL)
            self._line(time.monotonic() + 10)
            return None

    def _line(self, until: float) -> str:
        line = b""
        while not line.endswith(b"\n"):
            self._socket.settimeout(max(until - time.monotonic(), 0.001))
            byte = self._socket.recv(1)
            if not byte:
                raise RuntimeError("the server of warm processes has ended")
            line += byte
        return line.decode().strip()

    def close(self) -> None:
        """End the server."""
        self._socket.close()
        self._server.wait(30)


def serve(connection: socket.socket) -> None:
    """Start a copy of this process for each command that is asked for, until the other end closes."""
    import gc
    import importlib

    environment = dict(os.environ)
    os.environ["MUJOCO_GL"] = "disabled"  # a process forked with an OpenGL display may hang
    for name in (*LIBRARIES, *OURS):
        importlib.import_module(name)
    # What is there by now is looked at by no collection of a copy. The one at its end would write into each object,
    # and so copy all of the memory that the copies share: 0.3 s each.
    gc.collect()
    gc.freeze()
    while True:
        head, streams, _, _ = socket.recv_fds(connection, 4, 2)
        if len(head) < 4:
            return
        length, message = int.from_bytes(head, "big"), b""
        while len(message) < length:
            message += connection.recv(length - len(message))
        child = os.fork()
        if child == 0:
            _become(json.loads(message), streams, connection, environment)
        for stream in streams:
            os.close(stream)
        connection.sendall(f"{child}\n".encode())
        _, ended = os.waitpid(child, 0)
        connection.sendall(f"{os.waitstatus_to_exitcode(ended)}\n".encode())


def _become(asked: dict, streams: list[int], connection: socket.socket, environment: dict[str, str]) -> None:
    """In the copy: take on the command's folder, environment, cores and streams, do it, and end."""
    connection.close()
    nothing = os.open(os.devnull, os.O_RDONLY)
    for number, stream in enumerate((nothing, *streams)):
        os.dup2(stream, number)
    for stream in (nothing, *streams):
        os.close(stream)
    if asked["session"]:
        os.setsid()
        signal.signal(signal.SIGINT, signal.default_int_handler)  # the tests themselves may have it ignored
    tempfile.tempdir = None  # of the environment that follows
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    sys.modules["colias_sim.gl"].choose_backend()  # `serve` had chosen none
    if asked["cores"] and hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, asked["cores"])
    if _relevant(asked["environment"]) != _relevant(environment):
        _forget_ours()
    # As Python has them for `python -m MODULE`: the folder first, then what the environment names.
    first = ["", *filter(None, asked["environment"].get("PYTHONPATH", "").split(os.pathsep))]
    sys.path[:] = [*first, *(path for path in sys.path[1:] if path not in first)]
    sys.argv = [MODULE, *asked["arguments"]]
    import runpy

    status = 1
    try:
        runpy.run_module(MODULE, run_name="__main__", alter_sys=True)
        status = 0
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        import traceback

        traceback.print_exc()
    # As the interpreter ends a process: threads joined, functions of atexit run, streams written out.
    raise _End(status)


def _relevant(environment: dict[str, str]) -> dict[str, str]:
    """Return the variables by which this project may be imported otherwise; the tests' commands never see a screen."""
    return {name: value for name, value in environment.items() if name not in OTHERWISE and "DISPLAY" not in name}


def _forget_ours() -> None:
    """Let this project be imported anew, and register its envs anew."""
    from gymnasium.envs.registration import registry

    for name in [name for name in sys.modules if name.split(".")[0] in PACKAGES]:
        del sys.modules[name]
    for name in [name for name, spec in registry.items() if str(spec.entry_point).startswith("colias_sim")]:
        del registry[name]


class _End(SystemExit):
    """The end of a copy: it leaves `serve` through the interpreter's own exit."""


if __name__ == "__main__":
    serve(socket.socket(fileno=int(sys.argv[1])))
