"""Origins of a reproduction's frames: the renderers and reference frames that its parts note."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from colias_sim.gl import is_software
from colias_sim.reference import KNOWN
from experiments.bench.store.description import NAME, PIXELS, RENDERERS
from experiments.bench.studies.stored import read

SHOWN_DIGITS = 12
"""Digits of a reference frame's hash that are shown."""


@dataclass(frozen=True, slots=True)
class Renderer:
    """A renderer: its name in OpenGL's words, and whether it draws in software."""

    name: str
    software: bool


@dataclass(frozen=True, slots=True)
class ReferenceFrame:
    """A reference frame: its hash, shortened, and where this hash was seen before; empty: it is not known."""

    hash: str
    known: str


@dataclass(frozen=True, slots=True)
class Drawn:
    """Parts of a reproduction that were drawn alike, and the origin of their frames.

    Parameters
    ----------
    parts
        Their folders, inside the reproduction's.
    renderers, frames
        Those of their frames. Several: the parts were continued where something else draws.
    """

    parts: tuple[str, ...]
    renderers: tuple[Renderer, ...]
    frames: tuple[ReferenceFrame, ...]


@dataclass(frozen=True, slots=True)
class Drawing:
    """The origins of all frames of a reproduction.

    Parameters
    ----------
    groups
        Parts that were drawn alike stand together. Empty: no part notes an origin.
    differs
        In one line what differs between its frames' origins; empty where one renderer drew all.
    """

    groups: tuple[Drawn, ...]
    differs: str


def drawing(folder: Path) -> Drawing:
    """Return the origins of a reproduction's frames.

    Parameters
    ----------
    folder
        Of the reproduction. Its parts are the runs in folders of it, and in folders of these; those that drew nothing
        are left out.
    """
    alike: dict[tuple[tuple[str, ...], tuple[str, ...]], list[str]] = {}
    for path in sorted((*folder.glob(f"*/{NAME}"), *folder.glob(f"*/*/{NAME}"))):
        description = read(path.parent, path.stem)
        renderers, frames = (tuple(description.get(entry, ())) for entry in (RENDERERS, PIXELS))
        if renderers or frames:
            alike.setdefault((renderers, frames), []).append(path.parent.relative_to(folder).as_posix())
    groups = tuple(
        Drawn(
            tuple(parts),
            tuple(Renderer(name, is_software(name)) for name in renderers),
            tuple(ReferenceFrame(hash_[:SHOWN_DIGITS], KNOWN.get(hash_, "")) for hash_ in frames),
        )
        for (renderers, frames), parts in alike.items()
    )
    return Drawing(groups, _differs(groups))


def _differs(groups: tuple[Drawn, ...]) -> str:
    frames = {frame for group in groups for frame in group.frames}
    renderers = {renderer for group in groups for renderer in group.renderers}
    if len(frames) > 1:
        return (
            f"The frames were drawn with pixels that differ: {len(frames)} reference frames. Equal trials may have"
            " other numbers in another part."
        )
    if len(renderers) > 1:
        return f"The frames were drawn by {len(renderers)} renderers, with equal pixels in the reference frame."
    return ""
