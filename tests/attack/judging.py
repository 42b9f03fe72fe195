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


def expect_none(faults: Sequence[str]) -> None:
    """Fail with what was found, a line each, if anything was."""
    if faults:
        pytest.fail("\n" + "\n".join(faults), pytrace=False)


def problems(command: Command, cases: Sequence[Case], folder: Path, honest: Reference) -> list[str]:
    """Run the command with all the cases beside the honest models; everything that is not as promised."""
    furnish(folder)
    written = [case.write(folder) for case in cases]
    ended = show(command, folder, written, honest.last)
    lost: list[Case] = []
    faults = basics(ended, cases, command)
    if command is PLAY:
        faults += _played(folder, cases, ended, honest, lost)
    else:
        faults += _tables(command, cases, folder, honest, lost)
    for case in lost:
        faults += _named(case, command, folder, ended)
    expected = 1 if lost else 0
    if ended.status != expected:
        faults.append(f"exit status {ended.status} where {len(lost)} of {len(cases)} models failed; said {_end(ended)}")
    return faults + stray(folder, (*written, *command.left))


def basics(ended: Ended, cases: Sequence[Case], command: Command) -> list[str]:
    """What holds of every command, whatever it is given."""
    faults = [f"says {word!r}: {_last_line(ended, word)}" for word in ended.crashes()]
    if ended.status is None:
        faults.append("does not end")
    allowed = {case.leaves for case in cases if case.leaves}
    faults += [
        f"left a process: {left}"
        for left in ended.left
        if left not in allowed and not (command.leaves_programs and any("forks" in case.name for case in cases))
    ]
    for line in ended.err.splitlines():
        if len(line) > LONGEST_LINE:
            faults.append(f"a line of {len(line)} letters on stderr: {line[:80]}")
        if any(unicodedata.category(letter) == "Cc" for letter in line):
            faults.append(f"control characters on stderr: {line[:200]!r}")
    return faults


def _last_line(ended: Ended, word: str) -> str:
    output = ended.err if word in ended.err else ended.out
    return output.strip().splitlines()[-1][:200]


def _end(ended: Ended) -> str:
    return " | ".join(ended.err.strip().splitlines()[-3:])[-500:]


def _tables(command: Command, cases: Sequence[Case], folder: Path, honest: Reference, lost: list[Case]) -> list[str]:
    try:
        tables = command.tables(folder)
    except Exception as error:  # whatever reading it raises is the finding
        return [f"no readable {command.table}: {type(error).__name__}: {str(error)[:200]}"]
    if not any(label in tables for label in command.others):
        return ["all is lost, what the honest models say too"]
    faults = []
    for label in command.others:
        if tables.get(label) != honest.tables[label]:
            faults.append(f"{label}'s rows are not those of a run without: {_first(tables.get(label), honest, label)}")
    for case in cases:
        rows = tables.get(case.label, [])
        if _incomplete(case, rows, honest):
            lost.append(case)
            if LOST not in case.may:
                faults.append(f"{case.name}: lost its part ({len(rows)} rows)")
            continue
        if WORKS not in case.may:
            faults.append(f"{case.name}: passes as if it answered: {_sample(rows)}")
        elif case.twin is not None and (
            differs := _difference(rows, honest.tables[case.twin], case.close, case.ignore)
        ):
            faults.append(f"{case.name}: {differs}")
        faults += [f"{case.name}: not finite: {_sample([row])}" for row in rows if _unreal(row)][:1]
    return faults


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
            actual = row.get(name)
            near = isinstance(value, float) and isinstance(actual, float) and abs(actual - value) <= close
            if actual != value and not near and not (close and name in ("spikes", "firing_rate_hz")):
                place = {k: row[k] for k in ("of", "trial", "frame") if k in row}
                return f"{name} is {actual} instead of {value} {place}"
    return ""


def _sample(rows: Rows) -> str:
    names = ("spikes", "peak_hs", "hs", "hs_spikes", "vs_spikes", "looming")
    return str({name: row[name] for row in rows for name in names if row.get(name)})


