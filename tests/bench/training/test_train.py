"""Trained policies: what a file may hold and what is refused, steering, the command; PPO itself where it is set up."""

import dataclasses
import io
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

from colias_sim import CameraConfig, RobotConfig
from dsnn import Response
from experiments.bench.closed_loop import policy_file
from experiments.bench.closed_loop.find import load_behaviour
from experiments.bench.closed_loop.policy import SENSED, About, Policy
from experiments.bench.closed_loop.steering import Steering
from experiments.bench.run.errors import UsageError

OPTOMOTOR = "colias_sim/Optomotor-v0"
ABOUT = About(OPTOMOTOR, seed=3, steps=512, envs=2, hidden=(5, 4))


def random_policy(about=ABOUT, seed=0):
    rng = np.random.default_rng(seed)
    layers = [(rng.normal(size=shape).astype(np.float32), rng.normal(size=shape[0]).astype(np.float32))
              for shape in about.shapes()]  # fmt: skip
    return Policy(about, layers)


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "policy.npz"
    policy_file.save(random_policy(), path)
    return path


def rewritten(path, **members):
    """The file with members replaced: bytes, or an array; None leaves it out."""
    with zipfile.ZipFile(path) as archive:
        entries = {entry: archive.read(entry) for entry in archive.namelist()}
    for name, value in members.items():
        if value is None:
            del entries[f"{name}.npy"]
            continue
        buffer = io.BytesIO()
        if isinstance(value, bytes):
            buffer.write(value)
        else:
            np.save(buffer, value, allow_pickle=True)
        entries[f"{name}.npy"] = buffer.getvalue()
    path.unlink()
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in entries.items():
            archive.writestr(name, data)
    return path


# --- files ------------------------------------------------------------------------------------------------------------


def test_a_policy_comes_back_as_it_was_saved(saved):
    policy, back = random_policy(), policy_file.load(saved)
    assert back.about == policy.about
    for (weights, biases), (w, b) in zip(policy.layers, back.layers, strict=True):
        assert np.array_equal(weights, w) and np.array_equal(biases, b) and w.dtype == np.float32


def test_the_largest_network_fits_a_file(tmp_path):
    policy = random_policy(dataclasses.replace(ABOUT, hidden=(512,) * 4))
    policy_file.save(policy, tmp_path / "large.npz")
    assert policy_file.load(tmp_path / "large.npz").about.hidden == (512,) * 4


def test_equal_policies_have_equal_files(saved, tmp_path):
    policy_file.save(random_policy(), tmp_path / "again.npz")
    assert (tmp_path / "again.npz").read_bytes() == saved.read_bytes()


def test_saving_overwrites_nothing(saved):
    before = saved.read_bytes()
    with pytest.raises(FileExistsError):
        policy_file.save(random_policy(seed=1), saved)
    assert saved.read_bytes() == before


