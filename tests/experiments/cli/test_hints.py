"""Messages that lead on: the known name that a mistyped one was meant for, and where in a user's file it went wrong."""

import pytest

import scenes
from dsnn import model_entry
from dsnn.stimuli import stimulus
from experiments.cli import main

FAR = "zqzqzqzq"


REFUSALS = {
    "arena": (scenes.arena_path, "brigth", "bright"),
    "model": (model_entry, "Dsn", "dsnn"),
    "stimulus": (stimulus, "plane", "plain"),
    "experiment": (lambda name: main.command(["run", name]), "Spede", "speed"),
    "curve": (lambda name: main.command(["tune", "--curve", name]), "sped", "speed"),
    "behaviour": (lambda name: main.command(["behave", name]), "hybird", "hybrid"),
    "env": (lambda name: main.command(["behave", "escape", "--env", name]), "Avoidence-v0", "Avoidance-v0"),
    "a section": (lambda name: main.command(["run", "speed", "--set", f"{name}.n_con=1"]), "dsn", "dsnn.n_con"),
    "a model's parameter": (lambda name: main.command(["run", "speed", "--model", f"dsnn:{name}=1"]), "n_kon", "n_con"),
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
