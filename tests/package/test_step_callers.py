"""Who calls a model's ``step``, read from the source: few do, so bad models need be tried once per kind of caller."""

from __future__ import annotations

import ast
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

EXPERIMENTS = Path(__file__).parents[2] / "experiments"
NAME = "step"

OF_MODELS: Mapping[str, frozenset[str]] = {
    "bench/engine/model_runner.py": frozenset({"self._model", "model"}),
    "bench/conformance/laws.py": frozenset({"model"}),
    "bench/conformance/notes.py": frozenset({"model"}),
    "bench/doctor/installed.py": frozenset({"model"}),
    "bench/leaderboard/timing.py": frozenset({"model"}),
    "bench/firmware/check.py": frozenset({"model", "chip"}),
    "bench/firmware/clips.py": frozenset({"model"}),
    "wiring.py": frozenset({"self.inner", "built"}),
}
"""File -> what it calls ``step`` of, where that is a model. The runner serves trials, clips, episodes, footage and
play; the laws and their notes are ``colias check``; doctor, timing, the firmware's check and its choice of
frames have a loop each; the wiring serves envs."""
OF_OTHERS: Mapping[str, frozenset[str]] = {
    "bench/robot/trial.py": frozenset({"sim", "trial"}),
    "bench/live/arena.py": frozenset({"trial"}),
    "bench/live/footage.py": frozenset({"self"}),
    "bench/live/run.py": frozenset({"session"}),
    "bench/doctor/picture.py": frozenset({"simulation"}),
    "bench/conformance/arena_laws.py": frozenset({"simulation"}),
    "bench/closed_loop/episode.py": frozenset({"wrapped", "keep"}),
    "bench/closed_loop/wrapper.py": frozenset({"self.env", "self._keep"}),
    "bench/training/env.py": frozenset({"self.env"}),
    "bench/footage/watch.py": frozenset({"watcher"}),
    "bench/firmware/budget.py": frozenset({"chip"}),
    "bench/firmware/emulated.py": frozenset({"self._chip"}),
    "bench/measured/camera.py": frozenset({"loop"}),
}
"""The same of simulations, envs, a watcher, which has a runner, an emulated processor, and a number of that name."""


def receivers(tree: ast.AST) -> frozenset[str]:
    """What an attribute ``step`` is read of, called or handed on; a class's own method of that name is none."""
    expressions = set()
    for node in ast.walk(tree):
        match node:
            case ast.Attribute(attr=attr, value=value) if attr == NAME:
                expressions.add(ast.unparse(value))
            case ast.Call(func=ast.Name(id="getattr"), args=[value, ast.Constant(value=name), *_]) if name == NAME:
                expressions.add(ast.unparse(value))
            case ast.Call(func=ast.Name(id="methodcaller") | ast.Attribute(attr="methodcaller"), args=[named, *_]):
                expressions.add(ast.unparse(named))
    return frozenset(expressions)


def callers(root: Path) -> Mapping[str, frozenset[str]]:
    """File below ``root`` -> the receivers of its calls, of those that have any."""
    names_by_file = {
        path.relative_to(root).as_posix(): receivers(ast.parse(path.read_text(encoding="utf-8")))
        for path in sorted(root.rglob("*.py"))
    }
    return {file: names for file, names in names_by_file.items() if names}


def test_no_other_code_steps_a_model():
    """A new caller is listed here, and gets its bad models in `tests.attack` if it steps them itself."""
    listed: dict[str, frozenset[str]] = defaultdict(frozenset, OF_MODELS)
    for file, names in OF_OTHERS.items():
        listed[file] |= names
    assert callers(EXPERIMENTS) == dict(listed)


def test_a_caller_is_found_however_it_is_written():
    ways = ("net.step(f)", "run(net.step)", "getattr(net, 'step')(f)")
    assert [receivers(ast.parse(way)) for way in ways] == [frozenset({"net"})] * len(ways)
    assert receivers(ast.parse("operator.methodcaller('step', f)(net)")) == {"'step'"}
    assert not receivers(ast.parse("class A:\n    def step(self): ..."))
