"""Findings of a check."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Status = Literal["ok", "optional", "notice", "fails"]


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the doctor's answer.

    Parameters
    ----------
    name
        What was looked at.
    status
        ``ok``; ``optional`` for what is not installed and only some commands need; ``notice`` for what a person should
        know but everything runs with; ``fails`` for what is needed and missing.
    message
        What was found.
    remedy
        What to do about it; empty where there is nothing to do.
    """

    name: str
    status: Status
    message: str
    remedy: str = ""

    def __post_init__(self) -> None:
        if self.status == "fails" and not self.remedy:
            raise ValueError(f"Finding {self.name}: one that fails needs a remedy")
