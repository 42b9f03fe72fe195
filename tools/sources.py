"""Hold the published pictures and tables against the runs that they are of: ``python -m tools.sources``.

``python -m tools.sources take RUN_FOLDER... PLACE...`` notes in ``docs/sources.json`` the command, the commit and the
rows of finished runs, a digest of their first trials, and what each place shows now: a picture in docs/
(``map-c6.png``), or a table of a page (``maps.md#c13-c19``) between ``<!-- table: c13-c19 -->`` and its end. It refuses
a table with a number that the runs' own tables do not have. ``python -m tools.sources check`` refuses a picture or
table that is of no run, or was changed since. Then it does each command anew up to its first trial, and refuses one
whose trial has other numbers. `tools.numbers` holds what the whole reproduction measures.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import re
import shlex
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import polars as pl
from PIL import Image

from experiments.bench.cli.main import command
from experiments.bench.run.errors import UsageError
from experiments.bench.run.runs import Enough, first
from experiments.bench.store import provenance
from experiments.bench.store.description import read_description
from experiments.bench.store.files import UNREPEATABLE, hash_of, read_parquet, tables_hash, tables_of

ROOT = Path(__file__).parents[1]
SOURCES = Path("docs") / "sources.json"
WITHOUT_ROWS = ("budget.png", "eye.png")
"""Pictures in docs/ that are drawn from no trials."""
PICTURES = (".png", ".gif", ".webp", ".mp4", ".jpg")
TABLE = re.compile(r"<!-- table: ([\w-]+) -->\n(.*?)<!-- end of table -->", re.DOTALL)
DRAWN = re.compile(r"rows (\w+(?:, \w+)*) of trials.parquet, commit (.+)")
"""Source that a picture notes: the rows of its run, or of each of its runs, and their commit."""
NUMBERS = re.compile(r"[-+]?\d")
CODE = re.compile(r"`[^`]*`")
SHOWN = re.compile(r"(?<![\w.])-?\d[\d,]*(?:\.(\d+))?( %)?")
"""A number in a cell, its decimals, and whether it is a percentage."""
READABLE = 3
"""Numbers of a first trial that are noted beside its digest."""
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


def unread(text: str, runs: Sequence[Path]) -> list[str]:
    """Return the numbers that a table shows and the CSV tables of its runs do not have, each with its row's name.

    A number is looked for, rounded to the decimals that are shown, in the rows of those tables that have the row's name
    as a value, and what else its first cell and the column's head name. The name of a run's folder counts as values of
    all its rows, each part between dashes.

    Parameters
    ----------
    text
        A table in Markdown.
    runs
        Folders of runs.
    """
    rows = []
    for run in runs:
        names = [part for part in run.name.split("-") if not _is_number(part)]
        for path in run.glob("*.csv"):
            rows += [row + names for row in csv.reader(path.read_text(encoding="utf-8").splitlines())]
    (_, *heads), _, *table = ([cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines())
    missing = []
    for name, *cells in table:
        of_name = _narrowed(rows, name, must=True)
        for head, cell in zip(heads, cells, strict=True):
            values = [float(value) for row in _narrowed(of_name, head) for value in row if _is_number(value)]
            for number in SHOWN.finditer(CODE.sub("", cell)):
                cell_number, unit = float(number[0].rstrip(" %,").replace(",", "")), 100.0 if number[2] else 1.0
                half = 0.5 * 10.0 ** -len(number[1] or "") * (1 + 1e-9)
                if not any(abs(unit * value - cell_number) <= half for value in values):
                    missing.append(f"{number[0]} of {name}")
    return missing


def _narrowed(rows: Sequence[Sequence[str]], name: str, must: bool = False) -> Sequence[Sequence[str]]:
    """Return the rows that have the parts of a name as values; a part that none has does not count.

    With ``must`` the first part counts.
    """
    for place, part in enumerate(name.replace("`", "").split(", ")):
        having = [row for row in rows if part in row]
        rows = having if having or (must and place == 0) else rows
    return rows


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def noted(runs: Sequence[Path], places: Sequence[str], root: Path, by_hand: bool = False) -> dict[str, Any]:
    """Return what is noted of runs whose rows some places show, by the names of their folders.

    Parameters
    ----------
    runs
        Folders of runs.
    places
        Pictures in docs/, and tables as ``PAGE#NAME``.
    root
        The folder of docs/.
    by_hand
        Whether the tables show what was computed from the runs' tables, so that their numbers are not looked for there.

    Raises
    ------
    Stale
        A run is of code that nobody can check out, is not of one command, or a place shows something else.
    """
    there = contents(root)
    for place in places:
        if place not in there:
            raise Stale(f"docs/ does not show {place}; it shows {', '.join(there)}")
    tables = [place for place in places if "#" in place]
    for page, _, name in () if by_hand else (place.partition("#") for place in tables):
        text = dict(TABLE.findall((root / "docs" / page).read_text(encoding="utf-8")))[name]
        if missing := unread(text, runs):
            raise Stale(f"docs/{page}#{name}: the tables of {', '.join(map(str, runs))} do not have {missing[0]}")
    shows = {place: there[place] for place in places}
    return {run.name: _of_run(run, shows, root) | ({"by_hand": tables} if by_hand else {}) for run in runs}


def _of_run(run: Path, shows: Mapping[str, str], root: Path) -> dict[str, Any]:
    description = read_description(run)
    line = (description.get("command") or {}).get("line")
    if not line or "--out" not in line:
        raise Stale(f"{run}: run.json has no command with --out")
    tables = tables_of(run)
    if not tables:
        raise Stale(f"{run}: has no trials.parquet")
    rows, part = tables_hash(tables), read_description(tables[0].parent)  # a leaderboard's parts alone know their code
    commit = provenance.commit(description.get("source") or part.get("source", {})) or "unknown"
    for place in shows:
        if place.endswith(".png"):  # whose rows an earlier commit may have computed as well
            source = DRAWN.fullmatch(_source(root / "docs" / place))
            if source is None or rows not in source[1].split(", "):
                raise Stale(f"docs/{place} is not drawn from the rows of {run}")
            commit = source[2]
    if not re.fullmatch("[0-9a-f]+", commit):
        raise Stale(f"{run}: is of commit {commit}, which nobody can check out")
    for option in {"--out", "--workers"} & set(line):  # neither changes a number
        at = line.index(option)
        line = line[:at] + line[at + 2 :]
    return {
        "command": shlex.join(line),
        "commit": commit,
        "rows": rows,
        "shows": dict(shows),
        "first": {} if line[0] in UNREPLAYED else digest(first_trial(tables[0])),
    }


def _source(picture: Path) -> str:
    with Image.open(picture) as opened:
        return str(opened.info.get("Source", ""))


def first_trial(path: Path) -> pl.DataFrame:
    """Return the rows of trial 0 in a table."""
    return read_parquet(path).filter(pl.col("trial") == 0).drop(UNREPEATABLE, strict=False)


def digest(rows: pl.DataFrame) -> dict[str, Any]:
    """Return what is noted of a first trial: the hash of its rows, their columns, a few numbers of the first row."""
    numbers = {
        name: value for name, value in rows.row(0, named=True).items()
        if isinstance(value, float) and value % 1.0  # a measured one is hardly ever whole
    }  # fmt: skip
    return {
        "rows": hash_of(rows),
        "columns": " ".join(rows.columns),
        "numbers": {name: numbers[name] for name in list(numbers)[:READABLE]},
    }


def as_text(sources: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the notes as JSON, each field of a run on a line of its own."""
    runs = [
        f" {json.dumps(name)}: {{\n"
        + ",\n".join(f"  {json.dumps(field)}: {json.dumps(value)}" for field, value in source.items())
        + "\n }"
        for name, source in sources.items()
    ]
    return "{\n" + ",\n".join(runs) + "\n}\n"


