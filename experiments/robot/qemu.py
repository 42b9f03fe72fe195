"""The programs that build for the chip and emulate it: a cross compiler, and QEMU that runs what it has built."""

from __future__ import annotations

import struct
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from experiments.base.errors import UsageError

GCC, SIZE, QEMU = "arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm"
# Freestanding: there is no C library. Even so memcpy of a few bytes is an instruction, by the compiler's own knowledge
# of it (-fbuiltin); what is longer calls memory.c.
COMPILER = (
    GCC, "-O3", "-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffreestanding", "-fbuiltin", "-fno-common",
    "-ffunction-sections", "-fdata-sections", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables", "-nostdlib",
    "-Wl,--gc-sections", "-mthumb", "-mfloat-abi=soft", "-mcpu=cortex-m4", "-fno-tree-loop-distribute-patterns",
    "-nostartfiles",
)  # fmt: skip
"""Command of the C compiler for the chip."""

SHIFT = 8
"""``-icount shift=``: an instruction lasts 2^8 ns of the board's time. It changes no count, only how finely the board's
25 MHz timer tells them: at 0 in steps of 40 instructions, at 8 one by one, 6.4 ticks each."""
TICKS_AN_INSTRUCTION = 2**SHIFT / 40.0
_HELLO, _FRAME, _RESET, _STACK = (struct.pack("<I", word) for word in (1, 2, 3, 4))
Q15 = 32768.0
"""A potential of 1 in the chip's answers."""
STAGES = 12
KNOWN, KNOWN_ERROR = 4097, 4
"""Instructions of the test program's known loop, with the one that loads its number, and how far a count may be off."""


class Emulator:
    """The test program in QEMU. It ends with ``close``, or when this process ends, as its input ends then.

    Parameters
    ----------
    elf
        The linked program.

    Raises
    ------
    UsageError
        This QEMU does not count instructions one by one.
    """

    def __init__(self, elf: Path) -> None:
        command = [
            QEMU, "-M", "mps2-an386", "-nodefaults", "-display", "none", "-serial", "none", "-monitor", "none",
            "-icount", f"shift={SHIFT},sleep=off", "-semihosting-config", "enable=on,target=native",
            "-kernel", str(elf),
        ]  # fmt: skip
        pipe = subprocess.PIPE
        self._process: Any = subprocess.Popen(command, stdin=pipe, stdout=pipe, stderr=pipe)
        *_, self._cost, known = self._ask(_HELLO, "<7I")
        counted = (known - self._cost) / TICKS_AN_INSTRUCTION
        if abs(counted - KNOWN) > KNOWN_ERROR:
            self.close()
            raise UsageError(f"this {QEMU} counts {counted:.0f} instructions of {KNOWN}: no count can be had of it")

    def step(self, frame: npt.NDArray[np.uint8]) -> tuple[list[int], npt.NDArray[np.float64]]:
        """Show the next frame, (R, C).

        Returns
        -------
        list of int
            hs and vs in Q15, and their spikes.
        ndarray
            Instructions of each stage, (STAGES,), the cost of counting taken off; 0 where a stage did not run.
        """
        numbers = self._ask(_FRAME + frame.tobytes(), f"<4i{2 * STAGES}I")
        ticks, calls = np.array(numbers[4:], np.float64).reshape(2, STAGES)
        return list(numbers[:4]), np.maximum((ticks - self._cost * calls) / TICKS_AN_INSTRUCTION, 0.0)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._ask(_RESET, "<I")

    def stack_bytes(self) -> int:
        """Return the bytes of the stack used so far: its high-water mark, by a painted pattern."""
        return self._ask(_STACK, "<I")[0]

    def close(self) -> None:
        """End the program and its process."""
        self._process.kill()
        self._process.communicate()

    def _ask(self, message: bytes, form: str) -> tuple[int, ...]:
        self._process.stdin.write(message)
        self._process.stdin.flush()
        answer = self._process.stdout.read(struct.calcsize(form))
        if len(answer) < struct.calcsize(form):
            raise RuntimeError(f"{QEMU} has ended: {self._process.stderr.read().decode(errors='replace')}")
        return struct.unpack(form, answer)
