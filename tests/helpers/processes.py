"""Processes as the tests of interrupts, streams and children need them."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

CLI = (sys.executable, "-m", "experiments.cli")


def _mind_signals() -> None:
    """Started by ``nohup`` or in the background, the tests themselves may ignore them, and a child inherits that."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_DFL)


def start(folder: Path, *command: str, **environment: str) -> subprocess.Popen[str]:
    """A command in a session of its own, in which neither Ctrl-C nor the terminal's end is ignored."""
    kept = {k: v for k, v in os.environ.items() if "DISPLAY" not in k}
    return subprocess.Popen(
        command, cwd=folder, env=kept | environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True, preexec_fn=_mind_signals,
    )  # fmt: skip


def wait_until(holds, seconds: float = 300.0) -> bool:
    deadline = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


def members(session: int) -> list[int]:
    """The living processes of a session."""
    pids = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, _, number = stat.read_text().rsplit(")", 1)[1].split()[:4]
        except OSError:
            continue
        if int(number) == session and state != "Z":
            pids.append(int(stat.parent.name))
    return pids
