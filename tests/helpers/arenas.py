"""Arenas of one's own, as files."""

from pathlib import Path


def written(folder: Path, body: str = "", before: str = "", room: str = "bright") -> str:
    """Write an arena with a room that ships in it; return its path as a text."""
    path = folder / "own.xml"
    path.write_text(f'<mujoco>\n<include file="{room}.xml"/>{before}<worldbody>{body}</worldbody></mujoco>')
    return str(path)


def pillar(x: float, y: float, radius: float = 0.01, half: float = 0.04) -> str:
    """Return the MJCF of a pillar, in metres."""
    return f'<geom name="pillar" type="cylinder" size="{radius} {half}" pos="{x} {y} {half}"/>'