def _named(case: Case, command: Command, folder: Path, ended: Ended) -> list[str]:
    """A model that lost its part is named on stderr with the reason, and in failures.json."""
    lines = [line for line in ended.err.splitlines() if case.label in line]
    faults = [] if lines or MORE in ended.err else [f"{case.name}: not named on stderr"]
    if command in (WATCH, PLAY) or not command.runs:
        return faults
    reasons = []
    for run in command.runs:
        try:
            listed = strict_json(folder / run / "failures.json")
            reasons += [item["reason"] for item in listed if item["model"] == case.label]
        except FileNotFoundError:
            continue
        except (ValueError, KeyError, TypeError, OSError) as error:
            return [*faults, f"failures.json: {error}"]
    if not reasons:
        return [*faults, f"{case.name}: not in failures.json"]
    if lines and not any(reason in line for reason in reasons for line in lines):
        faults.append(f"{case.name}: stderr does not give the reason {reasons[0][:80]!r}")
    bad = [reason for reason in reasons if not reason or "\n" in reason or len(reason) > LONGEST_LINE]
    return faults + [f"{case.name}: no reason in one line: {len(reason)} letters" for reason in bad[:1]]


def strict_json(path: Path) -> Any:
    """What a JSON file holds; ``ValueError`` for NaN and Infinity too, which JSON does not know."""

    def refuse(word: str) -> Any:
        raise ValueError(f"{path.name} holds {word}")

    return json.loads(path.read_text(encoding="utf-8"), parse_constant=refuse)


def stray(folder: Path, expected: Sequence[str]) -> list[str]:
    """Files that a command left beside what it was asked for."""
    known = {*expected, "tiny.py", "clips.py", "film.avi", "tmp", "__pycache__", "twin.py", "looming-twin.py"}
    faults = [f"left {path.name}" for path in folder.iterdir() if path.name not in known]
    faults += [f"left {path} among temporary files" for path in (folder / "tmp").iterdir()]
    faults += [f"left {path}" for path in folder.rglob("*.part")]
    for path in folder.rglob("*.json"):
        try:
            strict_json(path)
        except ValueError as error:
            faults.append(f"{path.name} is no JSON: {str(error)[:100]}")
    return faults


def _played(folder: Path, cases: Sequence[Case], ended: Ended, honest: Reference, lost: list[Case]) -> list[str]:
    """``play`` prints a line per model, and keeps a recording."""
    lines = ended.out.splitlines()
    printed = {
        case.name: [line for line in lines if re.match(re.escape(case.label) + r"\s*(HS|LOOMING) ", line)]
        for case in cases
    }
    faults = [] if (folder / "played.rrd").is_file() else ["no recording"]
    if potentials(ended.out) != honest.printed:
        faults.append(f"of the dsnn it says {potentials(ended.out)} instead of {honest.printed}")
    for case in cases:
        if WORKS not in case.may or not printed[case.name]:
            lost.append(case)
        if WORKS not in case.may and printed[case.name]:
            faults.append(f"{case.name}: passes as if it answered: {printed[case.name][0]}")
        if LOST not in case.may and not printed[case.name]:
            faults.append(f"{case.name}: lost its part")
        numbers = [line[len(case.label) :] for line in printed[case.name]]
        faults += [f"{case.name}: {line}" for line in numbers if "nan" in line or "inf" in line]
    return faults


def refusal(ended: Ended) -> list[str]:
    """What is wrong with a refusal: it is one line on stderr, and status 2."""
    lines = ended.err.splitlines()
    faults = [f"says {word!r}: {_last_line(ended, word)}" for word in ended.crashes()]
    if ended.status != 2:
        faults.append(f"exit status {ended.status}")
    if len(lines) != 1 or not lines[0].startswith("colias: "):
        faults.append(f"{len(lines)} lines on stderr: {_end(ended)}")
    if any(len(line) > LONGEST_LINE for line in lines):
        faults.append(f"a line of {max(map(len, lines))} letters")
    return faults + [f"left a process: {left}" for left in ended.left]
