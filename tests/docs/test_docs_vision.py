"""The example of docs/how-to/vision-or-not.md that needs flyvis, on an untrained network."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest

from dsnn.stimuli import stimulus
from tests.helpers.chapters import titled


def test_a_fly_s_network_responds_before_the_robot_s_eye(tmp_path, monkeypatch):
    pytest.importorskip("flyvis")
    monkeypatch.syspath_prepend(tmp_path)
    Path(tmp_path / "fly_eye.py").write_text(titled("fly_eye.py"), encoding="utf-8")
    monkeypatch.delitem(sys.modules, "fly_eye", raising=False)
    entry = importlib.import_module("fly_eye").MODEL
    clip = [frame.luma for frame in stimulus("plain", rows=72, columns=99, width=16, height=30)][:20]
    model = entry.build((72, 99), entry.robot)
    first, again = model.run(clip), model.run(clip)
    np.testing.assert_array_equal(first.hs, again.hs)
    assert np.isfinite(first.vs).all() and np.ptp(first.hs[10:]) > 0.0
