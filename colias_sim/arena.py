"""Arenas: MJCF that ships or is a user's own, read with every file that it names. Both have one form.

An arena stands in the round room of 45 cm radius. It has a geom ``floor``, a body ``wall`` with a texture and a
material of that name, and whatever else it likes that stands still: obstacles, pictures, lamps. It includes
``arena_base.xml`` and ``arena_body.xml``, which have what all share, or a whole arena that ships, such as
``bright.xml``.
"""

from __future__ import annotations

import hashlib
import importlib
import locale
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING
from xml.etree import ElementTree

from dsnn.pictures import read_picture
from scenes import ARENAS, FOLDER, arena_path

if TYPE_CHECKING:
    import mujoco

WIRING = "experiments.wiring"
"""The module that runs a user's Python files. `colias_sim` runs none itself, so it imports this one for an arena's."""

FORBIDDEN = {"model": "asset", "plugin": "", "extension": "", "flexcomp": "", "skin": ""}
"""Elements that an arena has no use for, and the element that each is forbidden in, of whatever kind if empty: they
name further files, or move."""

STILL = {
    "joints": "joint", "actuators": "actuator", "tendons": "tendon", "equalities": "equality", "sensors": "sensor",
    "keys": "keyframe", "flexes": "flex", "hfields": "hfield", "pairs": "contact pair",
}  # fmt: skip
"""What an arena has none of: the list of an `mujoco.MjSpec` -> its word in MJCF."""

NEEDED = {"geom": "floor", "body": "wall", "texture": "wall", "material": "wall"}
"""What every arena has: element -> its name."""

PHYSICS = ("gravity", "integrator", "solver", "cone", "disableflags", "enableflags", "density", "viscosity", "wind")
"""Options of the physics, which every arena has as ``arena_base.xml`` sets them."""


@dataclass(frozen=True, slots=True)
class Arena:
    """An arena as it was read: MJCF, and the contents of every file that it names.

    Parameters
    ----------
    source
        Its name in `scenes.ARENAS`, or the path of a file of one's own.
    text
        The MJCF.
    includes, assets
        Contents of the MJCF files that it includes, and of its textures and meshes, by the names that it has for them.
    files
        The files of one's own among all these, with its own first: path -> SHA-256. Empty for an arena that ships.
    """

    source: str
    text: str
    includes: Mapping[str, bytes]
    assets: Mapping[str, bytes]
    files: Mapping[Path, str]

    @classmethod
    def read(cls, source: str) -> Arena:
        """Read an arena, and all that it names. Nothing of it is compiled.

        A file is looked for beside the arena's own, then among those that ship in ``scenes``.

        Parameters
        ----------
        source
            Its name in `scenes.ARENAS`, or the path of a file of one's own. A Python file is executed.

        Returns
        -------
        Arena
            The arena.

        Raises
        ------
        ValueError
            There is no such arena, it is no XML, or it names a file that is not there. In one line that begins with
            the file.
        """
        path = arena_path(source)
        data = _bytes(path)
        reader = _Reader(path, source not in ARENAS)
        reader.note(path, data)
        text = importlib.import_module(WIRING).arena_text(path) if path.suffix == ".py" else _decoded(path, data)
        reader.read(text)
        return cls(source, text, reader.includes, reader.assets, reader.files)

    def spec(self) -> mujoco.MjSpec:
        """Parse the MJCF into a specification, not yet compiled.

        Returns
        -------
        mujoco.MjSpec
            The arena. Hulls bump into each of its geoms that collides with anything, but for the floor, on which
            wheels roll.

        Raises
        ------
        ValueError
            MuJoCo refuses the MJCF, or it lacks what every arena has, or something in it moves. In one line.
        """
        import mujoco

        point = str(locale.localeconv()["decimal_point"]).encode()  # which MuJoCo expects in an OBJ, and nowhere else
        assets = {
            name: data.replace(b".", point) if name.lower().endswith(".obj") else data
            for name, data in self.assets.items()
        }
        try:
            spec = mujoco.MjSpec.from_string(self.text, include=self.includes, assets=assets)
        except ValueError as error:
            raise ValueError(f"arena {self.source}: {one_line(error)}") from None
        self._check(spec)
        for geom in spec.geoms:
            if geom.name != "floor" and (geom.contype or geom.conaffinity):
                geom.contype = geom.conaffinity = HULL
            if geom.group in HIDDEN:
                geom.group = 0
        return spec

    def _check(self, spec: mujoco.MjSpec) -> None:
        """Raise ``ValueError`` for an arena that lacks what every one has, or in which something moves."""
        for kind, name in NEEDED.items():
            if getattr(spec, kind)(name) is None:
                raise ValueError(
                    f'arena {self.source}: has no {kind} called {name}: <include file="bright.xml"/> brings floor, wall'
                    " and lamps"
                )
        for elements, word in STILL.items():
            if there := list(getattr(spec, elements)):
                name = there[0].name
                raise ValueError(
                    f"arena {self.source}: has a {word}{f' {name!r}' if name else ''}: legal is none, as everything in"
                    " an arena stands still"
                )
        if self.files:
            usual = Arena.read("bright").spec().option
            for name in PHYSICS:
                if str(getattr(spec.option, name)) != str(getattr(usual, name)):
                    raise ValueError(
                        f"arena {self.source}: option {name}={getattr(spec.option, name)}: legal is"
                        f" {getattr(usual, name)}, as arena_base.xml has it; include that, and leave <option> out"
                    )


