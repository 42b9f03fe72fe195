"""docs/questions/: each page has a snippet, and what it shows runs as it is pasted."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from dsnn.stimuli import stimulus
from tests.helpers.chapters import QUESTIONS, called, chapter, titled

__all__ = ["chapter"]

ANSWERS = tuple(page for page in QUESTIONS if page.name != "index.md")
EXTRAS = {
    "questions/pictures.md": ("imageio_ffmpeg",),
    "questions/record-env.md": ("imageio_ffmpeg", "moviepy"),
}
"""Page -> modules of the extra [video] that it needs."""


@pytest.mark.parametrize("name", [called(page) for page in ANSWERS])
def test_an_answer_runs_as_pasted(name, chapter):
    for module in EXTRAS.get(name, ()):
        pytest.importorskip(module)
    chapter(name)


def test_the_network_in_pytorch_answers_in_its_wrapper(tmp_path, monkeypatch):
    torch = pytest.importorskip("torch")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    torch.manual_seed(0)
    network = torch.nn.ModuleList([torch.nn.GRUCell(24 * 33, 16), torch.nn.Linear(16, 2)])
    torch.save(network.state_dict(), "weights.pt")
    for name in ("learned", "in_torch"):
        Path(f"{name}.py").write_text(titled(f"{name}.py"), encoding="utf-8")
        monkeypatch.delitem(sys.modules, name, raising=False)
    learned, in_torch = (importlib.import_module(name) for name in ("learned", "in_torch"))
    learned.network = in_torch.network
    clip = stimulus("plain", rows=72, columns=99, width=16, height=30)
    model = learned.MODEL.build(clip.shape, learned.MODEL.robot)
    first, again = [], []
    for answers in (first, again):
        model.reset()
        answers += [model.step(frame.luma) for frame in clip]
    assert first == again and len({answer.hs for answer in first}) > 1
