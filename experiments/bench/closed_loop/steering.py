"""Steering by a trained policy: its answers add to a command that leaks. Plain NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from pydantic import ConfigDict, Field
from pydantic.dataclasses import dataclass

Vector = npt.NDArray[np.float32]

WHEELS = 2


@dataclass(frozen=True, config=ConfigDict(extra="forbid", allow_inf_nan=False, use_attribute_docstrings=True))
class Steering:
    """Rule by which a network's two answers in [-1, 1] move the wheels: not at once, full speed being 1250 degrees/s of
    turn.

    Each frame a wheel keeps a share of its command and adds to it, within a limit; shares of the maximum.
    """

    keep: float = Field(default=0.9, ge=0.0, le=1.0)
    """Share of the last command that stays."""
    reach: float = Field(default=0.04, gt=0.0, le=1.0)
    """Change of a command by an answer of 1."""
    limit: float = Field(default=0.3, gt=0.0, le=1.0)
    """The greatest command."""

    def sense(self, observation: Vector, command: Vector) -> Vector:
        """Return what the network sees, (9,), of an observation (7,) and the last command (2,)."""
        return np.concatenate([observation, command / np.float32(self.limit)]).astype(np.float32)

    def command(self, last: Vector, answer: Vector) -> Vector:
        """Return the next command, (2,), after the ``last`` one and the network's answer to it."""
        wanted = self.keep * last + self.reach * np.clip(answer, -1.0, 1.0)
        return np.clip(wanted, -self.limit, self.limit).astype(np.float32)
