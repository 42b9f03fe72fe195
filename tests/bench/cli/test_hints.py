"""Messages that lead on: the known name that a mistyped one was meant for, and where in a user's file it went wrong."""

import json

import gymnasium as gym
import pytest

import colias_sim  # noqa: F401  (registers the envs)
import scenes
from colias_sim import SceneConfig
from dsnn import model_entry
from dsnn.stimuli import stimulus
from experiments import Translation
from experiments.bench.cli import main

FAR = "zqzqzqzq"


def avoidance(**options):
    gym.make("colias_sim/Avoidance-v0", observation="state", **options).close()


def reset(options):
    env = gym.make("colias_sim/Avoidance-v0", observation="state")
    try:
        env.reset(options=options)
    finally:
        env.close()


REFUSALS = {
    "arena": (scenes.arena_path, "brigth", "bright"),
    "a scene's arena": (lambda name: SceneConfig(arena=name), "brigth", "bright"),
    "model": (model_entry, "Dsn", "dsnn"),
    "stimulus": (stimulus, "plane", "plain"),
    "a stimulus's parameter": (lambda name: stimulus("plain", **{name: 1}), "speeed", "speed"),
    "experiment": (lambda name: main.command(["run", name]), "Spede", "speed"),
    "curve": (lambda name: main.command(["tune", "--curve", name]), "sped", "speed"),
    "behaviour": (lambda name: main.command(["behave", name]), "hybird", "hybrid"),
    "env": (lambda name: main.command(["behave", "escape", "--env", name]), "Avoidence-v0", "Avoidance-v0"),
    "a model's parameter": (lambda name: main.command(["run", "speed", "--model", f"dsnn:{name}=1"]), "n_kon", "n_con"),
    "an env's argument": (lambda name: avoidance(**{name: 1}), "robtos", "robots"),
    "a camera's preset": (lambda name: avoidance(camera=name), "ov767", "ov7670"),
    "factor": (lambda name: avoidance(randomise={name: (0.7, 1.3)}), "ligth", "light"),
    "a preset of factors": (lambda name: avoidance(randomise=name), "domian", "domain"),
    "an option of reset": (lambda name: reset({name: 0.5}), "ligth", "light"),
    "a pose": (lambda name: reset({"poses": {name: (0, 0, 0)}}), "obsrver", "observer"),
}


@pytest.mark.parametrize("refusal", REFUSALS)
def test_only_a_name_that_is_alike_is_named_as_the_nearest(refusal, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, typed, meant = REFUSALS[refusal]
    with pytest.raises(ValueError, match=f"nearest: {meant}"):
        call(typed)
    with pytest.raises(ValueError, match=FAR) as caught:
        call(FAR)
    assert "nearest" not in str(caught.value) and "( " not in str(caught.value) and "()" not in str(caught.value)


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("dsnn.n_kon", "dsnn.n_con"),
        ("camra.fps", "camera.fps"),
        ("n_con", "dsnn.n_con"),
        ("robot.n_con", "dsnn.n_con"),
        ("robot.fastest_deg_s", ""),
        ("experiment.acceleration_cm_s2", ""),
        (f"dsnn.{FAR}", ""),
        (FAR, ""),
    ],
)
def test_a_key_is_taken_for_one_of_like_name_not_of_like_section(typed, meant):
    with pytest.raises(ValueError, match=f"no parameter '{typed}'") as caught:
        main.command(["run", "speed", "--set", f"{typed}=1"])
    message = str(caught.value)
    assert message.count("nearest: ") == bool(meant) and f"(nearest: {meant}; " * bool(meant) in message, message
    known = typed.partition(".")[0] in ("dsnn", "robot", "camera", "scene", "experiment")
    assert known != ("sections here are dsnn, robot, camera, scene, experiment" in message) and "all: " in message, (
        message
    )


MODEL = """
from dataclasses import dataclass

from dsnn import ModelEntry


@dataclass(frozen=True)
class Params:
    t_sp: float = 0.2


class Failing:
    def __init__(self, shape, parameters):
        pass

    def reset(self):
        pass

    def step(self, frame, **of):
        return {}["gone"]


MODEL = ModelEntry("failing", "fails at its first frame", Failing, Params())
"""
BEHAVIOUR = """
from experiments import Behaviour


def policy(seen):
    raise RuntimeError("lost")


BEHAVIOUR = Behaviour("lost", "fails", "Optomotor", lambda rng: policy, senses="state")
"""
DESIGN = """
from dataclasses import dataclass

from experiments import Condition, Experiment


@dataclass(frozen=True)
class Mine:
    speed: float = 6.0
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0

    def conditions(self):
        return [Condition("translation", "rightward", 60.0 / (self.speed - 5.0), 8.0)]


EXPERIMENT = Experiment("mine", "one crossing", Mine(), "speed_cm_s")
"""


def line_of(text: str, part: str) -> int:
    return next(number for number, line in enumerate(text.splitlines(), 1) if part in line)


def test_failures_of_a_run_name_the_users_file_and_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for name, text in (("failing", MODEL), ("lost", BEHAVIOUR), ("design", DESIGN)):
        (tmp_path / f"{name}.py").write_text(text)
    quick = ("--set", "experiment.speeds_cm_s=30", "--repeats", "1", "--workers", "0")
    assert main.command(["run", "speed", *quick, "--model", "failing.py", "--no-recordings", "--out", "run"]) == 1
    reason = f"failing.py, line {line_of(MODEL, 'gone')}: KeyError: 'gone'"
    (failure,) = json.loads((tmp_path / "run" / "failures.json").read_text())
    assert (failure["model"], failure["reason"]) == ("failing", reason)
    assert reason in capsys.readouterr().err
    assert main.command(["behave", "lost.py", "--episodes", "1", "--no-baselines", "--workers", "0", "--out", "b"]) == 1
    assert f"lost.py, line {line_of(BEHAVIOUR, 'lost')}: RuntimeError: lost" in capsys.readouterr().err
    with pytest.raises(ValueError, match="conditions") as caught:
        main.command(["run", "design.py", "--set", "experiment.speed=5", "--out", "d"])
    assert f"ZeroDivisionError: float division by zero (design.py, line {line_of(DESIGN, '60.0 /')})" in str(
        caught.value
    )


def test_a_number_in_the_place_of_a_list_is_told_what_a_list_looks_like(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "one.py").write_text(
        "from experiments import Experiment, Translation\n\n"
        'EXPERIMENT = Experiment("one", "one speed", Translation(speeds_cm_s=10), "speed_cm_s")\n'
    )
    with pytest.raises(ValueError, match=r"one.py, line 3: .*speeds_cm_s=10: expected a list such as \(2, 4\)$"):
        main.command(["run", "one.py"])
    assert Translation((2, 4), (6,)).speeds_cm_s == (2.0, 4.0)
