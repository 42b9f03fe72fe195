"""The note that a model assumes another frame rate than it is shown: of every command that plays models."""

import pytest

import experiments
from experiments.bench.cli import main
from experiments.bench.run.models import choose, rate_notes
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


def test_a_model_s_rate_is_held_against_what_it_is_shown(folder):
    """29.97 frames/s are 30; models of one rate share a line."""
    dsnn, emd, slow, flow = (choose(name) for name in ("dsnn", "emd", "slow.py", "flow"))
    assert rate_notes([(dsnn, 30.0), (emd, 29.97), (slow, 20.0), (flow, 60.0)]) == []
    notes = rate_notes([(dsnn, 60.0), (emd, 60.0), (slow, 60.0), (slow, 30.0)])
    assert notes == [
        "dsnn, emd assume 30 frames/s and are shown 60",
        "slow assumes 20 frames/s and is shown 30, 60",
    ]


@pytest.mark.parametrize(
    ("command", "note"),
    [
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
