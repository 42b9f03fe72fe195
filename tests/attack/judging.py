"""Bad models beside honest ones: what a command leaves is held against what it would leave without them."""

from __future__ import annotations

import json
import math
import re
import unicodedata
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.attack.commands import PLAY, WATCH, Command, Reference, Rows, furnish, potentials, show
from tests.attack.model_files import LOST, WORKS, Case
from tests.attack.processes import Ended

LONGEST_LINE = 2000
"""On a terminal, of anything."""


MORE = "more: see failures.json"
"""What stands on stderr instead of the failures that are too many to be told one by one."""


def expect_none(found: Sequence[str]) -> None:
    """Fail with what was found, a line each, if anything was."""
    if found:
        pytest.fail("\n" + "\n".join(found), pytrace=False)


def problems(command: Command, cases: Sequence[Case], folder: Path, honest: Reference) -> list[str]:
    """Run the command with all the cases beside the honest models; everything that is not as promised."""
    furnish(folder)
    written = [case.write(folder) for case in cases]
    ended = show(command, folder, written, honest.last)
    lost: list[Case] = []
    found = basics(ended, cases, command)
    if command is PLAY:
        found += _played(folder, cases, ended, honest, lost)
    else:
        found += _tables(command, cases, folder, honest, lost)
    for case in lost:
        found += _named(case, command, folder, ended)
    expected = 1 if lost else 0
    if ended.status != expected:
        found.append(f"exit status {ended.status} where {len(lost)} of {len(cases)} models failed; said {_end(ended)}")
    return found + stray(folder, (*written, *command.left))


def basics(ended: Ended, cases: Sequence[Case], command: Command) -> list[str]:
    """What holds of every command, whatever it is given."""
    found = [f"says {word!r}: {_last_line(ended, word)}" for word in ended.crashes()]
    if ended.status is None:
        found.append("does not end")
    allowed = {case.leaves for case in cases if case.leaves}
    found += [
        f"left a process: {left}"
        for left in ended.left
        if left not in allowed and not (command.leaves_programs and any("forks" in case.name for case in cases))
    ]
    for line in ended.err.splitlines():
        if len(line) > LONGEST_LINE:
            found.append(f"a line of {len(line)} letters on stderr: {line[:80]}")
        if any(unicodedata.category(letter) == "Cc" for letter in line):
            found.append(f"control characters on stderr: {line[:200]!r}")
    return found


def _last_line(ended: Ended, word: str) -> str:
    said = ended.err if word in ended.err else ended.out
    return said.strip().splitlines()[-1][:200]


def _end(ended: Ended) -> str:
    return " | ".join(ended.err.strip().splitlines()[-3:])[-500:]


def _tables(command: Command, cases: Sequence[Case], folder: Path, honest: Reference, lost: list[Case]) -> list[str]:
    try:
        tables = command.tables(folder)
    except Exception as error:  # whatever reading it raises is the finding
        return [f"no readable {command.table}: {type(error).__name__}: {str(error)[:200]}"]
    if not any(label in tables for label in command.others):
        return ["all is lost, what the honest models say too"]
    found = []
    for label in command.others:
        if tables.get(label) != honest.tables[label]:
            found.append(f"{label}'s rows are not those of a run without: {_first(tables.get(label), honest, label)}")
    for case in cases:
        rows = tables.get(case.label, [])
        if _incomplete(case, rows, honest):
            lost.append(case)
            if LOST not in case.may:
                found.append(f"{case.name}: lost its part ({len(rows)} rows)")
            continue
        if WORKS not in case.may:
            found.append(f"{case.name}: passes as if it answered: {_sample(rows)}")
        elif case.twin is not None and (
            differs := _difference(rows, honest.tables[case.twin], case.close, case.ignore)
        ):
            found.append(f"{case.name}: {differs}")
        found += [f"{case.name}: not finite: {_sample([row])}" for row in rows if _unreal(row)][:1]
    return found


def _incomplete(case: Case, rows: Rows, honest: Reference) -> bool:
    """Whether a model has fewer rows than its twin, or nothing where that has a number."""
    wanted = honest.tables[case.twin or "twin"]
    numbers = [name for name in wanted[0] if all(row.get(name) is not None for row in wanted if name in row)]
    return len(rows) < len(wanted) or any(row[name] is None for row in rows for name in numbers if name in row)


def _unreal(row: dict[str, Any]) -> bool:
    return any(isinstance(value, float) and not math.isfinite(value) for value in row.values())


def _from_twin(case: Case, rows: Rows, honest: Reference) -> str:
    return "" if case.twin is None else _difference(rows, honest.tables[case.twin], case.close, case.ignore)


def _first(rows: Rows | None, honest: Reference, label: str) -> str:
    return "there are none" if not rows else _difference(rows, honest.tables[label])


