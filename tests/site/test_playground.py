"""The playground as built, in Chromium: its bits, its counts, its word, and all that can be moved."""

import ast
import base64
import dataclasses
import json
import re
from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
import polars as pl
import pytest

import experiments
from dsnn import DSNN, DSNNParams
from experiments.paper.claims.robot import c15
from tests.conftest import GOLDEN, ROOT
from tests.helpers.browser import CHROMIUM, Tab, browser
from tests.site import SITE
from tools.pages import playground

PAGE = SITE / playground.PAGE
RUNS = ROOT / "docs" / "generated" / "playground" / "runs"
pytestmark = pytest.mark.site
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'")
ANSWERS = """async ({ compile, Network }, wasm, tables, cases) => {
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const hex = (view) => Array.from(new Uint8Array(view.buffer, view.byteOffset, view.byteLength),
    (byte) => byte.toString(16).padStart(2, "0")).join("");
  const kernel = await compile(bytes(wasm));
  return cases.map(({ rows, columns, params, film }) => {
    const network = new Network(kernel, tables, { rows, columns }, params);
    const [luma, cells] = [bytes(film), rows * columns];
    let text = "";
    for (let at = 0; at < luma.length; at += cells) text += hex(network.step(luma.subarray(at, at + cells)));
    const { p, la, fOn, fOff } = network.maps();
    text += [p, la, fOn, fOff].map(hex).join("");
    network.free();
    return text;
  });
}"""
"""JavaScript: the answers to cases, and the last maps, as bytes. All cases share the network's memory."""


