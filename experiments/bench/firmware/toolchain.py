"""The programs that build for the chip and emulate it. Nothing is measured where they are missing."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
from dataclasses import dataclass

from experiments.bench.run.errors import UsageError

GCC, QEMU = "arm-none-eabi-gcc", "qemu-system-arm"
BY_NAME = ("gcc", "zig")

# Freestanding: there is no C library. Even so memcpy of a few bytes is an instruction, by the compiler's own knowledge
# of it (-fbuiltin); what is longer calls memory.c.
_CPU = ("-mthumb", "-mfloat-abi=soft", "-mcpu=cortex-m4")
_COMMON = (
    "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffreestanding", "-fbuiltin", "-fno-common",
    "-ffunction-sections", "-fdata-sections", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Compiler:
    """A C compiler for Cortex-M4.

    Parameters
    ----------
    command
        How it is called.
    flags
        Of compiling, the optimisation aside.
    linking
        Of linking: neither start-up code nor a C library.
    libraries
        After the sources: the compiler's own arithmetic.
    version
        As it says itself.
    """

    command: tuple[str, ...]
    flags: tuple[str, ...]
    linking: tuple[str, ...]
    libraries: tuple[str, ...]
    version: str


def _gcc(path: str) -> Compiler:
    flags = (*_CPU, *_COMMON, "-fno-tree-loop-distribute-patterns")
    linking = ("-nostdlib", "-nostartfiles", "-Wl,--gc-sections")
    return Compiler((path,), flags, linking, ("-lgcc",), _first_line((path, "--version")))


def _zig() -> Compiler:
    command = (sys.executable, "-P", "-m", "ziglang", "cc")
    flags = ("-target", "thumb-freestanding-eabi", "-mcpu=cortex_m4", "-munaligned-access", *_COMMON, "-g0")
    linking = ("-nostdlib", "-Wl,--gc-sections", "-Wl,--entry=chip_reset")
    version = f"zig cc {_first_line((*command[:-1], 'version'))}"
    return Compiler(command, flags, linking, (), version)


def _first_line(command: tuple[str, ...]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    return (done.stdout or done.stderr).splitlines()[0].strip() if done.stdout or done.stderr else "unknown version"


def compiler(wanted: str | None = None) -> Compiler:
    """Find the cross compiler: GCC's where it is on the PATH, otherwise the ``ziglang`` wheel; ``wanted`` takes one.

    Raises
    ------
    UsageError
        There is none; it names the packages.
    """
    if wanted not in (None, *BY_NAME):
        raise UsageError(f"--compiler {wanted}: legal is {', '.join(BY_NAME)}")
    path = shutil.which(GCC)
    if path and wanted in (None, "gcc"):
        return _gcc(path)
    if wanted in (None, "zig") and importlib.util.find_spec("ziglang") is not None:
        return _zig()
    packages = {"gcc": "Debian's gcc-arm-none-eabi", "zig": "the wheel ziglang (pip install ziglang)"}
    named = packages.values() if wanted is None else [packages[wanted]]
    raise UsageError(f"no C compiler for the chip: install {' or '.join(named)}; nothing was measured")


@dataclass(frozen=True, slots=True)
class QemuProgram:
    """The emulator: where it is, and its version as it says itself."""

    path: str
    version: str


def qemu() -> QemuProgram:
    """Return the emulator; `UsageError` with the package's name where it is missing."""
    path = shutil.which(QEMU)
    if path is None:
        raise UsageError(f"no {QEMU} on the PATH: install Debian's qemu-system-arm; nothing was measured")
    return QemuProgram(path, _first_line((path, "--version")))
