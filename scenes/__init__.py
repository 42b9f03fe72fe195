"""MuJoCo files of robots and arenas, with their generated textures. A new arena is one file and one line here."""

from __future__ import annotations

from pathlib import Path

from scenes.hints import nearest

FOLDER = Path(__file__).parent
"""The folder of the files."""

ARENA_RADIUS_CM, WALL_HEIGHT_CM = 45.0, 40.0
WALL_PANELS = 24  # flat panels around

ARENAS = {
    "bright": "bright, matt, visually cluttered walls: the default",
    "plain": "as bright, without clutter",
    "dim": "the cluttered arena at about half the light",
    "leaves": "a wall of dark and light discs of every size: it can be seen to come near",
    "drum": "dark and light stripes of 15 degrees each, to be turned: for the optomotor response",
}
"""The arenas: name -> description."""

ROBOTS = {
    "colias": FOLDER / "colias.xml",
    "colias_black": FOLDER / "colias_black.xml",
    "colias_parked": FOLDER / "colias_parked.xml",
}
"""The variants of robots: name -> MJCF file. A parked robot is fixed to the floor."""


ARENA_ENDINGS = (".xml", ".py")
"""Endings of your own arena: an MJCF file, or a Python file that declares ``ARENA``."""


def is_arena_file(name: str) -> bool:
    """Whether an arena's name is the path of a file instead of one of `ARENAS`."""
    return name.endswith(ARENA_ENDINGS) or "/" in name


def arena_name(name: str) -> str:
    """Return an arena's short name: for a path, the file's name without folder and ending."""
    return Path(name).stem if is_arena_file(name) else name


def arena_path(name: str) -> Path:
    """Find the file of an arena.

    Parameters
    ----------
    name
        Its name in `ARENAS`, or the path of your own file (`ARENA_ENDINGS`).

    Returns
    -------
    Path
        The file; your own file by its absolute path, without links.

    Raises
    ------
    ValueError
        The arena is unknown (the message suggests the most similar name), or the file does not exist.

    Examples
    --------
    >>> from scenes import arena_path
    >>> arena_path("bright").name
    'bright.xml'
    """
    if name in ARENAS:
        return FOLDER / f"{name}.xml"
    if not is_arena_file(name):
        near = nearest(name, ARENAS, " (", ")")
        raise ValueError(f"unknown arena '{name}'{near}: known are {', '.join(ARENAS)}, or an .xml or .py file")
    if not Path(name).is_file():
        raise ValueError(f"arena {name}: there is no such file")
    if not name.endswith(ARENA_ENDINGS):
        raise ValueError(f"arena must be an .xml file (MJCF), or a .py file that declares ARENA, got {name}")
    return Path(name).resolve()