class Trap:
    """A pickle that leaves a trace when it is read."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return Path.touch, (self.path,)


@pytest.mark.parametrize("place", ["about", "weights0", "extra"])
def test_a_pickle_inside_is_refused_and_not_run(saved, tmp_path, place):
    trap = np.empty((), object)
    trap[()] = Trap(tmp_path / "sprung")
    rewritten(saved, **{place: trap})
    with pytest.raises(UsageError, match="not a policy file"):
        policy_file.load(saved)
    assert not (tmp_path / "sprung").exists()


def test_a_policy_s_file_tells_what_it_was_trained_under(tmp_path):
    options = {"camera": "ov7670", "robot": {"preset": "colias4", "trim": 2}, "randomise": {"light": [0.7, 1.3]}}
    about = dataclasses.replace(ABOUT, options=options)
    policy_file.save(random_policy(about), tmp_path / "policy.npz")
    assert policy_file.load(tmp_path / "policy.npz").about.options == options
    from experiments.bench.training.env import steered

    env = steered(about)
    _, info = env.reset(seed=0)
    assert info["randomised"].keys() == {"light"}
    camera, robot = env.unwrapped._sim.camera.config, env.unwrapped._sim.robots["observer"].config
    assert camera == CameraConfig.preset("ov7670")
    assert robot == dataclasses.replace(RobotConfig.preset("colias4"), trim=2)
    env.close()


# --- steering and driving ---------------------------------------------------------------------------------------------


def test_commands_fade_add_up_and_stay_within_their_limit():
    steering, command = Steering(keep=0.5, reach=0.1, limit=0.15), np.zeros(2, np.float32)
    for expected in (0.1, 0.15, 0.15):
        command = steering.command(command, np.array([1.0, -7.0], np.float32))
        assert command == pytest.approx([expected, -expected])
    assert steering.command(command, np.zeros(2, np.float32)) == pytest.approx([0.075, -0.075])
    assert steering.sense(np.arange(7, dtype=np.float32), command)[-2:] == pytest.approx([1.0, -1.0])


def test_a_policy_answers_with_the_same_bits_alone_and_among_others():
    """A product of matrices sums in another order with another number of rows, and on another processor."""
    policy = random_policy(dataclasses.replace(ABOUT, hidden=(32, 32)))
    sensed = np.random.default_rng(1).uniform(-1, 1, (200, SENSED)).astype(np.float32)
    together = policy.answer(sensed)
    assert together.dtype == np.float32
    np.testing.assert_array_equal(together, [policy.answer(one) for one in sensed])
    expected = sensed.astype(float)
    for weights, biases in policy.layers[:-1]:
        expected = np.tanh(expected @ weights.T.astype(float) + biases)
    weights, biases = policy.layers[-1]
    np.testing.assert_allclose(together, expected @ weights.T.astype(float) + biases, rtol=0, atol=1e-6)


def test_each_episode_begins_with_the_wheels_at_rest(saved):
    behaviour = load_behaviour(str(saved))
    assert (behaviour.name, behaviour.env, behaviour.senses) == ("policy", OPTOMOTOR, "neural")
    seen = Response(0.5, 0.1, 1, 0, None, 0.6, 0, -0.3)
    drives = [behaviour.make(np.random.default_rng(0)) for _ in range(2)]
    first, second = drives[0](seen), drives[0](seen)
    assert drives[1](seen) == first != second
    assert max(map(abs, (*first, *second))) <= ABOUT.steering.limit


# --- the command ------------------------------------------------------------------------------------------------------


def test_a_policy_is_replayed_without_pytorch_and_leaves_recordings(colias, saved):
    done = colias("train", "--replay", str(saved), "--episodes", "2", "--out", "seen", "--workers", "0")
    assert done.returncode == 0, done.stderr
    assert "optomotor gain" in done.stdout and "return" in done.stdout
    recordings = sorted((colias.folder / "seen" / "recordings").glob("*.rrd"))
    assert len(recordings) == 2 and all(path.stat().st_size > 10_000 for path in recordings)


# --- with the extra ---------------------------------------------------------------------------------------------------


def test_training_saves_what_the_network_answers_and_is_repeatable():
    pytest.importorskip("stable_baselines3")
    torch = pytest.importorskip("torch")
    from contextlib import nullcontext

    from experiments.bench.training.ppo import train

    about, steps = About(OPTOMOTOR, seed=1, steps=256, envs=1), []
    first, second = (train(about, lambda: nullcontext(lambda: steps.append(1))) for _ in range(2))
    assert len(steps) == 512 and not first.stopped
    assert first.policy.about.steps == 256 and "torch" in first.policy.about.versions
    assert [row["steps"] for row in first.curve] == [256]
    for ours, theirs in zip(first.policy.layers, second.policy.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))
    sensed = np.random.default_rng(0).uniform(-1, 1, (100, SENSED)).astype(np.float32)
    activations = torch.from_numpy(sensed)
    for weights, biases in first.policy.layers[:-1]:
        activations = torch.tanh(
            torch.nn.functional.linear(activations, torch.from_numpy(weights), torch.from_numpy(biases))
        )
    weights, biases = (torch.from_numpy(part) for part in first.policy.layers[-1])
    expected = torch.nn.functional.linear(activations, weights, biases).numpy()
    assert np.abs(first.policy.answer(sensed) - expected).max() < 1e-6


def test_the_exported_network_answers_as_the_model_does():
    pytest.importorskip("stable_baselines3")
    torch = pytest.importorskip("torch")
    from gymnasium import spaces
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import DummyVecEnv

    from experiments.bench.training.env import steered
    from experiments.bench.training.ppo import exported

    about = dataclasses.replace(ABOUT, hidden=(32, 32))
    envs = DummyVecEnv([lambda: steered(about)])
    model = PPO("MlpPolicy", envs, seed=0, device="cpu", n_steps=256, batch_size=256,
                policy_kwargs={"net_arch": list(about.hidden), "activation_fn": torch.nn.Tanh})  # fmt: skip
    assert isinstance(envs.observation_space, spaces.Box)
    envs.close()
    with torch.no_grad():  # as large as trained ones are: initial weights of the last layer are nearly 0
        for part in model.policy.parameters():
            part += 0.1 * torch.randn_like(part)
    sensed = np.random.default_rng(1).uniform(-1, 1, (200, SENSED)).astype(np.float32)
    theirs = model.policy.get_distribution(torch.from_numpy(sensed)).distribution.mean.detach().numpy()
    assert np.abs(exported(model, about).answer(sensed) - theirs).max() < 1e-6


def test_the_command_trains_judges_and_replays(tmp_path):
    pytest.importorskip("stable_baselines3")
    script = Path(__file__).parents[3] / "experiments" / "train_ppo.py"
    plain = {name: value for name, value in os.environ.items() if "DISPLAY" not in name}

    def run(*arguments):
        return subprocess.run([sys.executable, str(script), *arguments], cwd=tmp_path, capture_output=True, text=True,
                              env=plain, timeout=600, check=False)  # fmt: skip

    done = run("--envs", "2", "--steps", "512", "--out", "learnt")
    assert done.returncode == 0, done.stderr
    assert {"policy.npz", "learning.csv", "scores.csv", "figure.png"} <= {
        p.name for p in (tmp_path / "learnt").iterdir()
    }
    assert all(name in done.stdout for name in ("policy", "random", "still", "optomotor-pi", "oracle-heading"))
    assert policy_file.load(tmp_path / "learnt" / "policy.npz").about.steps == 512
    again = run("--envs", "2", "--steps", "512", "--out", "learnt")
    assert again.returncode == 2 and "holds something already" in again.stderr


def test_several_seeds_are_trained_each_as_alone_and_a_study_is_gone_on_with(tmp_path, monkeypatch):
    pytest.importorskip("stable_baselines3")
    from contextlib import nullcontext

    from experiments.bench.cli import train as command
    from experiments.bench.training import evaluate
    from experiments.bench.training.ppo import train

    monkeypatch.setattr(evaluate, "JUDGED", 1)
    asked = {"seed": 1, "seeds": 2, "steps": 256, "envs": 1, "workers": 0, "quiet": True}
    folder = tmp_path / "study"
    assert command.train(**asked, out=folder) == 0
    files = [folder / f"seed-{seed}" / f"policy-{seed}.npz" for seed in (1, 2)]
    first, second = (file.read_bytes() for file in files)
    assert first != second
    alone = train(About(OPTOMOTOR, seed=2, steps=256, envs=1), lambda: nullcontext(lambda: None)).policy
    for ours, theirs in zip(policy_file.load(files[1]).layers, alone.layers, strict=True):
        assert all(np.array_equal(a, b) for a, b in zip(ours, theirs, strict=True))
    files[1].unlink()
    files[1].parent.joinpath("learning.csv").unlink()
    files[1].parent.rmdir()
    table = (folder / "policies.csv").read_bytes()
    assert command.train(**asked, out=folder) == 0
    assert [file.read_bytes() for file in files] == [first, second]
    assert (folder / "policies.csv").read_bytes() == table