def unfit(sources: Mapping[str, Mapping[str, Any]], root: Path) -> str:
    """Say which picture or table is of no run, or is not what was noted of its run; empty where all are."""
    there = contents(root)
    entries = [(name, place, digest) for name, source in sources.items() for place, digest in source["shows"].items()]
    for name, place, digest in entries:
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
    without = sorted(set(there) - {place for _, place, _ in entries})
    return f"docs/sources.json notes no run of {', '.join(without)}" if without else ""


def difference(source: Mapping[str, Any], folder: Path) -> str:
    """Do a noted command anew up to its first trial, in ``folder``, and say what differs; empty where nothing does."""
    line = [*shlex.split(source["command"]), "--out", str(folder), "--workers", "0"]
    try:
        with first(1):
            command(line)
    except Enough:
        pass
    except UsageError as error:
        return f"its command is refused now: {error}"
    rows, then = first_trial(tables_of(folder)[0]), source["first"]
    columns = then["columns"].split()  # a column that came since is no difference
    if gone := [column for column in columns if column not in rows.columns]:
        return f"the column {gone[0]} is gone"
    if rows.is_empty():
        return "trial 0 failed"
    if hash_of(rows.select(columns)) == then["rows"]:
        return ""
    numbers = [(name, rows[name][0], was) for name, was in then["numbers"].items()]
    other = [f"{name} is {now} and was {was}" for name, now, was in numbers if now != was]
    return f"trial 0 has other rows: {'; '.join(other) or 'equal in ' + ', '.join(then['numbers'])}"


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
    take = actions.add_parser("take", help="note runs, and what shows them")
    take.add_argument("runs_and_places", nargs="+", metavar="RUN_FOLDER... PLACE", help="folders, then what shows them")
    take.add_argument("--by-hand", action="store_true", help="the tables show what was computed from those of the runs")
    actions.add_parser("check", help="refuse what is stale")
    given = parser.parse_args(arguments)
    path = given.root / SOURCES
    sources = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    try:
        if given.action == "take":
            runs = [Path(word) for word in given.runs_and_places if Path(word).is_dir()]
            places = [word for word in given.runs_and_places if not Path(word).is_dir()]
            if not (runs and places):
                raise Stale(f"take {' '.join(given.runs_and_places)}: legal is folders of runs, and places")
            notes = noted(runs, places, given.root, given.by_hand)
            path.write_text(as_text(sources | notes), encoding="utf-8")
            return 0
        if why := unfit(sources, given.root):
            raise Stale(why)
        for name, differs in differences(sources):
            if differs:
                raise Stale(f"{name}: {differs}: run {sources[name]['command']} anew")
            print(f"sources: {name}: trial 0 is equal", file=sys.stderr)
    except (Stale, UsageError) as error:
        print(f"sources: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
