"""Make docs/hero.webp, the first picture of README and site: ``python -m tools.picture RUN_FOLDER``.

``make hero`` makes the run, and then this.
"""

from __future__ import annotations

import struct
import sys
import tempfile
from pathlib import Path

from experiments.bench.store.files import drawn_from
from experiments.bench.video.make import Film, make
from experiments.bench.video.reading import read
from experiments.bench.video.source import recording

HERO = Path(__file__).parents[1] / "docs" / "hero.webp"
TRIAL, CAPTION = 2, "A robot watches another pass"
WIDTH, HEIGHT, RATE, SPEED = 960, 540, 10.0, 0.4
XMP = 0x04
"""The flag of a file of WebP that says that it has XMP."""


def noted(webp: bytes, source: str) -> bytes:
    """Return a file of WebP with a note of its source, which its other chunks leave as they are.

    Parameters
    ----------
    webp
        The file, of the extended form that moving pictures have.
    source
        The note.

    Raises
    ------
    ValueError
        The file has another form.
    """
    if webp[:4] != b"RIFF" or webp[12:16] != b"VP8X":
        raise ValueError("no moving picture of WebP")
    note = f'<x:xmpmeta xmlns:x="adobe:ns:meta/"><Source>{source}</Source></x:xmpmeta>'.encode()
    chunk = b"XMP " + struct.pack("<I", len(note)) + note + b"\0" * (len(note) % 2)
    body = webp[8:20] + bytes([webp[20] | XMP]) + webp[21:] + chunk
    return webp[:4] + struct.pack("<I", len(body)) + body


def main(run: Path) -> None:
    """Make the picture of a trial of a run of the speed tests. It notes the rows of that run, and its commit."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / HERO.name
        make(read(recording(run, TRIAL)), Film(out, WIDTH, HEIGHT, CAPTION, RATE, SPEED))
        HERO.write_bytes(noted(out.read_bytes(), drawn_from(run)))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
