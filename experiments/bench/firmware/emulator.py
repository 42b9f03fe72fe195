"""The chip's program in QEMU: frames go in, answers and instruction counts come out, one process a program."""

from __future__ import annotations

import contextlib
import os
import select
import struct
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import numpy as np
import numpy.typing as npt

from experiments.bench.firmware.toolchain import QemuProgram
from experiments.bench.run.errors import UsageError, printable

BOARD = "mps2-an386"
SHIFT = 8
"""``-icount shift=``: an instruction lasts 2^8 ns of the board's time. It changes no count, only how finely the board's
25 MHz timer tells them: at 0 in steps of 40 instructions, at 8 one by one, 6.4 ticks each."""
TICKS_AN_INSTRUCTION = 2**SHIFT / 40.0
ANSWER_TIMEOUT_S = 120.0

_HELLO, _FRAME, _RESET, _STACK, _END = (struct.pack("<I", word) for word in (1, 2, 3, 4, 0))
_MAGIC = 0x444F4231
Q15 = 32768.0
"""A potential of 1 in the chip's answers."""
STAGES = 12
INPUT = STAGES - 1
"""The place of the stage that takes luma out of the camera's frame."""
KNOWN, KNOWN_ERROR = 4097, 4
"""Instructions of the test program's known loop, with the one that loads its number, and how far a count may be off."""


@dataclass(frozen=True, slots=True)
class ChipAnswer:
    """The answer to one frame.

    Parameters
    ----------
    hs, vs
        Potentials, Q15.
    hs_spikes, vs_spikes
        Counts with the potential's sign.
    instructions
        Of each stage, (STAGES,) float64, the cost of counting taken off; 0 where a stage did not run.
    """

    hs: int
    vs: int
    hs_spikes: int
    vs_spikes: int
    instructions: npt.NDArray[np.float64]

    @property
    def values(self) -> tuple[int, int, int, int]:
        """hs, vs and their spikes."""
        return self.hs, self.vs, self.hs_spikes, self.vs_spikes


class EmulatorError(RuntimeError):
    """The emulated chip gave no answer: why, in one line."""


class Emulator:
    """A running program. It ends with ``close``, or when this process ends, as its input ends then.

    Parameters
    ----------
    program
        QEMU.
    elf
        The linked program.
    shape
        (R, C) that the program should be built for.

    Raises
    ------
    EmulatorError
        It does not start, or is of another shape.
    UsageError
        This QEMU does not count instructions one by one.
    """

    def __init__(self, program: QemuProgram, elf: Path, shape: tuple[int, int]) -> None:
        command = [
            program.path, "-M", BOARD, "-nodefaults", "-display", "none", "-serial", "none", "-monitor", "none",
            "-icount", f"shift={SHIFT},sleep=off", "-semihosting-config", "enable=on,target=native",
            "-kernel", str(elf),
        ]  # fmt: skip
        self._said = tempfile.TemporaryFile()  # noqa: SIM115  (open as long as the process)
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._said)
        self.shape = shape
        try:
            magic, rows, columns, stages, _, self._cost, known = self._ask(_HELLO, "<7I")
            if magic != _MAGIC or stages != STAGES:
                raise EmulatorError(f"{elf.name} is not the test program of this version")
            if (rows, columns) != shape:
                raise EmulatorError(f"{elf.name} is built for {columns}x{rows} px, not {shape[1]}x{shape[0]}")
            counted = (known - self._cost) / TICKS_AN_INSTRUCTION
            if abs(counted - KNOWN) > KNOWN_ERROR:
                raise UsageError(
                    f"{program.version} counts {counted:.0f} instructions of {KNOWN}: no count can be had of it"
                )
        except BaseException:
            self.close()
            raise

    def step(self, frame: npt.NDArray[np.uint8]) -> ChipAnswer:
        """Show the next frame, (R, C) uint8."""
        if frame.shape != self.shape or frame.dtype != np.uint8:
            raise EmulatorError(f"a frame of shape {frame.shape} and type {frame.dtype}: legal is {self.shape}, uint8")
        numbers = self._ask(_FRAME + frame.tobytes(), f"<4i{2 * STAGES}I")
        ticks, calls = np.array(numbers[4 : 4 + STAGES], np.float64), np.array(numbers[4 + STAGES :], np.float64)
        hs, vs, hs_spikes, vs_spikes = numbers[:4]
        counted = np.maximum((ticks - self._cost * calls) / TICKS_AN_INSTRUCTION, 0.0)
        return ChipAnswer(hs, vs, hs_spikes, vs_spikes, counted)

    def reset(self) -> None:
        """Return to the state before the first frame."""
        self._ask(_RESET, "<I")

    def stack_bytes(self) -> int:
        """Return the bytes of the stack used so far: its high-water mark, by a painted pattern."""
        return int(self._ask(_STACK, "<I")[0])

    def close(self) -> None:
        """End the program and its process."""
        with contextlib.suppress(OSError):
            if self._process.stdin is not None:
                self._process.stdin.write(_END)
                self._process.stdin.close()
        try:
            self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._said.close()

    def __enter__(self) -> Emulator:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def _ask(self, message: bytes, form: str) -> tuple[int, ...]:
        stdin, stdout = self._process.stdin, self._process.stdout
        assert stdin is not None and stdout is not None
        try:
            stdin.write(message)
            stdin.flush()
        except OSError:
            raise self._ended() from None
        left, parts = struct.calcsize(form), []
        deadline = time.monotonic() + ANSWER_TIMEOUT_S
        while left:
            ready, _, _ = select.select([stdout], [], [], max(deadline - time.monotonic(), 0.0))
            if not ready:
                raise EmulatorError(f"the emulated chip gave no answer within {ANSWER_TIMEOUT_S:g} s")
            part = os.read(stdout.fileno(), left)
            if not part:
                raise self._ended()
            parts.append(part)
            left -= len(part)
        return struct.unpack(form, b"".join(parts))

    def _ended(self) -> EmulatorError:
        """Tell why there is no process to talk to any more."""
        try:
            status = self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            return EmulatorError("the emulated chip closed its output")
        self._said.seek(0)
        message = printable(self._said.read().decode(errors="replace"))
        reason = {70: "the program came to a processor fault", 71: "the program could not answer"}.get(status, "")
        return EmulatorError(f"QEMU ended with status {status}{': ' if reason or message else ''}{reason or message}")
