"""The command line in the tests' own process: for what is about words and files, and not about processes."""

from __future__ import annotations

import contextlib
import io
import signal
import subprocess
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import pytest

from experiments.bench.cli import entry


def inside(folder: Path, arguments: Sequence[str], timeout_s: float = 300.0) -> subprocess.CompletedProcess[str]:
    """Run ``colias ARGUMENTS`` in ``folder``, in this process, with the outcome of a process of its own."""

    def ring(number: int, frame: object) -> None:
        raise TimeoutError

    status, out, err = None, io.StringIO(), io.StringIO()
    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, timeout_s)
    try:
        with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(sys, "argv", ["colias", *arguments])
                for name in ("DISPLAY", "WAYLAND_DISPLAY"):
                    patch.delenv(name, raising=False)
                status, line = entry._outcome()
            if line:
                print(line, file=err)
    except TimeoutError:
        pass
    except Exception:
        status = 1
        traceback.print_exc(file=err)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    return subprocess.CompletedProcess(
        [*arguments], -signal.SIGALRM if status is None else status, out.getvalue(), err.getvalue()
    )
