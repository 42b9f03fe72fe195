"""No import needs what Windows lacks."""

import subprocess
import sys

from experiments.bench.run import workers

IMPORTS = """
import builtins, importlib, os, pkgutil, signal, sys
import matplotlib.figure, multiprocessing.managers, pyarrow, rerun, subprocess  # others may use what they like

for module, names in (
    (os, "getuid geteuid setpgid killpg fork register_at_fork memfd_create sched_getaffinity getppid setsid"),
    (signal, "pthread_sigmask SIGKILL SIGHUP"),
):
    for name in names.split():
        delattr(module, name)
real = builtins.__import__

def importing(name, namespace=None, *rest):
    place = (namespace or {}).get("__name__", "")
    ours = place.startswith(("colias_sim", "dsnn", "experiments"))
    if ours and name in ("fcntl", "resource", "termios", "pwd", "grp"):
        raise ImportError(f"{place} imports {name}")
    return real(name, namespace, *rest)

builtins.__import__ = importing
for package in ("colias_sim", "dsnn", "scenes", "experiments"):
    for info in pkgutil.walk_packages(importlib.import_module(package).__path__, f"{package}."):
        if not info.name.endswith(("__main__", "firmware.program")):
            try:
                importlib.import_module(info.name)
            except ModuleNotFoundError as error:  # an extra's
                if error.name.split(".")[0] in ("colias_sim", "dsnn", "scenes", "experiments"):
                    raise
"""


def test_every_module_is_imported_without_what_windows_lacks(tmp_path):
    done = subprocess.run([sys.executable, "-c", IMPORTS], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]


def test_workers_start_without_signal_masks(monkeypatch):
    monkeypatch.delattr(workers.signal, "pthread_sigmask")
    with workers.without_interrupts():
        pass
