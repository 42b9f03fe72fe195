"""Mutants: small changes of the source, each of which a test should notice.

``python -m tools.mutants run`` applies the drawn mutants one after another to a throw-away copy of this checkout, runs
the tests that are nearest to each, and reports which were killed, survived, or are gone because their statement is.
``python -m tools.mutants draw`` draws them anew, by a fixed seed; the list in ``mutants.json`` was drawn once, so that
two revisions are held to the same mutants. A mutant is named by its function, its statement and its place in that
statement. It is found again after its file was moved or renamed.

The working tree is not touched.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
LIST = Path(__file__).with_suffix(".json")
PACKAGES = ("dsnn", "colias_sim", "experiments")
SEED, COUNT = 26, 100
MODULES = 8
"""Test modules that a mutant is given."""
LIMIT_S = 600.0
"""What these may take together before it is said to hang."""
FAILED = Path(".pytest_cache", "v", "cache", "lastfailed")
"""Pytest's record of the tests that failed, in the folder where it ran."""


@dataclass(frozen=True)
class Area:
    """A part of the source that mutants are drawn from, and the folders and files with the tests of it."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]


AREAS: Mapping[str, Area] = {
    "network": Area(
        ("dsnn/*.py", "dsnn/direction/*.py", "dsnn/looming/*.py", "dsnn/onboard/*.py"),
        ("tests/dsnn", "tests/dsnn/test_network.py", "tests/bench/robot/test_trial.py"),
    ),
    "camera": Area(
        tuple(f"colias_sim/{name}.py" for name in ("camera", "exposure", "sensor", "simulation", "lens", "noise")),
        ("tests/colias_sim", "tests/colias_sim/test_camera.py", "tests/colias_sim/test_eye.py",
         "tests/bench/robot/test_trial.py"),
    ),
    "envs": Area(("colias_sim/envs/*.py",), ("tests/colias_sim/envs", "tests/colias_sim/envs/test_envs_physics.py")),
    "judges": Area(
        (
            "experiments/claims/c*.py", "experiments/bench/robot/judging.py",
            "experiments/bench/robot/mechanism/[!f]*s.py",
            "experiments/bench/clips/judging.py", "experiments/bench/footage/claims.py",
            "experiments/bench/closed_loop/survival.py",
        ),
        ("tests/bench/robot", "tests/bench/clips", "tests/bench/closed_loop", "tests/bench/footage",
         "tests/bench/judging", "tests/bench/studies", "tests/bench/robot/test_judges.py",
         "tests/bench/clips/test_clip_judges.py"),
    ),
    "statistics": Area(
        tuple(
            f"experiments/bench/judging/{name}.py"
            for name in ("statistics", "count", "scores", "checks", "verdict", "numbers")
        ),
        ("tests/bench/judging", "tests/bench/robot", "tests/bench/report/test_report.py"),
    ),
    "store": Area(("experiments/bench/store/*.py",), ("tests/bench/store", "tests/bench/public")),
}  # fmt: skip

OTHER_COMPARISON = {
    ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt, ast.Eq: ast.NotEq, ast.NotEq: ast.Eq,
    ast.In: ast.NotIn, ast.NotIn: ast.In, ast.Is: ast.IsNot, ast.IsNot: ast.Is,
}  # fmt: skip
OTHER_OPERATOR = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}
OTHER_LOGIC = {ast.And: ast.Or, ast.Or: ast.And}
BODIES = ("body", "orelse", "finalbody", "handlers", "cases")


@dataclass(frozen=True)
class Mutant:
    """One change of one node, by what it is found again: all but ``area``, ``path`` and ``why``."""

    area: str
    path: str
    """The file at the time of drawing."""
    function: str
    statement: str
    """The statement as `ast.unparse` writes it; of a compound statement its head."""
    kind: str
    place: int
    """Index among the statement's nodes of this kind."""
    occurrence: int
    """Index among the function's statements of this text."""
    after: str
    """Text that stands in the node's place."""
    why: str = ""
    """Why no test can notice it, or where its statement went; empty of one that a test has to notice."""

    @property
    def key(self) -> tuple[str, str, str, int, int]:
        """Return what is the same wherever the function stands."""
        return self.function, self.statement, self.kind, self.place, self.occurrence


@dataclass(frozen=True)
class Site:
    """A mutant where it can be applied."""

    mutant: Mutant
    path: Path
    line: int
    start: int
    end: int

    def apply(self, source: bytes) -> bytes:
        """Return the file's text with the change."""
        return source[: self.start] + self.mutant.after.encode() + source[self.end :]


