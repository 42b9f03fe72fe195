"""The answers of docs/questions/, dealt out to the files of tests that run them: xdist gives a file to one worker."""

from __future__ import annotations

import pytest

from tests.helpers.chapters import DOCS, QUESTIONS, called

INDEX = DOCS / "questions" / "index.md"
ANSWERS = tuple(page for page in QUESTIONS if page != INDEX)
PARTS = 3

_EXTRAS = {
    "questions/pictures.md": ("imageio_ffmpeg",),
    "questions/record-env.md": ("imageio_ffmpeg", "moviepy"),
}
"""Page -> modules of the extra [video] that it needs."""


def part(number: int) -> list[str]:
    """The names of every `PARTS`-th answer, from the one at ``number`` on."""
    return [called(page) for page in ANSWERS][number::PARTS]


def skip_without_extras(name: str) -> None:
    """Skip a test where what the page called ``name`` needs is not installed."""
    for module in _EXTRAS.get(name, ()):
        pytest.importorskip(module)