def embedded(name: str) -> str:
    match = re.search(rf'id="{name}">(.*?)</script>', PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert match, f"{PAGE} has no {name}"
    return match[1]


@pytest.fixture(scope="module")
def data() -> dict[str, Any]:
    return json.loads(embedded("data"))


@pytest.fixture(scope="module")
def cases() -> list[tuple[dict[str, Any], str]]:
    """The golden vectors as the page takes them, and as presets of its levers; the bytes that the C form answers."""
    prepared = []
    for path in GOLDEN:
        with np.load(path, allow_pickle=False) as file:
            frames, params = file["frames"], DSNNParams(**ast.literal_eval(str(file["params"])))
        for chosen in (params, DSNNParams.robot(d=4, n_con=7, dog=False), DSNNParams(d=3, w_i=0.35, tau_s=(85, 105))):
            model = DSNN(frames.shape[1:], chosen, form="native")
            text = b""
            for frame in frames:
                answer = model.step(frame, maps=True)
                spikes = np.array([answer.hs_spikes, answer.vs_spikes], "<i4")
                text += np.array([answer.hs, answer.vs], "<f8").tobytes() + spikes.tobytes()
            layers = (answer.maps.p, answer.maps.la, answer.maps.f_on, answer.maps.f_off)
            text += b"".join(layer.astype("<f4").tobytes() for layer in layers)
            _, rows, columns = frames.shape
            film = base64.b64encode(frames.tobytes()).decode()
            case = {"rows": rows, "columns": columns, "params": dataclasses.asdict(chosen), "film": film}
            prepared.append((case, text.hex()))
    return prepared


@pytest.fixture(scope="module")
def tab(tmp_path_factory) -> Iterator[Tab]:
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        yield opened


def show(tab: Tab, link: str = "", **window: Any) -> None:
    tab.show(f"{PAGE.as_uri()}{'#' * bool(link)}{link}", **window)
    settled(tab)


def settled(tab: Tab) -> None:
    """Wait until nothing is left to compute."""
    tab.until("performance.getEntriesByName('counted').length && document.body.dataset.busy !== 'true'")


def text(tab: Tab, name: str) -> str:
    return tab.ask(f"document.getElementById('{name}').textContent")


def count(tab: Tab) -> int:
    """The spikes of HS that the page tells of the chosen trial."""
    return int(re.search(r"\d+", text(tab, "count"))[0])


def counts(tab: Tab) -> dict[float, int]:
    rows = tab.ask(
        "[...document.querySelectorAll('#speeds tr')].map((row) => [...row.cells].map((c) => c.textContent))"
    )
    return {float(row[0]): int(row[1]) for row in rows}


@needs_chromium
def test_golden_vectors_have_their_bits_in_chromium(tab, cases, data):
    show(tab)
    given = json.dumps([case for case, _ in cases])
    wasm = "document.getElementById('wasm').textContent.trim()"
    tables = json.dumps(data["tables"])
    assert tab.ask(f'import("#network").then((n) => ({ANSWERS})(n, {wasm}, {tables}, {given}))') == [
        t for _, t in cases
    ]


@needs_chromium
def test_the_word_is_that_of_the_claims_judge(tab, data):
    near = np.random.default_rng(0).integers(-3, 4, (300, 4)) + np.array([16, 18, 20, 18])
    speeds = (2.0, 4.0, 6.0, 10.0)
    fixed = dict(motion="translation", distance_cm=8.0, direction="rightward", shell_grey=None, wall_contrast=None,
                 observer_speed_cm_s=0.0, observer_turn_deg_s=0.0)  # fmt: skip
    counted = [[*zip(speeds, map(int, counts), strict=True)] for counts in near]
    expected = [c15([{**fixed, "speed_cm_s": s, "spikes": n} for s, n in each], 0.2).verdict for each in counted]
    assert {"holds", "fails"} == set(expected)
    words = f"{json.dumps(counted)}.map((counts) => judged({json.dumps(data['claim'])}, new Map(counts)).word)"
    show(tab)
    assert tab.ask(f'import("#judging").then(({{ judged }}) => {words})') == expected


@needs_chromium
@pytest.mark.parametrize("phone", [False, True], ids=["desktop", "phone"])
def test_counts_are_those_of_the_runs(tab, data, phone):
    tables = {name: pl.read_parquet(RUNS / name / "trials.parquet").to_dicts() for name in playground.RUNS}
    window = {"width": 390, "height": 844, "phone": True, "dark": True} if phone else {}
    for folder, (command, trials) in playground.RUNS.items():
        spikes = {row["trial"]: row["spikes"] for row in tables[folder]}
        for index, (name, *_) in trials.items():
            show(tab, f"trial={name}", **window)
            assert count(tab) == spikes[index], name
            assert text(tab, "command") == command
    show(tab, **window)
    assert counts(tab) == {row["speed_cm_s"]: row["spikes"] for row in tables["speed"]}
    assert tab.messages == []


@needs_chromium
def test_levers_move_by_the_keyboard_and_a_link_has_them(tab):
    show(tab, "trial=speed-6&frame=30")
    tab.ask("document.getElementById('input-n_con').focus()")
    tab.press("Home")
    tab.until("document.getElementById('command').textContent.endsWith('--set dsnn.n_con=4')")
    settled(tab)
    few, link = count(tab), tab.ask("location.hash")
    assert "n_con=4" in link and "trial=speed-6" in link and "frame=30" in link
    show(tab, link[1:])
    assert (count(tab), text(tab, "value-n_con")) == (few, "4")
    tab.ask("document.getElementById('reset-n_con').focus()")
    tab.press("Enter")
    tab.until("!document.getElementById('command').textContent.includes('n_con')")
    settled(tab)
    assert count(tab) != few and tab.messages == []


@needs_chromium
@pytest.mark.parametrize("trial", ["recession-30", "ov7670-10", "clutter"])
def test_the_command_does_the_same(tab, tmp_path, trial):
    show(tab, f"trial={trial}&w_i=0.5&k_sp=3&tau_s.1=150&fdsr=false")
    given = playground.arguments(text(tab, "command"))
    assert given["settings"].keys() >= {"dsnn.w_i", "dsnn.k_sp", "dsnn.tau_s", "dsnn.fdsr"}
    run = experiments.run(**given, out=tmp_path / "run", recordings=False, quiet=True, workers=0)
    (row,) = run.trials.to_dicts()
    assert row["spikes"] == count(tab) > 0


SLOW_FILMS = """(() => {
  const make = document.createElement.bind(document);
  document.createElement = (name) => Object.assign(make(name), name === "video" ? { defaultPlaybackRate: 0.1 } : {});
})()"""


@needs_chromium
def test_a_video_of_something_that_moves_right_makes_hs_rise(tab, tmp_path):
    """By the file's own button, in a codec that every Chromium has; the answer begins anew when it is recomputed."""
    film = tmp_path / "it's right.webm"
    writer = cv2.VideoWriter(str(film), cv2.VideoWriter.fourcc(*"VP80"), 30, (396, 288))
    assert writer.isOpened()
    for i in range(60):
        picture = np.full((288, 396, 3), 230, np.uint8)
        picture[90:200, max(0, 6 * i - 80) : max(0, 6 * i)] = 20
        writer.write(picture)
    writer.release()
    show(tab)
    tab.ask(SLOW_FILMS)  # or a busy machine leaves out most of its frames
    node = tab.call("Runtime.evaluate", expression="document.getElementById('file')")["result"]["objectId"]
    tab.call("DOM.setFileInputFiles", files=[str(film)], objectId=node)
    tab.until("parseInt(document.getElementById('video').textContent.slice(6)) >= 20")
    tab.until("document.getElementById('video').textContent === 'Open a video'")
    settled(tab)
    assert count(tab) > 0
    assert "rightward" in text(tab, "count")
    rising = "document.getElementById('scrubber').getAttribute('aria-valuetext').match(/HS (.*)/)[1]"
    highest = 0.0
    tab.ask("document.getElementById('scrubber').focus()")
    for _ in range(20):
        tab.press("ArrowLeft")
        highest = max(highest, float(tab.ask(rising)))
    assert highest > 0.16
    assert text(tab, "command").startswith("""colias watch 'it'\\''s right.webm'""")
    assert tab.messages == []


@needs_chromium
def test_nothing_can_leave_the_page(tab):
    show(tab)
    asked = "fetch('http://127.0.0.1:9/').then(() => 'sent', () => 'refused')"
    heard = "addEventListener('securitypolicyviolation', (event) => done(event.violatedDirective))"
    assert tab.ask(f"new Promise((done) => {{ {heard}; {asked} }})") == "connect-src"
