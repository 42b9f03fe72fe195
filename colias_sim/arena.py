"""Read arenas: built-in MJCF or your own, with every file that it names.

An arena is a round room of 45 cm radius. It has a geom ``floor``, and a body ``wall`` with a texture and a material of
that name. It may have anything else that stands still: obstacles, pictures, lamps. It includes the common files
``arena_base.xml`` and ``arena_body.xml``, or a whole built-in arena such as ``bright.xml``.
"""

from __future__ import annotations

import hashlib
import importlib
import locale
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from dsnn.pictures import read_picture
from scenes import ARENAS, FOLDER, arena_path

if TYPE_CHECKING:
    import mujoco

WIRING = "experiments.wiring"
"""The module that runs a user's Python files. `colias_sim` runs none itself, so it imports this one for arenas."""

MOVING = ("joints", "actuators", "tendons", "equalities", "sensors", "keys", "flexes", "hfields", "pairs")
"""Lists of a `mujoco.MjSpec` that must be empty in an arena, as everything in it stands still."""
NEEDED = {"geom": "floor", "body": "wall", "texture": "wall", "material": "wall"}
"""Required elements of an arena: element -> its name."""
PHYSICS = ("gravity", "integrator", "solver", "cone", "disableflags", "enableflags", "density", "viscosity", "wind")
"""Options of the physics, which must equal the ones of ``arena_base.xml``."""
HULL = 2
"""The bit of ``contype`` and ``conaffinity`` by which robots' hulls and obstacles collide."""


def arena_files(source: str) -> dict[Path, str]:
    """List a user's own files that an arena consists of, without compiling it.

    Parameters
    ----------
    source
        Its name in `scenes.ARENAS`, or the path of your own file. A Python file is executed.

    Returns
    -------
    dict of Path to str
        Path -> SHA-256, with the arena's first. Empty for a built-in arena.

    Raises
    ------
    ValueError
        The arena is unknown, is not XML, or names a file that does not exist.
    """
    if source in ARENAS:
        return {}
    _, found = _read(source)
    return {place: hashlib.sha256(data).hexdigest() for place, data in found.items() if FOLDER not in place.parents}


def arena_spec(source: str) -> mujoco.MjSpec:
    """Read an arena and parse it into a specification, not yet compiled.

    Parameters
    ----------
    source
        Its name in `scenes.ARENAS`, or the path of your own file. A Python file is executed.

    Returns
    -------
    mujoco.MjSpec
        The arena. Robots' hulls collide with each of its geoms that collides with anything, except the floor.

    Raises
    ------
    ValueError
        The arena is unknown or names a file that does not exist, MuJoCo refuses the MJCF, a required element is
        missing, or something in it moves. The message is one line.
    """
    import mujoco

    mjcf, _ = _read(source)
    point = str(locale.localeconv()["decimal_point"]).encode()  # which MuJoCo expects in an OBJ, and nowhere else
    for name, data in mjcf["assets"].items():
        if name.lower().endswith(".obj"):
            mjcf["assets"][name] = data.replace(b".", point)
    try:
        spec = mujoco.MjSpec.from_string(**mjcf)
    except ValueError as error:
        raise ValueError(f"arena {source}: {one_line(error)}") from None
    _check(spec, source)
    for geom in spec.geoms:
        if geom.name != "floor" and (geom.contype or geom.conaffinity):
            geom.contype = geom.conaffinity = HULL
    return spec


def _read(source: str) -> tuple[dict[str, Any], dict[Path, bytes]]:
    """Read an arena and all files that it names: arguments of ``MjSpec.from_string``, and the contents of each file.

    Files are searched in the arena's folder, then in ``scenes``.
    """
    path = arena_path(source)
    found, includes, assets = {path: path.read_bytes()}, dict[str, bytes](), dict[str, bytes]()
    text = importlib.import_module(WIRING).arena_text(path) if path.suffix == ".py" else found[path].decode()
    roots = [_parsed(path, text)]
    for root in roots:  # which grows
        for name in (element.get("file", "") for element in root.iter("include")):
            if name and name not in includes:
                place = _find(path, name, [""], FOLDER)
                includes[name] = found[place] = place.read_bytes()
                roots.append(_parsed(place, includes[name]))
    folders = ["", *(folder for root in roots for folder in _folders(root))]
    for name in (name for root in roots for name in _files(root)):
        place = _find(path, name, folders, FOLDER / "assets")
        assets[name] = found[place] = place.read_bytes()
        if assets[name].startswith(b"\x89PNG") and assets[name][24] == 16:  # bits: MuJoCo takes the upper 8
            read_picture(place)
    return {"xml": text, "include": includes, "assets": assets}, found


def _check(spec: mujoco.MjSpec, source: str) -> None:
    """Raise ``ValueError`` if a required element is missing, or something in the arena moves."""
    for kind, name in NEEDED.items():
        if getattr(spec, kind)(name) is None:
            raise ValueError(f'arena {source}: no {kind} is called {name}: <include file="bright.xml"/> has it')
    for elements in MOVING:
        if list(getattr(spec, elements)):
            raise ValueError(f"arena {source}: has {elements}: everything in an arena stands still")
    usual = spec.option if source in ARENAS else arena_spec("bright").option
    for name in PHYSICS:
        if str(getattr(spec.option, name)) != str(getattr(usual, name)):
            raise ValueError(
                f"arena {source}: option {name} must be as arena_base.xml has it: include that, and leave <option> out"
            )


def one_line(error: Exception) -> str:
    """Write MuJoCo's message in one line."""
    return ", ".join(line.strip() for line in str(error).splitlines() if line.strip())


def _parsed(place: Path, text: str | bytes) -> ElementTree.Element:
    try:
        return ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise ValueError(f"arena {place}: not valid XML ({error})") from None


def _find(path: Path, name: str, folders: Iterable[str], shipped: Path) -> Path:
    """Find a file that an arena names: in the arena's folder, or among the built-in ones."""
    for folder in folders:
        place = path.parent / folder / name
        if place.is_file() and place != path:
            return place.resolve()
    if (shipped / name).is_file():
        return shipped / name
    raise ValueError(f"arena {path}: the file {name} is neither in {path.parent} nor built in")


def _folders(root: ElementTree.Element) -> Iterator[str]:
    """Yield the folders of files that MJCF sets."""
    for element in root.iter("compiler"):
        yield from (value for name, value in element.attrib.items() if name.endswith("dir") and value)


def _files(root: ElementTree.Element) -> Iterator[str]:
    """Yield the files that elements name, except includes: ``file`` of meshes, six ``file...`` of a cube texture."""
    for element in root.iter():
        if element.tag != "include":
            yield from (value for name, value in element.attrib.items() if name.startswith("file") and value)
