"""Trained policies: what a file may hold and what is refused, steering, the command; PPO itself where it is set up."""

import dataclasses
import io
import json
import os
import pickle
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
from experiments.bench.engine.errors import UsageError

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


def about_with(path, **changes):
    """The file with entries of its 'about' changed."""
    with np.load(path, allow_pickle=False) as file:
        values = json.loads(str(file["about"]))
    return rewritten(path, about=np.array(json.dumps(values | changes)))


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


def test_files_of_another_kind_are_refused_in_a_line(tmp_path):
    kinds = {
        "empty": b"", "text": b"hello\n" * 100, "pickle": pickle.dumps({"weights": 1}),
        "huge": bytes(policy_file.MOST_BYTES + 1),
    }  # fmt: skip
    for name, data in kinds.items():
        path = tmp_path / f"{name}.npz"
        path.write_bytes(data)
        with pytest.raises(UsageError) as caught:
            policy_file.load(path)
        assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)
    with pytest.raises(UsageError, match="no such file"):
        policy_file.load(tmp_path / "missing.npz")


def header(shape, descr="<f4"):
    buffer = io.BytesIO()
    np.lib.format.write_array_header_1_0(buffer, {"descr": descr, "fortran_order": False, "shape": shape})
    return buffer.getvalue()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"weights0": None}, "expected 3 layers"),
        ({"more": np.zeros(3, np.float32)}, "expected 3 layers"),
        ({"about": None}, "no text 'about'"),
        ({"about": np.array("[1, 2")}, "not a policy file"),
        ({"about": np.array("[" * 5000)}, "not a policy file"),
        ({"about": np.array("{}")}, "says no format"),
        ({"weights0": np.zeros((4, SENSED), np.float32)}, "layers of shapes"),
        ({"weights1": np.zeros((4, 5))}, "not float32"),
        ({"weights1": np.full((4, 5), np.nan, np.float32)}, "not finite"),
        ({"weights0": header((10**9, 10**9))}, "not a policy file"),
        ({"weights0": header((-1, -1)) + bytes(4)}, "not a policy file"),
        ({"weights0": header((5, SENSED), "|O")}, "not a policy file"),
        ({"weights0": b"\x93NUMPY\x01\x00"}, "not a policy file"),
        ({"weights0": b"\x93NUMPY\x09\x00" + bytes(90)}, "not a policy file"),
    ],
)
def test_damaged_contents_are_refused_in_a_line(saved, changes, message):
    with pytest.raises(UsageError, match=message) as caught:
        policy_file.load(rewritten(saved, **changes))
    assert str(caught.value).startswith(str(saved)) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"env": "colias_sim/Chess-v0"}, "no such env; known are colias_sim/Avoidance-v0"),
        ({"model": "dsm"}, "About.model='dsm'"),
        ({"hidden": [10**9]}, "less than or equal to 512"),
        ({"hidden": []}, "at least 1 item"),
        ({"steering": {"keep": 2.0}}, "About.steering.keep=2.0"),
        ({"steering": {"gain": 2.0}}, "About.steering.gain"),
        ({"seed": -1}, "About.seed=-1"),
        ({"options": {"model": "evil.py"}}, "no argument to be trained under: 'model'"),
        ({"options": {"camera": "ov767"}}, "no preset 'ov767'"),
        ({"format": "colias-policy 2"}, "one other than 'colias-policy 1'"),
        ({"entry_point": "os:system"}, "About.entry_point"),
        ({"hidden": [5, 5]}, "layers of shapes"),
    ],
)
def test_what_a_file_says_of_itself_is_checked(saved, changes, message):
    with pytest.raises(UsageError, match=message) as caught:
        policy_file.load(about_with(saved, **changes))
    assert str(caught.value).startswith(str(saved)) and "\n" not in str(caught.value)


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


def test_a_file_cut_anywhere_or_with_bytes_changed_never_raises_anything_else(saved):
    whole, rng = saved.read_bytes(), np.random.default_rng(0)
    for turn in range(300):
        data = bytearray(whole)
        if turn % 2:
            data = data[: rng.integers(len(data))]
        else:
            for place in rng.integers(len(data), size=3):
                data[place] = rng.integers(256)
        saved.write_bytes(data)
        try:
            policy_file.load(saved)
        except UsageError as error:
            assert "\n" not in str(error)


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for the peak of this process's memory")
@pytest.mark.parametrize("shape", [(2**20,), (2**28,), (2**34, 2**4)])
def test_a_header_that_claims_much_takes_no_memory(saved, shape):
    def peak_kb():
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))

    rewritten(saved, weights0=header(shape))
    Path("/proc/self/clear_refs").write_text("5")  # the peak begins anew
    before = peak_kb()
    with pytest.raises(UsageError, match="not a policy file"):
        policy_file.load(saved)
    assert peak_kb() - before < 3_000, "the file itself has 2 KB; the smallest claim is 4 MB"


def test_what_unpacks_to_more_than_a_policy_is_refused_unread(saved):
    with zipfile.ZipFile(saved, "a", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("bomb.npy", bytes(policy_file.MOST_BYTES))
    with pytest.raises(UsageError, match="unpacks to more"):
        policy_file.load(saved)


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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--env", "Pursuit"), "colias: --env Pursuit: a policy learns Optomotor or Fixation"),
        (("--env", "Chess"), "colias: --env Chess: known are"),
        (("--steps", "10"), "colias: --steps 10: legal is a whole number from 2048"),
        (("--envs", "0"), "colias: --envs 0: legal is a whole number from 1 to 64"),
        (("--seed", "-1"), "colias: --seed -1: legal is a whole number from 0 to 4294967295"),
        (("--episodes", "3"), "colias: --episodes 3: goes with --replay"),
        (("--replay", "policy.npz"), "colias: policy.npz: no such file"),
        (("--set", "arena=dim"), "colias: --set arena=dim: a training may change camera, robot, noise, randomise"),
        (("--randomise", "2"), "colias: --set: randomise=2: expected a number in 0 .. 1"),
        (("--replay", "p.npz", "--set", "camera=ov7670"), "colias: --set camera=ov7670: the policy's file says that"),
        (("--replay", "policy.npz", "--steps", "5"), "colias: --steps 5: the policy's file says that"),
    ],
)
def test_wrong_uses_end_in_a_line(colias_here, arguments, message):
    done = colias_here("train", *arguments)
    assert done.returncode == 2 and done.stderr.startswith(message) and done.stderr.count("\n") == 1
    assert not list(colias_here.folder.iterdir())


def test_without_the_extra_a_line_says_what_to_install(colias, tmp_path):
    hidden = "import importlib.util as u, sys; find = u.find_spec\n" \
             "u.find_spec = lambda name, *rest: None if name == 'torch' else find(name, *rest)\n" \
             "from experiments.bench.cli.entry import run as main; sys.argv = ['colias', 'train']; main()"  # fmt: skip
    done = subprocess.run([sys.executable, "-c", hidden], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and "Traceback" not in done.stderr
    assert "needs torch, which is not installed: run 'make train'" in done.stderr


def test_nothing_is_overwritten(colias_here, saved):
    done = colias_here("train", "--replay", str(saved), "--out", str(saved.parent))
    assert done.returncode == 2 and "holds something already" in done.stderr


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
