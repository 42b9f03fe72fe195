import ast
import os
import subprocess
import weakref
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from PIL import Image
from PIL.PngImagePlugin import PngInfo
from threadpoolctl import threadpool_limits

from dsnn import DSNNParams

# Rerun reads it as it is imported. What its threads log takes the interpreter's lock, which ending a recording holds.
os.environ["RUST_LOG"] = "error,re_grpc_client=off,re_sdk=off,re_log_encoding=off"
os.environ["COLUMNS"] = "100"  # the consoles are made when the first test imports them, and are the same in every order

ROOT = Path(__file__).parents[1]
GOLDEN = sorted((Path(__file__).parent / "golden").glob("*.npz"))


LONGEST = (
    "test_page", "test_docs", "test_golden", "test_envs", "test_docs_rl",
    "test_models", "test_resume", "test_firmware", "test_viewer", "test_native", "test_reproduce",
    "test_cli", "test_fit", "test_watch", "test_declared_studies", "test_sweep", "test_behaviours",
    "test_onboard",
)  # fmt: skip
"""The files of tests that take longest, the longest first."""


def pytest_xdist_auto_num_workers(config: pytest.Config) -> int:
    """One worker more than there are cores: some tests wait for a browser, a viewer or a process of their own."""
    return min((os.cpu_count() or 1) + 1, 8)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the longest files first: two cores are then busy to the end (with xdist's --no-loadscope-reorder)."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        return  # one process: in the order that was asked for
    place = {name: index for index, name in enumerate(LONGEST)}
    items.sort(key=lambda item: place.get(item.path.stem, len(LONGEST)))


@pytest.fixture(autouse=True, scope="session")
def one_thread() -> Iterator[None]:
    cv2.setNumThreads(1)
    with threadpool_limits(1):
        yield


@pytest.fixture(autouse=True, scope="module")
def blank_figures(request: pytest.FixtureRequest) -> Iterator[None]:
    """Figures are drawn but not rendered, a third of a small run's time, but in modules with ``RENDERED = True``."""
    with pytest.MonkeyPatch.context() as patch:
        if not getattr(request.module, "RENDERED", False):
            patch.setattr(Figure, "savefig", _blank)
            patch.setattr(Figure, "draw_without_rendering", lambda figure: None)
            patch.setattr(ConstrainedLayoutEngine, "execute", lambda engine, figure: None)
        yield


def _blank(figure: Figure, path: Any, *, format: str, metadata: dict[str, str] | None = None, **_: Any) -> None:
    """Write a picture of one pixel, with what is noted of it."""
    if format == "svg":
        path.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="1pt" height="1pt"/>')
        return
    noted = PngInfo()
    for name, value in (metadata or {}).items():
        noted.add_text(name, value)
    Image.new("L", (1, 1)).save(path, format, pnginfo=noted)


@pytest.fixture(params=GOLDEN, ids=lambda path: path.stem)
def golden(request: pytest.FixtureRequest) -> tuple[DSNNParams, dict[str, np.ndarray]]:
    """Parameters and arrays of one golden vector (they came with the project's specification of the network)."""
    with np.load(request.param, allow_pickle=False) as file:
        vector = dict(file)
    return DSNNParams(**ast.literal_eval(str(vector.pop("params")))), vector


def crossing(shape: tuple[int, int] = (72, 99), step: float = 1.5, count: int = 40, dark: bool = True) -> np.ndarray:
    """A 20x24 px object crossing rightward at ``step`` px per frame (sub-pixel), (count, R, C) uint8."""
    rows, columns = shape
    edges = np.arange(columns)
    frames = np.full((count, rows, columns), 240.0 if dark else 20.0)
    for i in range(count):
        left = 5 + step * i
        cover = np.clip(edges + 1 - left, 0, 1) * np.clip(left + 20 - edges, 0, 1)
        band = slice(rows // 2 - 12, rows // 2 + 12)
        frames[i, band] += ((20.0 if dark else 240.0) - frames[i, band]) * cover
    return np.rint(frames).astype(np.uint8)


class Colias:
    """The command line in an empty folder, in this process; the tests of starting and of ending start Python itself.

    Unless the arguments say how many workers there are, its jobs run in this process too.
    """

    PLAYING = ("run", "sweep", "tune", "leaderboard", "reproduce", "behave")
    """Commands whose jobs workers may do."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __call__(self, *arguments: str) -> subprocess.CompletedProcess[str]:
        from tests.helpers.inside import inside

        if arguments[:1] and arguments[0] in self.PLAYING and not {"--workers", "--cluster", "--help"} & {*arguments}:
            arguments = (*arguments, "--workers", "0")
        return inside(self.folder, arguments)


@pytest.fixture
def colias(tmp_path: Path) -> Colias:
    return Colias(tmp_path)


@pytest.fixture
def contexts(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[weakref.ref[Any]]]:
    """Every OpenGL context that is made; all are gone in the end."""
    from colias_sim.offscreen import _Surface

    surfaces: list[weakref.ref[Any]] = []
    start = _Surface.__init__

    def init(self: _Surface, *arguments: Any) -> None:
        start(self, *arguments)
        surfaces.append(weakref.ref(self))

    monkeypatch.setattr(_Surface, "__init__", init)
    yield surfaces
    assert not any(one() for one in surfaces), "left open"
