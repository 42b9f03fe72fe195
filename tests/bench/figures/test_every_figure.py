"""Every figure of the bench, from fixed rows, with one model, three, twenty, and one of a user's own."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib.figure import Figure

from experiments.bench.figures.plotting import PAGE, WIDTH
from tests.helpers import figure_checks as checks
from tests.helpers import figure_references as references
from tests.helpers.figure_list import FIGURES, OF_ONE_MODEL, shown
from tests.helpers.figure_rows import MODELS_SHOWN

mpl.use("agg")
SLOW = ("background", "robot, words", "behaviours, one episode", "tuning, size", "tuning, contrast")
"""Not drawn with twenty models: others are, which are laid out by the same function."""
CASES = [
    (name, count) for name in FIGURES for count in MODELS_SHOWN
    if count == "one" or (name not in OF_ONE_MODEL and not (count == "twenty" and name in SLOW))
]  # fmt: skip


FRAMES_OF_FILMS = ("video",)
"""Not figures of a page: `colias video` says how many pixels they have."""


def inches(figure: Figure) -> float:
    return float(figure.get_size_inches()[0])


@pytest.fixture(scope="module")
def ones():
    """Each figure with one model, and the places in the source that made them."""
    reached, initialise = set(), Figure.__init__

    def note(self, *args, **more):
        caller = sys._getframe(1)
        reached.add((caller.f_code.co_filename, caller.f_lineno))
        initialise(self, *args, **more)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Figure, "__init__", note)
        return {name: draw(MODELS_SHOWN["one"]) for name, draw in FIGURES.items()}, reached


@pytest.mark.parametrize(("name", "count"), CASES, ids=lambda label: label)
def test_a_figure_can_be_read(name, count, ones):
    models = MODELS_SHOWN[count]
    figure = ones[0][name] if count == "one" else FIGURES[name](models)
    figure.set_dpi(72)
    drawn_texts = checks.drawn_texts(figure)
    places, texts = [(text.get_text(), box) for text, box in drawn_texts], [text for text, _ in drawn_texts]
    if name not in FRAMES_OF_FILMS:  # on paper none is made smaller to fit: its type would be too
        assert inches(figure) <= WIDTH, "wider than the page of a paper"
        assert figure.get_size_inches()[1] <= PAGE + 1e-9, "taller than the page of a paper"
    faults = {
        "type that is too small in print": checks.small(texts, 1.0),
        "thresholds that look alike": checks.alike_levels(figure),
        "faint type": checks.faint(texts),
        "texts that overlap": checks.overlaps(places),
        "texts that run out of the figure": checks.outside(figure, places),
        "axes without a label": checks.unlabelled(figure),
        "not in the key": checks.missing(figure, places, shown(name, models)),
        "keys that look alike": checks.alike(figure),
        "hidden series": checks.hidden(figure),
        "numbers that stand elsewhere": checks.ordinal(figure),
    }
    assert not {what: where for what, where in faults.items() if where}


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_looks_as_it_did_when_it_was_last_looked_at(name, ones):
    """Where the change is meant: look at the figure, then ``python -m tests.helpers.figure_references``."""
    assert not references.differences(references.cells(ones[0][name]), references.load()[name])


def test_what_is_gone_or_elsewhere_in_a_figure_is_noticed():
    stored = references.load()["robot"]

    def changed(change) -> str:
        figure = FIGURES["robot"](MODELS_SHOWN["one"])
        change(figure)
        return references.differences(references.cells(figure), stored)

    assert not changed(lambda figure: None)
    assert changed(lambda figure: [line.set_visible(False) for line in figure.axes[1].get_lines()])
    assert changed(lambda figure: figure.axes[0].set_ylim(-500, 500))
    assert changed(lambda figure: figure.axes[0].set_visible(False))
    assert changed(lambda figure: figure.set_facecolor("black"))


BENCH = Path(__file__).parents[3] / "experiments" / "bench"


def makers(path: Path) -> list[ast.Call]:
    """The calls of a file that make a matplotlib figure."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    known = {alias.asname or alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
             and node.module == "matplotlib.figure" for alias in node.names if alias.name == "Figure"}  # fmt: skip
    assert not any(
        isinstance(node, ast.alias) and node.name in ("matplotlib.pyplot", "pyplot", "matplotlib.figure")
        for node in ast.walk(tree)
    ), f"{path}: figures are made by matplotlib.figure.Figure, imported by its name"
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    return [call for call in calls if isinstance(call.func, ast.Name) and call.func.id in known]


