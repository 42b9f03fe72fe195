"""Disks that are full: small ones that are mounted, and a limit on the size of a file, which is one everywhere."""

from __future__ import annotations

import contextlib
import resource
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

WHOLE_ENDS = b"RRF2FOOT"
"""What the last 12 bytes of a whole .rrd file begin with."""


@contextlib.contextmanager
def file_limit(size: int) -> Iterator[None]:
    """Let no file grow past ``size`` bytes in this process, and in those that it starts."""
    before, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (before, most))


@contextlib.contextmanager
def small_disk(folder: Path, size: int) -> Iterator[Path]:
    """Mount a new disk of ``size`` bytes at ``folder``; skip the test where that is not allowed."""
    folder.mkdir(exist_ok=True)
    command = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        pytest.skip(f"no small disk can be mounted here ({error})")
    if done.returncode:
        pytest.skip(f"no small disk can be mounted here ({done.stderr.strip()})")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)


def whole_recording(path: Path) -> bool:
    """Whether a file begins and ends as a recording does."""
    data = path.read_bytes()
    return data.startswith(b"RRF2") and data[-12:].startswith(WHOLE_ENDS)
