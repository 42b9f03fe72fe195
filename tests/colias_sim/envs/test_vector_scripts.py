"""A vector env works wherever it is made: the script that makes it runs once, and takes its own things along."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import colias_sim

ENVIRONMENT = {**os.environ, "PYTHONPATH": str(Path(colias_sim.__file__).parents[1])}

BESIDE = """
from dsnn import Response

def answer(frame):
    return Response(hs=float(frame.mean()) / 255)
"""

SCRIPT = """
with open("runs.txt", "a") as file:
    file.write("once\\n")

import os, sys
import gymnasium as gym, numpy as np
import colias_sim
import beside

SCALE = 0.5

class Refusal(Exception):
    pass

class Mean:
    def __init__(self, shape):
        assert shape == (72, 99)
    def step(self, frame):
        return beside.answer(frame * SCALE)
    def reset(self):
        pass
    def refuse(self):
        raise Refusal("no")

def story(workers):
    env = gym.make_vec("colias_sim/Fixation-v0", num_envs=2, workers=workers, observation="neural", model=Mean)
    first, _ = env.reset(seed=0)
    rest = [env.step(np.full((2, 2), 0.1)) for _ in range(3)]
    assert all(isinstance(model.inner, Mean) for model in env.get_attr("model"))
    env.set_attr("refuse", Mean.refuse)
    try:
        env.call("refuse", None)
    except Refusal as refusal:
        assert str(refusal) == "no"
    else:
        raise AssertionError("no error")
    env.close()
    return first, [(seen, reward) for seen, reward, *_ in rest]

def play():
    first, rest = story(1)
    assert 0 < first[0, 0] < 0.5
    print("played", flush=True)
    return first, rest
"""
COMPARED = """
for one, other in zip(play()[1], story(0)[1], strict=True):
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], other[1])
"""
PLAIN, GUARDED = SCRIPT + "play()\n", SCRIPT + "if __name__ == '__main__':\n    play()\n"


def ran(folder: Path, *arguments: str, text: str | None = None, output: str = "played\n") -> None:
    """The interpreter did its work without a complaint, and the script's top level ran once."""
    done = subprocess.run(
        [sys.executable, "-W", "error", *arguments],
        env=ENVIRONMENT, cwd=folder, input=text, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert (done.stderr, done.stdout, done.returncode) == ("", output, 0)
    assert (folder / "runs.txt").read_text() == "once\n"


@pytest.mark.parametrize("script", [SCRIPT + COMPARED, GUARDED], ids=["plain", "guarded"])
def test_a_script_in_another_folder(script: str, tmp_path: Path) -> None:
    home, here = tmp_path / "home", tmp_path / "here"
    home.mkdir()
    here.mkdir()
    (home / "beside.py").write_text(BESIDE)
    (home / "script.py").write_text(script)
    (here / "pickle.py").write_text("raise SystemExit('not the standard library')")  # nobody's to import from here
    ran(here, str(home / "script.py"))


def test_standard_input_and_an_argument(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text(BESIDE)
    ran(tmp_path, "-", text=PLAIN)
    (tmp_path / "runs.txt").unlink()
    ran(tmp_path, "-c", PLAIN)


def test_a_heredoc_with_more_to_read(tmp_path: Path) -> None:
    """What the script reads as its input is not a worker's to read."""
    greedy = BESIDE.replace("def answer(frame):", "import os\n\ndef answer(frame):\n    assert os.read(0, 9) == b''")
    (tmp_path / "beside.py").write_text(greedy)
    script = PLAIN + "print(sys.stdin.read(), end='')"
    (tmp_path / "script.py").write_text(script)
    ran(tmp_path, "script.py", text="mine\n", output="played\nmine\n")


def test_a_module_of_a_package(tmp_path: Path) -> None:
    package = tmp_path / "mine"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "beside.py").write_text(BESIDE)
    (package / "play.py").write_text(PLAIN.replace("import beside", "from . import beside"))
    ran(tmp_path, "-m", "mine.play")


def test_a_notebooks_cell(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text(BESIDE)
    (tmp_path / "cell.py").write_text(PLAIN)
    kernel = "import __main__, pathlib\ncell = pathlib.Path('cell.py').read_text()\n"
    kernel += "exec(compile(cell, '<cell 1>', 'exec'), __main__.__dict__)"
    (tmp_path / "kernel.py").write_text(kernel)
    ran(tmp_path, "kernel.py")


def test_a_path_that_the_script_adds(tmp_path: Path) -> None:
    """Where the script finds modules is what counts when the env is made."""
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "beside.py").write_text(BESIDE)
    (tmp_path / "script.py").write_text(PLAIN.replace("import beside", "sys.path.insert(0, 'lib')\nimport beside"))
    ran(tmp_path, "script.py")


def test_a_process_of_multiprocessing(tmp_path: Path) -> None:
    """Such a process knows the script by another name, and runs it again itself."""
    (tmp_path / "beside.py").write_text(BESIDE)
    script = SCRIPT + (
        "if __name__ == '__main__':\n"
        "    import multiprocessing\n"
        "    with multiprocessing.get_context('spawn').Pool(1) as pool:\n"
        "        pool.apply(play)\n"
        "        pool.close()\n"
        "        pool.join()\n"
    )
    (tmp_path / "script.py").write_text(script.replace('"runs.txt", "a"', '"runs.txt", "w"'))
    ran(tmp_path, "script.py")


def test_without_standard_input(tmp_path: Path) -> None:
    """The file descriptors that a worker inherits may then have the numbers of its own standard streams."""
    (tmp_path / "beside.py").write_text(BESIDE)
    (tmp_path / "script.py").write_text(PLAIN)
    done = subprocess.run(
        ["sh", "-c", 'exec "$0" script.py <&-', sys.executable],
        env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert (done.stderr, done.stdout, done.returncode) == ("", "played\n", 0)


@pytest.mark.parametrize("flags", [["-O", "-W", "error::UserWarning", "-X", "utf8"], ["-I", "-B"]], ids=" ".join)
def test_the_interpreters_flags(flags: list[str], tmp_path: Path) -> None:
    script = f"""
import sys
sys.path.insert(0, {ENVIRONMENT["PYTHONPATH"]!r})
import gymnasium as gym
import colias_sim

NAMES = ["optimize", "dont_write_bytecode", "isolated", "utf8_mode", "no_user_site", "ignore_environment"]

def flags():
    import sys
    return [getattr(sys.flags, name) for name in NAMES], sys.warnoptions

env = gym.make_vec("colias_sim/Fixation-v0", num_envs=1, workers=1, observation="state")
env.set_attr("flags", [flags])
(seen,) = env.call("flags")
env.close()
if seen != flags():
    raise SystemExit(f"{{seen}} {{flags()}}")
"""
    done = subprocess.run(
        [sys.executable, *flags, "-"], input=script, env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True,
        timeout=120,
    )  # fmt: skip
    assert (done.stderr, done.returncode) == ("", 0)


def test_a_global_that_does_not_pickle_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "beside.py").write_text(BESIDE)
    script = PLAIN.replace("SCALE = 0.5", "import threading\nSCALE = threading.Lock()")
    (tmp_path / "script.py").write_text(script)
    done = subprocess.run(
        [sys.executable, "script.py"], env=ENVIRONMENT, cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 1
    last = done.stderr.splitlines()[-1]
    assert last.startswith("ValueError: model=<class '__main__.Mean'> does not pickle") and "_thread.lock" in last