def test_every_figure_of_the_bench_is_in_the_list(ones):
    """Each place in the source that makes a figure is reached by a figure of the list."""
    _, reached = ones
    places = [(path, call) for path in sorted(BENCH.rglob("*.py")) for call in makers(path)]
    assert places
    assert not [
        f"{path.relative_to(BENCH)}, line {call.lineno}" for path, call in places
        if not any((str(path), line) in reached for line in range(call.lineno, (call.end_lineno or call.lineno) + 1))
    ]  # fmt: skip


SAYS_WHAT_WAS_SET = {
    **dict.fromkeys(("robot", "mechanism", "excitation", "traces", "peaks", "background", "ranges", "contrast", "edges",
                     "tuning, direction", "tuning, l-over-v"),
                    "set: dsnn.n_con=6"),
    "behaviours, paths": "robots=5", "training": "judged under robot=colias4", "maps": "camera.read_noise=0",
}  # fmt: skip


@pytest.mark.parametrize("name", SAYS_WHAT_WAS_SET)
def test_what_was_set_stands_in_the_title(name, ones):
    figure = ones[0][name]
    titles = " ".join(part.get_suptitle() for part in (figure, *figure.subfigs)).replace("\n", " ")
    assert SAYS_WHAT_WAS_SET[name] in titles


# --- the checks see what is wrong -------------------------------------------------------------------------------------


def wrong(**of) -> Figure:
    """A figure of two lines that is well but for what ``of`` changes."""
    figure = Figure(figsize=(4, 3), layout="constrained")
    axes = figure.subplots()
    axes.plot([1, 2, 3], [1, 2, 3], color="red", lw=1, label="one")
    axes.plot([1, 2, 3], of.get("later", [3, 2, 1]), color="blue", lw=1, label="two")
    axes.set(xlabel=of.get("xlabel", "speed (cm/s)"), ylabel="spikes per trial")
    axes.set_xticks([1, 2, 3], of.get("ticks", ["1", "2", "3"]))
    for place, words in enumerate(of.get("said", ())):
        text = axes.annotate(words, (0.1, 0.5 + 0.01 * place), xycoords="axes fraction", annotation_clip=False)
        text.set_in_layout(False)
    figure.legend(loc="outside upper center")
    return figure


def test_the_checks_find_nothing_in_a_figure_that_is_well():
    figure = wrong()
    places = checks.drawn(figure)
    assert not checks.overlaps(places) + checks.outside(figure, places) + checks.missing(figure, places, ["one", "two"])
    assert not checks.unlabelled(figure) + checks.alike(figure) + checks.hidden(figure) + checks.ordinal(figure)


def test_the_checks_find_what_is_wrong():
    crowded = wrong(said=("some words", "others on them"))
    assert checks.overlaps(checks.drawn(crowded)) == ["'some words' on 'others on them'"]
    wide = wrong(said=("words " * 30,))
    assert checks.outside(wide, checks.drawn(wide)) == ["words " * 30]
    assert len(checks.unlabelled(wrong(xlabel=""))) == len(checks.unlabelled(wrong(xlabel="speed"))) == 1
    assert checks.missing(wrong(), checks.drawn(wrong()), ["three"]) == ["three"]
    assert checks.hidden(wrong(later=[1, 2, 3])) == ["one under two in ['', '', '']"]
    assert len(checks.ordinal(wrong(ticks=["1", "2", "9"]))) == 1
    levels = wrong()
    for level in (1.5, -1.5, 2.5):
        levels.axes[0].axhline(level, color="black", ls="--")
    assert checks.alike_levels(levels) == ["1.5 and 2.5 in ['', '', '']"]
    levels.axes[0].get_lines()[-1].set_linestyle("-.")
    assert not checks.alike_levels(levels)
    twice = wrong()
    twice.axes[0].get_lines()[1].set_color("red")
    twice.legends.clear()
    twice.legend()
    assert checks.alike(twice) == ["'two' and 'one'"]
