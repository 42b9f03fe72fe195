"""The viewer as a page, in Chromium: a test that needs a processor of its own, as Rerun draws without a GPU."""

import base64

import cv2
import numpy as np
import pytest

import experiments
from tests.helpers.browser import CHROMIUM, SOFTWARE_GL, browser
from tests.helpers.processes import CLI, start, wait_until
from tests.site import SITE

pytestmark = [
    pytest.mark.site,
    pytest.mark.skipif(CHROMIUM is None, reason="no chromium: on Debian run 'apt-get install chromium'"),
]
GROUND = (250, 250, 247)
"""Colour below the models' lanes, which Rerun's own grid has nowhere."""


def test_a_browser_shows_the_designed_page(tmp_path):
    """A sixth of it is the ground of the lanes."""
    run = experiments.watch("plain", out=tmp_path / "run", quiet=True)
    with start(tmp_path, *CLI, "view", str(run.recordings[0]), "--web", PYTHONPATH=str(SITE.parents[1])) as viewing:
        address = viewing.stdout.readline().split()[0]
        with browser(tmp_path / "profile", *SOFTWARE_GL) as tab:
            tab.show(address, 700, 420)
            tab.until("document.querySelector('canvas') != undefined")

            def ground() -> float:
                png = np.frombuffer(base64.b64decode(tab.call("Page.captureScreenshot")["data"]), np.uint8)
                return float((cv2.imdecode(png, cv2.IMREAD_COLOR_RGB) == GROUND).all(axis=2).mean())

            assert wait_until(lambda: ground() > 0.1, 120), ground()
        viewing.terminate()
