"""The documentation as built."""

from __future__ import annotations

from pathlib import Path

SITE = Path(__file__).parents[2] / "build" / "site"
