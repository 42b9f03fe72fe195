"""The walk from a step of the simulation to a claim's word in the report, traced by ``python -m tools.walk``.

A trial of the paper's speed tests becomes, one after the other, the values of `VALUES`. For the first of each this
tells which function made it, and through which others it was returned. docs/architecture.md prints what it tells.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

ROOT = Path(__file__).parents[1]
PACKAGES = ("colias_sim", "dsnn", "experiments")
VALUES: Mapping[str, str] = {
    "Frame": "what the camera saw after a step of the simulation",
    "Response": "what a model answers to it",
    "ResponseSeries": "the answers of a trial",
    "TrialResult": "the trial: its frames, poses and answers",
    "TrialRecord": "its rows",
    "Check": "what the claim asks, with its reading, its bound and its slack",
    "Outcome": "what the claim comes to in a replicate",
    "Verdict": "what it comes to over all replicates, with its count and word",
    "Tile": "the word as the report shows it",
}
"""Name of a class -> what a value of it is, in the order in which they are made."""


@dataclass(frozen=True, slots=True)
class Place:
    """A function of the project, and its file."""

    file: str
    function: str


class Trace:
    """Notes, while it is the profiler of this process, who returns the first value of each class.

    Attributes
    ----------
    ways
        Name of a class of `VALUES` -> the functions that returned its first value: who made it, then who passed it on.
    """

    def __init__(self) -> None:
        self.ways: dict[str, list[Place]] = {}
        self._values: dict[str, object] = {}
        self._files: dict[CodeType, str] = {}

    def __call__(self, frame: FrameType, event: str, value: Any) -> None:
        """Take one event of the profiler."""
        name = type(value).__name__
        if event != "return" or name not in VALUES or not self._begun(name):
            return
        path, function = self._file(frame.f_code), frame.f_code.co_qualname
        if not path or "<" in function.rpartition(".")[2]:
            return
        if name not in self.ways:
            self.ways[name], self._values[name] = [], value
        if self._values[name] is value and Place(path, function) not in self.ways[name]:
            self.ways[name].append(Place(path, function))

    def _begun(self, name: str) -> bool:
        """Return whether a value of the class before has been made: others are of an earlier part of the program."""
        names = list(VALUES)
        place = names.index(name)
        return not place or names[place - 1] in self.ways

    def _file(self, code: CodeType) -> str:
        """Return the file of a function below the repository; empty of one that is not ours."""
        if code not in self._files:
            path = Path(code.co_filename)
            inside = path.is_relative_to(ROOT) and path.relative_to(ROOT).parts[0] in PACKAGES
            self._files[code] = path.relative_to(ROOT).as_posix() if inside else ""
        return self._files[code]


def walked() -> dict[str, list[Place]]:
    """Run trials of the speed tests in this process, judge C15 on them, and return the way of its values."""
    import experiments
    from experiments.bench.reproduction.page.overview import tile

    trace = Trace()
    with tempfile.TemporaryDirectory() as folder:
        sys.setprofile(trace)
        try:
            run = experiments.run(
                "speed", repeats=4, workers=0, out=f"{folder}/run", recordings=False, quiet=True,
                settings={"experiment.speeds_cm_s": [2, 4, 6, 10]},
            )  # fmt: skip
            for verdict in run._verdicts:
                if verdict.id == "C15":
                    tile(verdict)
        finally:
            sys.setprofile(None)
    return trace.ways


def table(ways: Mapping[str, list[Place]]) -> str:
    """Return the ways as a table in Markdown."""
    lines = ["| value | is made in | is passed on by |", "|---|---|---|"]
    for name, (maker, *others) in ways.items():
        passed = ", ".join(f"`{place.file}` ({place.function})" for place in others)
        lines.append(f"| {VALUES[name]} (`{name}`) | `{maker.file}` ({maker.function}) | {passed} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(walked()))
