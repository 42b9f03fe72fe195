"""The page of colias live, visited in Chromium, and what a hostile client can do to it."""

import importlib.util
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from experiments.live.session import Session
from experiments.show.robot import forget_simulations
from tests.helpers.arenas import written
from tests.helpers.browser import CHROMIUM, PATIENCE_S, SOFTWARE_GL, Tab, browser

needs_viser = pytest.mark.skipif(
    importlib.util.find_spec("viser") is None, reason="no viser: run 'sh tools/setup.sh --live'"
)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'")
PORT = 8451


@contextmanager
def serving(port: int, make: Callable[[], Any]) -> Iterator[Any]:
    """Serve a page in a thread of its own, in which the session runs; yield the page."""
    from experiments.live.page import Page

    pages: list[Page] = []

    def work() -> None:
        page = Page(make(), port=port)
        pages.append(page)
        try:
            page.serve()
        except SystemExit:
            page.server.stop()
        finally:
            forget_simulations()  # which are of this thread

    def leave() -> None:
        raise SystemExit

    thread = threading.Thread(target=work)
    thread.start()
    while not pages:
        assert thread.is_alive()
        time.sleep(0.05)
    try:
        yield pages[0]
    finally:
        pages[0].enqueue(leave)
        thread.join()


def until(true: Any, otherwise: str = "") -> None:
    end = time.monotonic() + PATIENCE_S
    while not true():
        assert time.monotonic() < end, otherwise
        time.sleep(0.02)


def watch(page: Any) -> list[float]:
    """Return HS of the first model in each frame shown from now on; it grows."""
    answers: list[float] = []
    show = page.show

    def record_and_show(sample: Any) -> None:
        answers.append(getattr(next(iter(page.session.responses.values())), "hs", 0.0))
        show(sample)

    page.show = record_and_show
    return answers


@contextmanager
def visited(profile: Path) -> Iterator[tuple[Any, Tab, list[float]]]:
    """Serve a session and open its page, until its plots are drawn."""
    with serving(PORT, lambda: Session(["dsnn"])) as page, browser(profile, *SOFTWARE_GL) as tab:
        answers = watch(page)
        tab.show(f"http://127.0.0.1:{page.server.get_port()}", 800, 600)
        tab.until("document.querySelectorAll('.u-over').length == 2")
        until(lambda: page.server.get_clients())
        yield page, tab, answers


@needs_viser
@needs_chromium
@pytest.mark.filterwarnings("default")
def test_a_visit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    with visited(tmp_path / "profile") as (page, tab, answers):
        assert "Make it fire: press" in tab.ask("document.body.innerText")
        session = page.session
        limit = session.runners[0].chosen.threshold
        (client,) = page.server.get_clients().values()
        start = pytest.approx(page.server.initial_camera.position)
        until(lambda: client.camera.position == start)  # it is elsewhere until the browser has drawn
        tab.press("i")
        until(lambda: max(answers) > limit)
        robots = session.trial.sim.robots
        until(lambda: robots["stimulus"].pose.y < -0.01)  # past the middle of the view
        assert client.camera.position == start, "a key moved the view"
        tab.press("x")
        until(lambda: abs(answers[-1]) < limit)
        tab.press("k")
        until(lambda: min(answers) < -limit)
        tab.press("x")
        tab.click("[...document.querySelectorAll('[role=tab]')].find(t => t.innerText == 'Model')")
        thumb = (
            f"[...document.querySelectorAll('[role=slider]')].find(s => s.getAttribute('aria-valuenow') == '{limit}')"
        )
        tab.until(f"{thumb} != undefined")
        tab.ask(f"{thumb}.focus()")
        tab.press("ArrowRight")
        until(lambda: session.settings)
        ((key, text),) = session.settings.items()
        assert key == "dsnn.t_sp" and session.runners[0].chosen.threshold == float(text) > limit
        tab.press("c")
        until(lambda: list(tmp_path.glob("runs/live-*/summary.csv")) and session.trial.number > 3)
        tab.press("J", shift=True)
        until(lambda: session.trial.sim.robots["observer"].pose.heading > 0.3)
        tab.press("X", shift=True)
        until(lambda: session._moves["observer"] == (0.0, 0.0))
        tab.press(" ")
        until(lambda: page.paused)
        frame = session.number
        tab.press("n")
        until(lambda: session.number == frame + 1)


def obstacles(page: Any) -> list[str]:
    """Return the names of what is drawn of the world."""
    return [name for name in page.server.scene._handle_from_node_name if name.startswith("/world/")]


@needs_viser
@pytest.mark.filterwarnings("default")
def test_obstacles_of_every_kind_are_drawn(tmp_path: Path):
    kinds = ("box", "cylinder", "sphere", "capsule", "ellipsoid")
    geoms = "".join(f'<geom type="{kind}" size=".02 .01 .03" pos="0.2 {0.06 * place - 0.12:.2f} 0.05"/>'
                    for place, kind in enumerate(kinds))  # fmt: skip
    mesh = '<asset><mesh name="wedge" vertex="0 0 0 .03 0 0 0 .03 0 0 0 .05"/></asset>'
    arena = written(tmp_path, f'{geoms}<geom type="mesh" mesh="wedge" pos="0.25 0.1 0"/>', mesh)
    with serving(PORT + 7, lambda: Session(["dsnn"], {"scene.arena": str(arena)})) as page:
        until(lambda: page.session.number > 2)
        drawn = obstacles(page)
        assert len(drawn) == len(kinds) + 1 + 2, "the obstacles, the floor and the wall"
        page.enqueue(lambda: page.session.set("scene.light", "0.5"))
        until(lambda: page.session.settings.get("scene.light") == "0.5" and page.session.number > 2)
        assert obstacles(page) == drawn
