"""The page of colias live, visited in Chromium, and what a hostile client can do to it."""

from __future__ import annotations

import importlib.util
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from experiments.bench.cli.main import command
from experiments.bench.engine.errors import UsageError
from experiments.bench.live import run
from experiments.bench.live.arena import ArenaSession
from experiments.bench.live.session import Session
from experiments.bench.robot.trial import forget_simulations
from tests.helpers.browser import CHROMIUM, browser

needs_viser = pytest.mark.skipif(
    importlib.util.find_spec("viser") is None, reason="no viser: run 'sh tools/setup.sh --live'"
)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'")
SOFTWARE_GL = ("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist")
PORT = 8451


@contextmanager
def serving(port: int, make: Callable[[], Session]) -> Iterator[Any]:
    """Serve a page in a thread of its own, in which the session runs; yield the page."""
    from experiments.bench.live.page import Page

    pages: list[Page] = []

    def work() -> None:
        page = Page(make(), run.LOOPBACK, port)
        pages.append(page)
        try:
            run.serve(page)
        except SystemExit:
            page.close()
            page.session.close()
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
        pages[0].inputs.ask(leave)
        thread.join()


def dsnn() -> Session:
    return ArenaSession(["dsnn"])


def until(true: Any) -> None:
    end = time.monotonic() + 30.0
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


@needs_viser
@needs_chromium
@pytest.mark.filterwarnings("default")
def test_a_visit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)
    with serving(PORT, dsnn) as page, browser(tmp_path / "profile", *SOFTWARE_GL) as tab:
        seen: list[float] = []
        show = page.show
        page.show = lambda view, rate: (
            seen.append(getattr(next(iter(view.answers.values())), "hs", 0.0)),
            show(view, rate),
        )
        tab.show(page.address)
        tab.until("document.querySelector('canvas') && document.body.innerText.includes('what the camera sees')")
        tab.until("document.querySelector('.u-over') !== null")
        limit = page.session.spec.settings.models[0].threshold
        tab.press("w")
        until(lambda: max(seen) > limit)
        robots = page.session.trial.sim.robots
        until(lambda: robots["stimulus"].pose.y < -0.01)  # past the middle of the view
        tab.press("x")
        until(lambda: abs(seen[-1]) < limit)
        tab.press("s")
        until(lambda: min(seen) < -limit)
        page.inputs.ask(lambda: page.change("dsnn", "t_sp", "0.9"))
        until(lambda: page.session.values)
        tab.press("e")
        until(lambda: list(tmp_path.glob("runs/live-*/summary.csv")) and page.session.trial.seen > 3)
        page.inputs.ask(lambda: page.set_models(["emd", "dsnn"]))
        until(lambda: page.session.models == ("emd", "dsnn"))
        tab.until("document.body.innerText.includes('emd HS')")
        tab.press(" ")
        until(lambda: page.paused)
    (folder,) = tmp_path.glob("runs/live-*")
    again = tmp_path / "again"
    assert command(["rerun", str(folder), "--out", str(again), "--workers", "0", "-q"]) == 0


@needs_viser
@pytest.mark.filterwarnings("default")
def test_malformed_messages_change_nothing():
    import msgspec
    from viser import _messages
    from websockets.exceptions import ConnectionClosed
    from websockets.sync.client import connect

    with serving(PORT + 1, dsnn) as page:
        page.inputs.ask(lambda: page.session.drive("stimulus", 1.0))
        until(lambda: page.session.trial.seen > 5)
        trial, models, settings = page.session.trial, page.session.models, dict(page.session.settings)
        sliders = [*page._sliders.values()]
        wrong = [
            *(_messages.GuiUpdateMessage(handle._impl.uuid, {"value": value})
              for handle in sliders[:8] for value in (1e300, float("nan"), -1e9)),
            _messages.GuiUpdateMessage("no such control", {"value": 1.0}),
            _messages.GuiUpdateMessage(sliders[0]._impl.uuid, {"no_such": 1.0}),
        ]  # fmt: skip
        garbage = [b"", b"\xff\xfe", b"not a message", "text", b"\x00" * 1000]
        sent = [*garbage, *(msgspec.msgpack.encode(message.as_serializable_dict()) for message in wrong)]
        import viser

        protocol = [f"viser-v{viser.__version__}"]
        for message in sent:
            with connect(f"ws://{run.LOOPBACK}:{PORT + 1}", subprotocols=protocol, max_size=None) as client:  # type: ignore[arg-type]
                try:
                    client.send(message)
                    client.recv(timeout=0.1)
                except (ConnectionClosed, TimeoutError):
                    pass
        for handle in [slider for slider in sliders[8:] if isinstance(slider.value, float)][:3]:
            accepted = handle.value
            handle.value = 1e300
            until(lambda handle=handle, accepted=accepted: handle.value == accepted)
        frame = page.session.trial.seen
        until(lambda: page.session.trial.seen > frame + 5)  # it goes on
        assert (page.session.trial, page.session.models, page.session.settings) == (trial, models, settings)
        assert not page.session.values
        assert "legal is" in page._note.content, "none of them came through"
        assert [c.speed_cm_s for c in page.session.hand().commands] == [8.0]


def test_without_viser_one_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    find = importlib.util.find_spec
    monkeypatch.setattr(importlib.util, "find_spec", lambda name, *rest: None if name == "viser" else find(name, *rest))
    with pytest.raises(UsageError, match=r"needs viser, which is not installed: run 'sh tools/setup.sh --live'"):
        run.require_viser()


def test_only_this_machine_is_no_reason_for_a_warning():
    assert run.check_host("127.0.0.1", PORT + 2) == ""
    assert "nothing protects it" in run.check_host("0.0.0.0", PORT + 2)
    with pytest.raises(UsageError, match="--host nowhere"):
        run.check_host("nowhere", PORT + 2)