HULL = 2
"""The bit of ``contype`` and ``conaffinity`` by which robots' hulls and obstacles collide."""
HIDDEN = (1, 2)
"""Groups of geoms that become group 0 in an arena: the robot's eye does not render group 1, its own body."""


def one_line(error: Exception) -> str:
    """Write MuJoCo's message in one line."""
    return ", ".join(line.strip() for line in str(error).splitlines() if line.strip())


def _bytes(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror})") from None


def _decoded(path: Path, data: bytes) -> str:
    try:
        return data.decode()
    except UnicodeDecodeError:
        raise ValueError(f"arena {path}: is no text in UTF-8, as MJCF is") from None


class _Reader:
    """Collects the files that an arena names."""

    def __init__(self, path: Path, user_arena: bool) -> None:
        self._path, self._folder, self._own = path, path.parent, user_arena
        self.includes: dict[str, bytes] = {}
        self.assets: dict[str, bytes] = {}
        self.files: dict[Path, str] = {}

    def note(self, path: Path, data: bytes) -> None:
        """Note a file of one's own."""
        if self._own and not path.is_relative_to(FOLDER):
            self.files[path] = hashlib.sha256(data).hexdigest()

    def read(self, text: str) -> None:
        """Read the files that MJCF names, and those that these include."""
        roots = [_parsed(str(self._path), text)]
        for root in roots:  # which grows
            for element in root.iter("include"):
                name = element.get("file", "")
                if name and name not in self.includes:
                    place = self._place("include", name, (Path(),), (FOLDER,))
                    self.includes[name] = self._taken(place)
                    roots.append(_parsed(str(place), self.includes[name]))
        folders = [value for root in roots for value in _folders(root)]
        for root in roots:
            self._check_elements(root)
            for element, name in _files(root):
                beside = (Path(), *map(Path, dict.fromkeys(folders)))
                place = self._place(element.tag, name, beside, (FOLDER / "assets",))
                data = self._taken(place)
                if data.startswith(b"\x89PNG") and data[24] == 16:  # bits, of which MuJoCo takes the upper 8
                    read_picture(place)
                if self.assets.setdefault(name, data) != data or any(
                    name != other and PurePosixPath(name).name == PurePosixPath(other).name for other in self.assets
                ):
                    raise ValueError(f"arena {self._path}: names two files called {PurePosixPath(name).name}")

    def _taken(self, place: Path) -> bytes:
        data = _bytes(place)
        self.note(place, data)
        return data

    def _check_elements(self, root: ElementTree.Element) -> None:
        for parent in root.iter():
            for child in parent:
                if child.tag in FORBIDDEN and FORBIDDEN[child.tag] in ("", parent.tag):
                    raise ValueError(f"arena {self._path}: has an element <{child.tag}>: legal is none in an arena")

    def _place(self, tag: str, name: str, beside: tuple[Path, ...], shipped: tuple[Path, ...]) -> Path:
        """Find a file beside the arena's own, or among those that ship."""
        for folder in beside:
            place = self._folder / folder / name
            if place.is_file() and place != self._path:
                return place.resolve()
        for folder in shipped:
            if (folder / name).is_file():
                return folder / name
        raise ValueError(
            f"arena {self._path}: <{tag}> names {name}: no such file in {self._folder}, nor one that ships"
        )


def _parsed(where: str, text: str | bytes) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        line, _ = error.position
        words = str(error).partition(": line")[0]
        raise ValueError(f"arena {where}, line {line}: no XML that can be read ({words})") from None


def _folders(root: ElementTree.Element) -> Iterator[str]:
    """Yield the folders of files that MJCF sets."""
    for element in root.iter("compiler"):
        yield from (value for name, value in element.attrib.items() if name.endswith("dir") and value)


def _files(root: ElementTree.Element) -> Iterator[tuple[ElementTree.Element, str]]:
    """Yield the files that elements name, but for includes: ``file`` of meshes, six ``file...`` of a cube texture."""
    for element in root.iter():
        if element.tag != "include":
            yield from ((element, value) for name, value in element.attrib.items() if name.startswith("file") and value)