@dataclass(frozen=True)
class Result:
    """Fate of a mutant."""

    mutant: Mutant
    where: str
    """File and line; empty where it is gone."""
    outcome: str
    """``killed``, ``timed out``, ``survived`` or ``gone``."""
    by: str = ""
    """The first test that failed."""
    tests: tuple[str, ...] = ()
    """The test modules that it was given."""
    seconds: float = 0.0


def _head(statement: ast.stmt) -> ast.stmt:
    """Return a compound statement without its bodies."""
    fields = {name: value for name, value in ast.iter_fields(statement) if name not in BODIES}
    bodies: dict[str, list[ast.stmt]] = {name: [] for name in BODIES if hasattr(statement, name)}
    return ast.copy_location(type(statement)(**fields, **bodies), statement)


def _nodes(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the nodes of a statement's own expressions; texts with values in them and annotations are left out."""
    if isinstance(node, ast.JoinedStr):
        return
    yield node
    for name, value in ast.iter_fields(node):
        if name in (*BODIES, "annotation") and isinstance(node, ast.stmt):
            continue
        for child in value if isinstance(value, list) else [value]:
            if isinstance(child, ast.AST):
                yield from _nodes(child)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))


def _change(node: ast.AST) -> tuple[str, str] | None:
    """Return the kind of a node's one small change, and the changed text; None where it has none."""
    match node:
        case ast.Compare(left, [op], comparators) if type(op) in OTHER_COMPARISON:
            return "comparison", ast.unparse(ast.Compare(left, [OTHER_COMPARISON[type(op)]()], comparators))
        case ast.BinOp(left, op, right) if type(op) in OTHER_OPERATOR and not (_is_text(left) or _is_text(right)):
            return "operator", ast.unparse(ast.BinOp(left, OTHER_OPERATOR[type(op)](), right))
        case ast.Constant(bool(value)):
            return "boolean", str(not value)
        case ast.Constant(int(value) | float(value)):
            return "constant", repr(value + 1)
        case ast.BoolOp(op, values):
            return "logic", ast.unparse(ast.BoolOp(OTHER_LOGIC[type(op)](), values))
        case ast.UnaryOp(ast.Not(), operand):
            return "logic", ast.unparse(operand)
        case ast.Return(value) if value is not None and not (isinstance(value, ast.Constant) and value.value is None):
            return "return", "return None"
        case ast.Expr(ast.Call()) | ast.AugAssign() | ast.Raise():
            return "dropped", "pass"
        case ast.Assign([ast.Attribute() | ast.Subscript()]):
            return "dropped", "pass"
    return None


def sites(area: str, path: Path, root: Path = ROOT) -> Iterator[Site]:
    """Yield every mutant of a file.

    Parameters
    ----------
    area
        One of `AREAS`, or empty.
    path
        A Python source.
    root
        What its path is told from.

    Yields
    ------
    Site
        In the order of the source.
    """
    source = path.read_bytes()
    lines = [0]
    for line in source.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    occurrences: Counter[tuple[str, str]] = Counter()

    def of(body: Sequence[ast.AST], function: str) -> Iterator[Site]:
        for statement in body:
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                yield from of(statement.body, f"{function}.{statement.name}".lstrip("."))
                continue
            if isinstance(statement, ast.stmt) and not isinstance(statement, ast.Import | ast.ImportFrom):
                yield from here(statement, function)
            for name in BODIES:
                yield from of(getattr(statement, name, []), function)

    def here(statement: ast.stmt, function: str) -> Iterator[Site]:
        text = ast.unparse(_head(statement))
        occurrence = occurrences[function, text]
        occurrences[function, text] += 1
        places: Counter[str] = Counter()
        for node in _nodes(statement):
            change = _change(node)
            if change is None:
                continue
            kind, after = change
            start = lines[node.lineno - 1] + node.col_offset  # type: ignore[attr-defined]
            end = lines[node.end_lineno - 1] + node.end_col_offset  # type: ignore[attr-defined]
            after = after if isinstance(node, ast.stmt) else f"({after})"
            mutant = Mutant(
                area, path.relative_to(root).as_posix(), function, text, kind, places[kind], occurrence, after
            )
            places[kind] += 1
            yield Site(mutant, path, node.lineno, start, end)  # type: ignore[attr-defined]

    yield from of(ast.parse(source).body, "")


