"""The note that a model assumes another frame rate than it is shown: of every command that plays models."""

import pytest

import experiments
from dsnn import DSNNParams
from experiments.bench.cli import main
from tests.helpers.footage import street, write

MODEL = """
from dataclasses import dataclass

from dsnn import ModelEntry


@dataclass(frozen=True)
class Params:
    fps: float = 20.0
    t_sp: float = 0.2


def build(shape, params):
    raise RuntimeError("the note comes first, so nothing needs to be computed")


MODEL = ModelEntry("slow", "assumes 20 frames/s", build, Params())
"""
BEHAVIOUR = """
from experiments import Behaviour

BEHAVIOUR = Behaviour("turn", "turns", "Optomotor", lambda rng: lambda seen: (0.1, -0.1), model="slow.py")
"""
CLIPS = """
from experiments import Clip, OfflineExperiment

SIZE = {"rows": 24, "columns": 32, "fps": 60}
EXPERIMENT = OfflineExperiment("fast", "one clip", [Clip("way", "plain", SIZE)], ["emd"])
"""
OWN = ("--model", "slow.py", "--workers", "0", "--set", "experiment.speeds_cm_s=30", "--repeats", "1")
SLOW = "note: slow assumes 20 frames/s and is shown 30"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in (("slow", MODEL), ("turn", BEHAVIOUR), ("fast", CLIPS)):
        (tmp_path / f"{name}.py").write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("command", "note"),
    [
        (("run", "speed", *OWN, "--only", "--no-recordings"), SLOW),
        (("sweep", "speed", *OWN, "--measure", "spikes", "--over", "slow.t_sp=1"),
         SLOW.replace("slow ", "slow.t_sp=1 ")),
        (("run", "fast.py", "--workers", "0"), "note: emd assumes 30 frames/s and is shown 60"),
        (("tune", "--model", "slow.py", "--only", "--curve", "direction", "--workers", "0"), SLOW),
        (("behave", "turn.py", "--episodes", "1", "--no-baselines", "--workers", "0"), SLOW),
        (("sweep", "speed", *OWN, "--measure", "spikes", "--over", "camera.fps=20,40"),
         SLOW.replace("slow ", "camera.fps=40 ").replace("30", "40")),
    ],
    ids=lambda value: " ".join(value[:2]) if isinstance(value, tuple) else "",
)  # fmt: skip
def test_commands_say_that_a_model_assumes_another_rate(command, note, capsys):
    main.command([*command, "--out", "out", "-q"])
    assert note in capsys.readouterr().err.splitlines()


def test_watch_says_so(folder, capsys):
    size = ("--set", "plain.rows=24", "--set", "plain.columns=32", "--set", "plain.fps=60")
    main.command(["watch", "plain", *size, "--no-view"])
    note = "dsnn assumes 30 frames/s and is shown 60"
    assert f"note: {note}" in capsys.readouterr().err.splitlines()
    film = write(folder / "film.avi", street((), 3), fps=60.0)
    main.command(["watch", str(film), "--no-view", "--size", "32x18"])
    assert f"note: {note}" in capsys.readouterr().err.splitlines()
    assert experiments.watch(film, size=(32, 18), quiet=True).description["notes"] == [note]
    assert experiments.watch(film, size=(32, 18), quiet=True, fps=60).description["notes"] == []


def test_nothing_is_said_of_a_rate_that_is_the_model_s_own(capsys):
    assert DSNNParams().fps == 30.0
    main.command(["run", "speed", "--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--workers", "0",
                  "--no-recordings", "--out", "out"])  # fmt: skip
    assert "frames/s" not in capsys.readouterr().err
