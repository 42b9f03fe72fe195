"""The Colias's motors with 8-bit powers, and its motor board, which queues commands in time slots.

Both are off in the default robot; parameters of `colias_sim.config.RobotConfig` switch them on.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from colias_sim.config import RobotConfig

TOP_POWER = 255
"""The largest power: 8 bits. The direction of a wheel is a bit of its own."""

_SAME = 1e-6
"""Share of a slot within which two times count as equal, because the simulation's clock is a sum of steps."""


class Motors:
    """Two motors driven by powers: whole numbers from 0 to 255, each with a direction.

    A motor turns at ``power_step_cm_s`` times its power, and not at all below ``dead_band``. The left motor turns like
    the right one at ``motor_inequality`` more powers. To drive straight, ``trim`` powers are subtracted from the left
    wheel.

    Parameters
    ----------
    config
        The robot's settings, with a ``power_step_cm_s`` above 0.

    References
    ----------
    Public firmware of the Colias (ColiasSenseV4): straight ahead is 77 left and 80 right, slowly ahead 27 and 30. So
    the trim is the same at both speeds, which is why the inequality is counted in powers.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self._step = config.power_step_cm_s / 100
        self._inequality = config.motor_inequality

    def draw(self, rng: np.random.Generator) -> None:
        """Draw the inequality of the motors, if it has a spread."""
        if self._config.motor_inequality_sd:
            spread = self._config.motor_inequality_sd * float(rng.standard_normal())
            self._inequality = self._config.motor_inequality + spread

    def powers(self, left: float, right: float) -> tuple[int, int]:
        """Find the powers for given speeds: the nearest steps, then the trim.

        Parameters
        ----------
        left, right
            The wanted speeds in m/s, forward positive.

        Returns
        -------
        tuple of int
            Powers of the left and the right wheel, from -255 to 255, forward positive.
        """
        return self._power(left, self._config.trim), self._power(right, 0)

    def speeds(self, left: int, right: int) -> tuple[float, float]:
        """Compute the wheel speeds in m/s of powers from `powers`."""
        return self._speed(left, self._inequality), self._speed(right, 0.0)

    def _power(self, wanted: float, trim: int) -> int:
        level = min(round(abs(wanted) / self._step), TOP_POWER)
        trimmed = min(max(level - trim, 0), TOP_POWER) if level else 0
        return trimmed if wanted > 0 else -trimmed

    def _speed(self, power: int, more: float) -> float:
        if not power or abs(power) < self._config.dead_band:
            return 0.0
        return math.copysign(max(abs(power) + more, 0.0) * self._step, power)


class MotorBoard:
    """The robot's motor board, which queues commands and starts each at the beginning of a time slot.

    Slots begin at whole multiples of ``slot``. A command can start with a slot if it arrived before the slot begins, so
    it waits for up to one slot. Commands start in the order of arrival. A command with a duration lasts that many
    slots; if no other waits at its end, the wheels stop. A command without a duration lasts until another starts.

    Parameters
    ----------
    slot
        Length of a slot, in seconds.
    serial
        Time that a command takes on the serial line, in seconds.
    """

    def __init__(self, slot: float, serial: float = 0.0) -> None:
        self._slot, self._serial = slot, serial
        self._waiting: deque[tuple[float, tuple[float, float], int | None]] = deque()
        self.clear()

    def clear(self) -> None:
        """Discard every command and stop the wheels."""
        self._waiting.clear()
        self._running = 0.0, 0.0
        self._ends: int | None = None  # the slot in which the running command is over
        self._begun = -1  # the slot that began last
        self._line_free = 0.0

    def begins(self, now: float) -> float:
        """Find the time in seconds at which a command sent at ``now`` starts, if no other waits."""
        return (self._index(max(now, self._line_free) + self._serial) + 1) * self._slot

    def put(self, speeds: tuple[float, float], now: float, slots: int | None = None, *, preempt: bool = False) -> None:
        """Send a command.

        Parameters
        ----------
        speeds
            Speeds of the left and the right wheel, in m/s.
        now
            The time, in seconds.
        slots
            Number of slots that it lasts; ``None``: until another starts.
        preempt
            Whether it replaces all waiting commands, and ends the running one with its present slot.
        """
        self.at(now)
        if preempt:
            self._waiting.clear()
            self._ends = None
            self._line_free = now
        arrival = max(now, self._line_free) + self._serial
        self._line_free = arrival
        self._waiting.append((arrival, speeds, slots))

    def at(self, now: float) -> tuple[float, float]:
        """Start the slots up to ``now`` (seconds), and return the running command's speeds, in m/s."""
        last = self._index(now)
        for index in range(self._begun + 1, last + 1):
            self._begin(index)
        self._begun = max(self._begun, last)
        return self._running

    def _begin(self, index: int) -> None:
        if self._ends is not None and index < self._ends:
            return
        if self._waiting and self._waiting[0][0] < (index - _SAME) * self._slot:
            _, self._running, slots = self._waiting.popleft()
            self._ends = None if slots is None else index + slots
        elif self._ends is not None:
            self._running, self._ends = (0.0, 0.0), None

    def _index(self, time: float) -> int:
        """Return the slot of a time."""
        return math.floor(time / self._slot + _SAME)