def draw() -> list[Mutant]:
    """Draw the mutants: as many of each area as of the others, and of each kind as of the others as far as they go."""
    rng = random.Random(SEED)
    pools: dict[str, dict[str, list[Mutant]]] = {}
    for name, area in AREAS.items():
        paths = sorted(path for pattern in area.sources for path in ROOT.glob(pattern))
        for path in paths:
            for site in sites(name, path):
                pools.setdefault(name, {}).setdefault(site.mutant.kind, []).append(site.mutant)
    drawn: list[Mutant] = []
    while len(drawn) < COUNT:
        pool = pools[list(AREAS)[len(drawn) % len(AREAS)]]
        kind = rng.choice(sorted(kind for kind, mutants in pool.items() if mutants))
        drawn.append(pool[kind].pop(rng.randrange(len(pool[kind]))))
    return drawn


def shape(statement: str) -> str:
    """Return a statement's text with its names numbered: the same for one whose variables were renamed."""
    numbers: dict[str, str] = {}
    try:
        tree = ast.parse(statement if not statement.endswith(":") else f"{statement}\n    pass")
    except SyntaxError:
        return statement
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            node.id = numbers.setdefault(node.id, f"_{len(numbers)}")
    return ast.unparse(tree)


def find(mutants: Sequence[Mutant], root: Path) -> list[Site | None]:
    """Find each mutant in a checkout.

    Parameters
    ----------
    mutants
        As they were drawn.
    root
        A checkout.

    Returns
    -------
    list of Site or None
        By its function; else by a statement of this text, or with other names, that stands only once in its area's
        sources; else None.
    """
    by_key: dict[tuple[str, str, str, int, int], list[Site]] = {}
    by_statement: dict[tuple[str, str, int], list[Site]] = {}
    by_shape: dict[tuple[str, str, int], list[Site]] = {}
    for package in PACKAGES:
        for path in sorted((root / package).rglob("*.py")):
            for site in sites("", path, root):
                by_key.setdefault(site.mutant.key, []).append(site)
                key = site.mutant.statement, site.mutant.kind, site.mutant.place
                by_statement.setdefault(key, []).append(site)
                by_shape.setdefault((shape(key[0]), *key[1:]), []).append(site)

    def one(mutant: Mutant) -> Site | None:
        exact = by_key.get(mutant.key, [])
        same = [site for site in exact if site.mutant.path == mutant.path]
        if same or exact:
            return (same or exact)[0]
        for statement, table in ((mutant.statement, by_statement), (shape(mutant.statement), by_shape)):
            alike = table.get((statement, mutant.kind, mutant.place), [])
            name = mutant.function.rpartition(".")[2]
            alike = [site for site in alike if any(site.path.match(source) for source in AREAS[mutant.area].sources)]
            alike = [site for site in alike if site.mutant.function.rpartition(".")[2] == name] or alike
            if len(alike) == 1:
                return alike[0]
        return None

    return [one(mutant) for mutant in mutants]


def copy(target: Path) -> None:
    """Copy the checkout's files, as they are, without what git does not keep."""
    names = subprocess.run(
        ["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True,
        text=True,
    ).stdout.splitlines()  # fmt: skip
    for name in names:
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)
    # By their digests: a changed source is then compiled anew, whatever its time.
    subprocess.run(
        [sys.executable, "-m", "compileall", "-q", "--invalidation-mode", "checked-hash", *PACKAGES], cwd=target,
        check=True,
    )  # fmt: skip


def pytest(folder: Path, arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Run pytest in the copy, in one process, and end all that it started."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-m", "pytest", "-q", "--cache-clear", *arguments]
    with subprocess.Popen(
        command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        start_new_session=True,
    ) as process:  # fmt: skip
        try:
            output, _ = process.communicate(timeout=LIMIT_S)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            raise
        return subprocess.CompletedProcess(command, process.returncode, output, "")


def nearest(site: Site, folder: Path, tests: Sequence[str]) -> list[str]:
    """Return the test modules that name a mutant's module, class and function, those that fewest name before others.

    First come those whose file has the module's name in its own. The files that an area names are among them, as they
    test what no test calls by its name.
    """
    places = [folder / test for test in tests]
    modules = sorted(path for place in places for path in ([place] if place.is_file() else place.rglob("test_*.py")))
    texts = {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in modules}
    names = {site.path.stem, *(name for name in site.mutant.function.split(".") if name and not name.startswith("__"))}
    naming = {name: [test for test, text in texts.items() if re.search(rf"\b{name}\b", text)] for name in names}
    scores: Counter[str] = Counter({test: 0 for test in texts})
    for naming_tests in naming.values():
        for test in naming_tests:
            scores[test] += 1 / len(naming_tests)
    for test in texts:
        scores[test] += 2 * bool(re.search(rf"_{site.path.stem}(_|$)", Path(test).stem)) + (test in tests)
    return sorted(texts, key=lambda test: -scores[test])[:MODULES]


