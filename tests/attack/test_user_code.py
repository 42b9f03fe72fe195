"""Trees of users' files with equal names, edited at random in one process: what runs is what the files hold.

A tree is a folder with a model and helpers that import each other; every helper has a number, and the model answers
with the sum of those that it reaches. So the sum tells which files were executed. It is held against the same sum of
the files' texts, and ``experiment.json`` against their hashes.
"""

from __future__ import annotations

import importlib
import random
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tests.helpers.user_trees import experiment, hashes, model, peaks, run, sha

pytestmark = pytest.mark.attack

NAMES = ("helper", "util", "common", "rich", "config")
FORMS = ("import {name}", "from {name} import NUMBER as of_{name}", "import {name} as other_{name}")


@dataclass
class Tree:
    """A folder: each helper's number, and the names it imports, always of later ones, so that there is no circle."""

    folder: Path
    rng: random.Random
    numbers: dict[str, int] = field(default_factory=dict)
    imports: dict[str, list[str]] = field(default_factory=dict)
    packages: set[str] = field(default_factory=set)

    def write(self) -> None:
        for place, name in enumerate(NAMES):
            later = NAMES[place + 1 :]
            self.numbers[name] = self.rng.randrange(1, 1 << 20)
            self.imports[name] = self.rng.sample(later, self.rng.randint(0, len(later)))
            if self.rng.random() < 0.3:
                self.packages.add(name)
            self.write_helper(name)
        self.imports["mod"] = self.rng.sample(NAMES, self.rng.randint(1, len(NAMES)))
        lines = [f"import {name}" for name in self.imports["mod"]]
        value = f"({' + '.join(f'{name}.TOTAL' for name in self.imports['mod'])}) / 2**26"
        model(self.folder / "mod.py", value, "\n".join(lines))

    def file(self, name: str) -> Path:
        return self.folder / name / "__init__.py" if name in self.packages else self.folder / f"{name}.py"

    def write_helper(self, name: str) -> None:
        self.file(name).parent.mkdir(parents=True, exist_ok=True)
        lines = [self.rng.choice(FORMS).format(name=other) for other in self.imports[name]]
        lines += [f"import {other}" for other in self.imports[name]]
        total = " + ".join(["NUMBER", *(f"{other}.TOTAL" for other in self.imports[name])])
        self.file(name).write_text("\n".join([*lines, f"NUMBER = {self.numbers[name]}", f"TOTAL = {total}", ""]))

    def edit(self) -> None:
        name = self.rng.choice(NAMES)
        self.numbers[name] = self.rng.randrange(1, 1 << 20)
        self.write_helper(name)

    def total(self, name: str = "mod") -> int:
        return self.numbers.get(name, 0) + sum(map(self.total, self.imports[name]))

    def reached(self, name: str = "mod") -> set[Path]:
        path = self.folder / "mod.py" if name == "mod" else self.file(name)
        return {path}.union(*(self.reached(other) for other in self.imports[name]))


def check(trees: list[Tree], file: Path, out: Path, workers: int = 0, beside: tuple[Path, ...] = ()) -> None:
    finished_run = run(file, out, models=[tree.folder / "mod.py" for tree in trees], workers=workers)
    expected = {tree.folder.name: tree.total() / 2**26 for tree in trees}
    assert {name: value for name, value in peaks(finished_run).items() if name in expected} == pytest.approx(
        expected, rel=1e-6
    )
    files = {path for tree in trees for path in tree.reached()} | {file, *beside}
    assert hashes(finished_run) == {str(path): sha(path) for path in files}


@pytest.mark.parametrize("seed", range(12))
def test_trees_of_equal_names_that_are_edited(seed, tmp_path):
    rng = random.Random(seed)
    trees = [Tree(tmp_path / f"v{number}", rng) for number in range(3)]
    for tree in trees:
        tree.write()
    (tmp_path / "helper.py").write_text("CLIP = 'light'\n")
    file = experiment(tmp_path / "mine.py", clip="helper.CLIP", imports="import helper")
    for turn in range(6):
        rng.shuffle(trees)
        check(trees, file, tmp_path / f"out{turn}", beside=(tmp_path / "helper.py",))
        for _ in range(rng.randint(0, 3)):
            rng.choice(trees).edit()


@pytest.mark.parametrize("seed", range(2))
def test_trees_in_workers(seed, tmp_path):
    rng = random.Random(100 + seed)
    trees = [Tree(tmp_path / f"v{number}", rng) for number in range(3)]
    for tree in trees:
        tree.write()
    for turn in range(2):
        check(trees, experiment(tmp_path / "mine.py"), tmp_path / f"out{turn}", workers=2)
        trees[0].edit()


def test_threads_that_run_trees_while_others_import(tmp_path):
    """Each thread edits and runs a tree of its own; another imports modules all the time."""
    troubles: list[BaseException] = []
    ended = threading.Event()
    (tmp_path / "many").mkdir()
    for number in range(3000):
        (tmp_path / "many" / f"colias_attack_{number}.py").write_text("X = 1\n")

    def import_many() -> None:
        for number in range(3000):
            if ended.is_set():
                return
            importlib.import_module(f"colias_attack_{number}")

    def go(place: int) -> None:
        try:
            tree = Tree(tmp_path / f"v{place}", random.Random(place))
            tree.write()
            file = experiment(tmp_path / f"mine{place}.py")
            for turn in range(4):
                check([tree], file, tmp_path / f"out-{place}-{turn}")
                tree.edit()
        except BaseException as error:
            troubles.append(error)

    sys.path.append(str(tmp_path / "many"))
    try:
        threads = [threading.Thread(target=go, args=(place,)) for place in range(4)]
        importer = threading.Thread(target=import_many)
        for thread in (*threads, importer):
            thread.start()
        for thread in threads:
            thread.join()
        ended.set()
        importer.join()
    finally:
        sys.path.remove(str(tmp_path / "many"))
        for name in [name for name in sys.modules if name.startswith("colias_attack_")]:
            del sys.modules[name]
    assert not troubles, troubles
