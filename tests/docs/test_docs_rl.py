"""Everything that docs/reinforcement-learning.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

import re
import sys
from pathlib import Path

import pytest

from tests.helpers.chapters import chapter, titled
from tests.helpers.h264 import decoded, report

__all__ = ["chapter"]


def test_the_chapter_runs_as_pasted(chapter):
    pytest.importorskip("imageio_ffmpeg")
    pytest.importorskip("moviepy")
    chapter("reinforcement-learning.md")
    # A reset and 45 steps, in the size of render().
    film = Path("videos/fixation-episode-0.mp4")
    assert len(decoded(film)) == 46 and re.search(r"Video: h264 .* 480x360.* 30 fps", report(film))


def test_the_agent_in_pytorch_learns_too(tmp_path, monkeypatch):
    pytest.importorskip("torch")
    monkeypatch.syspath_prepend(tmp_path)
    for name in ("cleanrl_style", "cleanrl_torch"):
        Path(tmp_path / f"{name}.py").write_text(titled(f"{name}.py"), encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    import cleanrl_style
    import cleanrl_torch

    scores = cleanrl_style.train(cleanrl_torch.TorchAgent, ["--updates", "4"])
    assert scores[-1] > scores[0] + 0.2
