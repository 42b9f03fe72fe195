"""Tests of the documentation as built: make docs."""

from pathlib import Path

SITE = Path(__file__).parents[2] / "build" / "site"
