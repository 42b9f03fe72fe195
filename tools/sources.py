"""Hold the published pictures and tables against the runs that they are of: ``python -m tools.sources``.

``python -m tools.sources take RUN_FOLDER PLACE...`` notes in ``docs/sources.json`` the command, the commit and the rows
of a finished run, its first trial, and what each place shows now: a picture in docs/ (``map-c6.png``), or a table of a
page (``maps.md#c13-c19``) between ``<!-- table: c13-c19 -->`` and its end. ``python -m tools.sources check`` refuses a
picture or table that is of no run, or was changed since. Then it does each command anew up to its first trial, and
refuses one whose trial has other numbers. `tools.numbers` holds what the whole reproduction measures.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
from PIL import Image

from experiments.bench.cli.main import command
from experiments.bench.engine.batch import Enough, first
from experiments.bench.engine.errors import UsageError
from experiments.bench.store import provenance
from experiments.bench.store.description import read_description
from experiments.bench.store.files import UNREPEATABLE, read_parquet, rows_hash

ROOT = Path(__file__).parents[1]
SOURCES = Path("docs") / "sources.json"
WITHOUT_ROWS = ("budget.png", "eye.png")
"""Pictures in docs/ that are drawn from no trials."""
PICTURES = (".png", ".gif", ".webp", ".mp4", ".jpg")
TABLE = re.compile(r"<!-- table: ([\w-]+) -->\n(.*?)<!-- end of table -->", re.DOTALL)
DRAWN = re.compile(r"rows (\w+) of trials.parquet, commit (.+)")
NUMBERS = re.compile(r"[-+]?\d")
WITHOUT = "<!-- no rows: "
"""Begins the line above a table of numbers that no run has, and tells why."""
UNREPLAYED = ("train",)
"""Commands whose first trial comes after a training."""


def unrecorded(text: str) -> list[str]:
    """Return the heads of a page's tables of numbers that are of no run, and do not say why there is none.

    A table of numbers is one of whose cells a third begin with a number.

    Parameters
    ----------
    text
        Markdown.
    """
    plain = re.sub(r"<!-- (table|measured): .*?<!-- end of \w+ -->", "", text, flags=re.DOTALL)
    heads = []
    for before, table in re.findall(r"([^\n]*)\n((?:\|[^\n]*\n)+)", plain):
        head, _, *rows = table.splitlines()
        cells = [cell.strip() for row in rows for cell in row.strip("|").split("|")]
        if not before.startswith(WITHOUT) and sum(bool(NUMBERS.match(cell)) for cell in cells) > len(cells) / 3:
            heads.append(head)
    return heads


class Stale(Exception):
    """A picture or table that its run does not show, or a run that comes out otherwise now."""


def contents(root: Path) -> dict[str, str]:
    """Return what the documentation shows of runs: each place and the SHA-256 of its picture, or of its table's text.

    Raises
    ------
    Stale
        Two tables of a page have one name.
    """
    docs = root / "docs"
    pictures = [path for path in docs.glob("*") if path.suffix in PICTURES and path.name not in WITHOUT_ROWS]
    places = {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(pictures)}
    for page in sorted(docs.glob("*.md")):
        for name, text in TABLE.findall(page.read_text(encoding="utf-8")):
            place = f"{page.name}#{name}"
            if place in places:
                raise Stale(f"docs/{page.name} has two tables called {name}")
            places[place] = hashlib.sha256(text.encode()).hexdigest()
    return places


def noted(run: Path, places: Sequence[str], root: Path) -> dict[str, Any]:
    """Return what is noted of a run whose rows some places show.

    Parameters
    ----------
    run
        Folder of the run.
    places
        Pictures in docs/, and tables as ``PAGE#NAME``.
    root
        The folder of docs/.

    Raises
    ------
    Stale
        The run is of code that nobody can check out, is not of one command, or a place shows something else.
    """
    description = read_description(run)
    line = (description.get("command") or {}).get("line")
    if not line or "--out" not in line:
        raise Stale(f"{run}: experiment.json has no command with --out")
    tables = tables_of(run)
    rows, part = _rows(tables), read_description(tables[0].parent)  # a leaderboard's parts alone know their code
    commit = provenance.commit(description.get("source") or part.get("source", {})) or "unknown"
    there = contents(root)
    for place in places:
        if place not in there:
            raise Stale(f"docs/ does not show {place}; it shows {', '.join(there)}")
        if place.endswith(".png"):  # whose rows an earlier commit may have computed as well
            source = DRAWN.fullmatch(_source(root / "docs" / place))
            if source is None or source[1] != rows:
                raise Stale(f"docs/{place} is not drawn from the rows of {run}")
            commit = source[2]
    if not re.fullmatch("[0-9a-f]+", commit):
        raise Stale(f"{run}: is of commit {commit}, which nobody can check out")
    at = line.index("--out")
    return {
        "command": line[:at] + line[at + 2 :],
        "commit": commit,
        "rows": rows,
        "shows": {place: there[place] for place in places},
        "first": {} if line[0] in UNREPLAYED else first_trial(tables[0]),
    }


def _source(picture: Path) -> str:
    with Image.open(picture) as opened:
        return str(opened.info.get("Source", ""))


def tables_of(run: Path) -> list[Path]:
    """Return the tables of a run's trials: its own, or those of its parts in the order in which they ended."""
    whole = run / "trials.parquet"
    if whole.is_file():
        return [whole]
    parts = sorted(run.glob("*/trials.parquet"), key=lambda path: path.stat().st_mtime)
    if not parts:
        raise Stale(f"{run}: has no trials.parquet")
    return parts


