"""Rerun's viewer without a window: what it shows of a recording, and pictures of its panels."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
import pytest
from rerun.experimental import ViewerClient

from experiments.bench.report import viewer
from experiments.bench.report.viewer import program
from experiments.bench.run.record import TIMELINE

DRIVERS = [*Path("/usr/share/vulkan/icd.d").glob("*lvp*"), *Path("/usr/local/share/vulkan/icd.d").glob("*lvp*")]
needs_vulkan = pytest.mark.skipif(not DRIVERS, reason="no Vulkan: on Debian run 'apt-get install mesa-vulkan-drivers'")
WIDTH, HEIGHT = 1400, 840
PATIENCE_S, PAINTS_S = 300.0, 60.0
"""How long a viewer may take to open or to load, and to paint what it has."""
Picture = npt.NDArray[np.uint8]


class Screen:
    """A viewer that is open."""

    def __init__(self, client: ViewerClient, address: str) -> None:
        self._client, self.address = client, address

    def state(self, count: int = 1) -> Any:
        """Wait until ``count`` recordings are there, whole; return what the viewer shows."""
        end = time.monotonic() + PATIENCE_S
        while True:
            state = self._client.get_state()
            loaded = [recording for recording in state.recordings if recording.timelines]
            if len(loaded) >= count and not state.loading and state.views:
                return state
            assert time.monotonic() < end, state
            time.sleep(0.1)

    def stop_at(self, time_s: float) -> None:
        """Show one moment."""
        self._client.set_time(TIMELINE, duration=time_s, play_state="paused")

    def shows(self, path: Path, wanted: Callable[[Picture], bool], view: Any = None) -> bool:
        """Tell whether a picture of the window, or of one view, (H, W, 3) RGB, becomes what is wanted, in its time."""
        end = time.monotonic() + PAINTS_S
        while not wanted(self.picture(path, view)):
            if time.monotonic() > end:
                return False
            time.sleep(0.1)
        return True

    def picture(self, path: Path, view: Any = None) -> Picture:
        """Return a picture of the window, or of one view, (H, W, 3) RGB."""
        end, view_id = time.monotonic() + PATIENCE_S, None if view is None else view.view_id
        while True:
            try:
                self._client.save_screenshot(str(path), view_id=view_id)
                break
            except TimeoutError:  # Rerun's own patience is short where a busy machine paints without a GPU
                assert time.monotonic() < end, view_id
        image = cv2.imread(str(path))
        assert image is not None, path
        return cv2.cvtColor(image, cv2.COLOR_BGR2RGB).astype(np.uint8)


def wait_for(address: str) -> None:
    """Wait until a viewer or a server listens."""
    end = time.monotonic() + PATIENCE_S
    while not viewer.listens(address):
        assert time.monotonic() < end, f"nothing listens at {address}"
        time.sleep(0.1)


@contextmanager
def listening(*options: str) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """Start Rerun's program with a port of its own; end it when the block is left."""
    address = f"{viewer.HOST}:{viewer.free_port()}"
    command = [*program(), *options, "--bind", viewer.HOST, "--port", address.rpartition(":")[2]]
    quiet = {**os.environ, "RUST_LOG": "off"}
    process = subprocess.Popen(command, env=quiet, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(address)
        yield address, process
    finally:
        process.terminate()
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


@contextmanager
def viewing(*files: Path) -> Iterator[Screen]:
    """Open recordings in a viewer without a window; end it when the block is left."""
    options = ["--headless", "--hide-welcome-screen", "--window-size", f"{WIDTH}x{HEIGHT}"]
    with listening(*map(str, files), *options) as (address, _):
        yield Screen(ViewerClient.connect(viewer.url(address)), address)