def first_failure(folder: Path) -> str:
    """Return the id of the test that failed in the last run of `pytest`, or of the module that could not be imported.

    It is read from pytest's own record, as an id in the printed summary ends where nobody can tell: it may have spaces.
    """
    record = folder / FAILED
    return next(iter(json.loads(record.read_text(encoding="utf-8")))) if record.exists() else ""


def judge(site: Site | None, mutant: Mutant, folder: Path, failing: list[str]) -> Result:
    """Apply a mutant, run its tests, take it back. A test that fails without it too is added to ``failing``."""
    if site is None:
        return Result(mutant, "", "gone")
    tests = nearest(site, folder, [test for test in AREAS[mutant.area].tests if (folder / test).exists()])
    where = f"{site.path.relative_to(folder).as_posix()}:{site.line}"
    source, begin, by, outcome = site.path.read_bytes(), time.monotonic(), "", ""
    while not outcome:
        site.path.write_bytes(site.apply(source))
        try:
            done = pytest(folder, ["-x", "--tb=no", *(f"--deselect={test}" for test in failing), *tests])
            by = first_failure(folder)
            outcome = "survived" if done.returncode == 0 else "killed"
        except subprocess.TimeoutExpired:
            outcome = "timed out"
        finally:
            site.path.write_bytes(source)
        if outcome == "killed" and by not in failing and "::" in by and pytest(folder, [by]).returncode:
            failing.append(by)
            outcome = ""
    return Result(mutant, where, outcome, by[:200], tuple(tests), round(time.monotonic() - begin, 1))


def run(out: Path, areas: Sequence[str], only: Sequence[int]) -> list[Result]:
    """Judge the drawn mutants of the areas, and write what became of each as it is known.

    Parameters
    ----------
    out
        The JSON file that is written after each mutant.
    areas
        Of `AREAS`.
    only
        Numbers of mutants, from 1; empty for all.

    Returns
    -------
    list of Result
        In the order of the list.
    """
    mutants = [Mutant(**item) for item in json.loads(LIST.read_text())]
    results: list[Result] = []
    with tempfile.TemporaryDirectory(prefix="mutants-") as name:
        folder = Path(name)
        copy(folder)
        places = find(mutants, folder)
        failing: list[str] = []
        for number, (mutant, site) in enumerate(zip(mutants, places, strict=True), 1):
            if mutant.area not in areas or (only and number not in only):
                continue
            result = judge(site, mutant, folder, failing)
            results.append(result)
            where = result.where or f"was {mutant.path}"
            print(f"{number:3} {mutant.area:10} {result.outcome:9} {result.seconds:5.0f} s  {mutant.kind:10} {where}  "
                  f"{mutant.function}: {result.by or mutant.why}", flush=True)  # fmt: skip
            out.write_text(json.dumps([asdict(result) for result in results], indent=1) + "\n")
        print(f"fail without a mutant too, and were left out: {', '.join(failing) or 'none'}")
    return results


def main() -> None:
    """Draw or run the mutants."""
    parser = argparse.ArgumentParser(description="Small changes of the source, which tests should notice.")
    parser.add_argument("do", choices=("draw", "run"))
    parser.add_argument("--out", type=Path, default=Path("mutants-results.json"), help="what became of each, as JSON")
    parser.add_argument("--area", action="append", choices=list(AREAS), help="mutants of this area alone; repeatable")
    parser.add_argument("--only", action="append", type=int, default=[], help="this mutant alone, by its number")
    options = parser.parse_args()
    if options.do == "draw":
        LIST.write_text(json.dumps([asdict(mutant) for mutant in draw()], indent=1) + "\n")
        return
    results = run(options.out, options.area or list(AREAS), options.only)
    counts = Counter((result.mutant.area, result.outcome) for result in results)
    outcomes = ("killed", "timed out", "survived", "gone")
    print(f"{'':12}" + "".join(f"{outcome:>11}" for outcome in outcomes))
    for area in AREAS:
        print(f"{area:12}" + "".join(f"{counts[area, outcome]:11}" for outcome in outcomes))
    print(f"{'all':12}" + "".join(f"{sum(counts[area, outcome] for area in AREAS):11}" for outcome in outcomes))


if __name__ == "__main__":
    main()