def _rows(tables: Sequence[Path]) -> str:
    """Return the hash of a run's rows; of several tables that of their hashes, by the names of their folders."""
    if len(tables) == 1:
        return rows_hash(tables[0])
    hashes = {table.parent.name: rows_hash(table) for table in tables}
    return hashlib.sha256(json.dumps(hashes, sort_keys=True).encode()).hexdigest()


def first_trial(path: Path) -> dict[str, list[Any]]:
    """Return the rows of trial 0 in a table, by column, as JSON has them."""
    table = read_parquet(path)
    rows = table.filter(pc.equal(table["trial"], pa.scalar(0)))
    columns = {name: rows[name].to_pylist() for name in rows.schema.names if name not in UNREPEATABLE}
    return dict(json.loads(json.dumps(columns, default=str)))


def unfit(sources: Mapping[str, Mapping[str, Any]], root: Path) -> str:
    """Say which picture or table is of no run, or is not what was noted of its run; empty where all are."""
    there = contents(root)
    shown = [(name, place, digest) for name, source in sources.items() for place, digest in source["shows"].items()]
    for name, place, digest in shown:
        if place not in there:
            return f"docs/ does not show {place}, which sources.json notes of {name}"
        if there[place] != digest:
            return f"docs/{place} was changed since it was taken from {name}"
        picture = root / "docs" / place
        if picture.suffix == ".png" and sources[name]["rows"] not in _source(picture):
            return f"docs/{place} is not drawn from the rows of {name}"
    for page in sorted((root / "docs").glob("*.md")):
        for head in unrecorded(page.read_text(encoding="utf-8")):
            return f"docs/{page.name}: the table {head} is of no run; put it between markers, or say why ({WITHOUT}...)"
    without = sorted(set(there) - {place for _, place, _ in shown})
    return f"docs/sources.json notes no run of {', '.join(without)}" if without else ""


def difference(source: Mapping[str, Any], folder: Path) -> str:
    """Do a noted command anew up to its first trial, in ``folder``, and say what differs; empty where nothing does."""
    line = [*source["command"], "--out", str(folder), "--workers", "0"]
    try:
        with first(1):
            command(line)
    except Enough:
        pass
    except UsageError as error:
        return f"its command is refused now: {error}"
    now = first_trial(tables_of(folder)[0])
    for column, values in source["first"].items():
        if column not in now:
            return f"the column {column} is gone"
        if repr(now[column]) != repr(values):
            return f"{column} of trial 0 is {now[column]} and was {values}"
    return ""


def differences(sources: Mapping[str, Mapping[str, Any]]) -> Iterator[tuple[str, str]]:
    """Yield each run that can be replayed, and what differs in its first trial."""
    with tempfile.TemporaryDirectory() as parent:
        for name, source in sources.items():
            if source["first"]:
                yield name, difference(source, Path(parent) / name)


def main(arguments: Sequence[str] | None = None) -> int:
    """Take a run's notes, or check all; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m tools.sources", description="Pictures and tables, and their runs.")
    parser.add_argument("--root", type=Path, default=ROOT, help="folder of docs/")
    actions = parser.add_subparsers(dest="action", required=True)
    take = actions.add_parser("take", help="note a run, and what shows it")
    take.add_argument("run", type=Path)
    take.add_argument("places", nargs="+", metavar="PLACE")
    actions.add_parser("check", help="refuse what is stale")
    given = parser.parse_args(arguments)
    path = given.root / SOURCES
    sources = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    try:
        if given.action == "take":
            notes = noted(given.run, given.places, given.root)
            path.write_text(json.dumps(sources | {given.run.name: notes}, indent=1) + "\n", encoding="utf-8")
            return 0
        if why := unfit(sources, given.root):
            raise Stale(why)
        for name, differs in differences(sources):
            if differs:
                raise Stale(f"{name}: {differs}: run {' '.join(sources[name]['command'])} anew")
            print(f"sources: {name}: trial 0 is equal", file=sys.stderr)
    except (Stale, UsageError) as error:
        print(f"sources: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
