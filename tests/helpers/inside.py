"""The command line in the tests' own process: for what is about words and files, and not about processes."""

import contextlib
import io
import subprocess
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

import pytest

from experiments.cli import entry


def inside(folder: Path, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run ``colias ARGUMENTS`` in ``folder``, in this process, with the outcome of a process of its own."""
    status, out, err = 1, io.StringIO(), io.StringIO()
    try:
        with contextlib.chdir(folder), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(sys, "argv", ["colias", *arguments])
                for name in ("DISPLAY", "WAYLAND_DISPLAY"):
                    patch.delenv(name, raising=False)
                status, line = entry._outcome()
            if line:
                print(line, file=err)
    except Exception:
        traceback.print_exc(file=err)
    return subprocess.CompletedProcess([*arguments], status, out.getvalue(), err.getvalue())