def _difference(rows: Rows, wanted: Rows, close: float = 0.0, ignore: str = "-") -> str:
    """The first difference of rows from those they should equal; empty if there is none."""
    if len(rows) != len(wanted):
        return f"{len(rows)} rows instead of {len(wanted)}"
    for row, right in zip(rows, wanted, strict=True):
        for name, value in right.items():
            if ignore in name:
                continue
            own = row.get(name)
            near = isinstance(value, float) and isinstance(own, float) and abs(own - value) <= close
            if own != value and not near and not (close and name in ("spikes", "firing_rate_hz")):
                place = {k: row[k] for k in ("of", "trial", "frame") if k in row}
                return f"{name} is {own} instead of {value} {place}"
    return ""


def _sample(rows: Rows) -> str:
    names = ("spikes", "peak_hs", "hs", "hs_spikes", "vs_spikes", "looming")
    return str({name: row[name] for row in rows for name in names if row.get(name)})


def _named(case: Case, command: Command, folder: Path, ended: Ended) -> list[str]:
    """A model that lost its part is named on stderr with the reason, and in failures.json."""
    lines = [line for line in ended.err.splitlines() if case.label in line]
    found = [] if lines or MORE in ended.err else [f"{case.name}: not named on stderr"]
    if command in (WATCH, PLAY) or not command.runs:
        return found
    reasons = []
    for run in command.runs:
        try:
            listed = strict_json(folder / run / "failures.json")
            reasons += [item["reason"] for item in listed if item["model"] == case.label]
        except FileNotFoundError:
            continue
        except (ValueError, KeyError, TypeError, OSError) as error:
            return [*found, f"failures.json: {error}"]
    if not reasons:
        return [*found, f"{case.name}: not in failures.json"]
    if lines and not any(reason in line for reason in reasons for line in lines):
        found.append(f"{case.name}: stderr does not give the reason {reasons[0][:80]!r}")
    bad = [reason for reason in reasons if not reason or "\n" in reason or len(reason) > LONGEST_LINE]
    return found + [f"{case.name}: no reason in one line: {len(reason)} letters" for reason in bad[:1]]


def strict_json(path: Path) -> Any:
    """What a JSON file holds; ``ValueError`` for NaN and Infinity too, which JSON does not know."""

    def refuse(word: str) -> Any:
        raise ValueError(f"{path.name} holds {word}")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def stray(folder: Path, expected: Sequence[str]) -> list[str]:
    """Files that a command left beside what it was asked for."""
    known = {*expected, "tiny.py", "clips.py", "film.avi", "tmp", "__pycache__", "twin.py", "looming-twin.py"}
    found = [f"left {path.name}" for path in folder.iterdir() if path.name not in known]
    found += [f"left {path} among temporary files" for path in (folder / "tmp").iterdir()]
    found += [f"left {path}" for path in folder.rglob("*.part")]
    for path in folder.rglob("*.json"):
        try:
            strict_json(path)
        except ValueError as error:
            found.append(f"{path.name} is no JSON: {str(error)[:100]}")
    return found


def _played(folder: Path, cases: Sequence[Case], ended: Ended, honest: Reference, lost: list[Case]) -> list[str]:
    """``play`` prints a line per model, and keeps a recording."""
    lines = ended.out.splitlines()
    said = {
        case.name: [line for line in lines if re.match(re.escape(case.label) + r"\s*(HS|LOOMING) ", line)]
        for case in cases
    }
    found = [] if (folder / "played.rrd").is_file() else ["no recording"]
    if potentials(ended.out) != honest.printed:
        found.append(f"of the dsnn it says {potentials(ended.out)} instead of {honest.printed}")
    for case in cases:
        if WORKS not in case.may or not said[case.name]:
            lost.append(case)
        if WORKS not in case.may and said[case.name]:
            found.append(f"{case.name}: passes as if it answered: {said[case.name][0]}")
        if LOST not in case.may and not said[case.name]:
            found.append(f"{case.name}: lost its part")
        numbers = [line[len(case.label) :] for line in said[case.name]]
        found += [f"{case.name}: {line}" for line in numbers if "nan" in line or "inf" in line]
    return found


def refusal(ended: Ended) -> list[str]:
    """What is wrong with a refusal: it is one line on stderr, and status 2."""
    lines = ended.err.splitlines()
    found = [f"says {word!r}: {_last_line(ended, word)}" for word in ended.crashes()]
    if ended.status != 2:
        found.append(f"exit status {ended.status}")
    if len(lines) != 1 or not lines[0].startswith("colias: "):
        found.append(f"{len(lines)} lines on stderr: {_end(ended)}")
    if any(len(line) > LONGEST_LINE for line in lines):
        found.append(f"a line of {max(map(len, lines))} letters")
    return found + [f"left a process: {left}" for left in ended.left]
