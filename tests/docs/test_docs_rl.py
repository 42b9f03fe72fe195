"""Everything that docs/reinforcement-learning.md shows runs as it is pasted; `tests.helpers.chapters` says how."""

import re
import subprocess
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


CALLS = """
import sys
import gymnasium as gym
import numpy as np
import torch

def make():
    env = gym.wrappers.FlattenObservation(gym.make(sys.argv[1]))
    return gym.wrappers.TransformObservation(env, lambda seen: np.clip(seen, -10, 10))

envs = gym.vector.SyncVectorEnv([make], autoreset_mode=gym.vector.AutoresetMode.SAME_STEP)
seen, _ = envs.reset(seed=1)
seen, *_ = envs.step(envs.action_space.sample())
print(__name__, torch.get_num_threads(), seen.shape)
"""
"""How CleanRL's file for continuous actions makes its envs."""


@pytest.mark.parametrize(("env", "shape"), [("mine/Optomotor-v0", 7), ("colias_sim:colias_sim/Optomotor-v0", 72 * 99)])
def test_a_file_that_calls_gymnasium_as_cleanrl_does_runs(env, shape, tmp_path):
    pytest.importorskip("torch")
    (tmp_path / "run_cleanrl.py").write_text(titled("run_cleanrl.py"), encoding="utf-8")
    (tmp_path / "calls.py").write_text(CALLS)
    done = subprocess.run([sys.executable, "run_cleanrl.py", "calls.py", env], cwd=tmp_path, capture_output=True,
                          text=True, check=False)  # fmt: skip
    assert done.stdout == f"__main__ 1 (1, {shape})\n", done.stderr
