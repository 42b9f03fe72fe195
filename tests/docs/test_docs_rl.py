"""What docs/how-to/reinforcement-learning.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

import importlib
import sys
from pathlib import Path

import av
import pytest

from dsnn.stimuli import stimulus
from tests.helpers.chapters import chapter, titled

__all__ = ["chapter"]


def test_the_page_runs_as_pasted(chapter):
    pytest.importorskip("imageio_ffmpeg")
    pytest.importorskip("moviepy")
    chapter("how-to/reinforcement-learning.md")
    # A reset and 45 steps, in the size of render().
    with av.open("videos/fixation-episode-0.mp4") as film:
        stream = film.streams.video[0]
        assert (stream.codec_context.name, stream.width, stream.height, stream.average_rate) == ("h264", 480, 360, 30)
        assert len([*film.decode(stream)]) == 46


def test_the_network_in_pytorch_responds_in_its_wrapper(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    torch.manual_seed(0)
    network = torch.nn.ModuleList([torch.nn.GRUCell(24 * 33, 16), torch.nn.Linear(16, 2)])
    torch.save(network.state_dict(), "learned.pt")
    for name in ("learned", "in_torch"):
        Path(f"{name}.py").write_text(titled(f"{name}.py"), encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    learned, in_torch = (importlib.import_module(name) for name in ("learned", "in_torch"))
    learned.network = in_torch.network
    clip = stimulus("plain", rows=72, columns=99, width=16, height=30)
    model = learned.MODEL.build(clip.shape, learned.MODEL.robot)
    first, again = [], []
    for responses in (first, again):
        model.reset()
        responses += [model.step(frame.luma) for frame in clip]
    assert first == again and len({response.hs for response in first}) > 1
