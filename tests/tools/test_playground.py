"""What the playground takes from the code: ranges and commands. In a browser: tests/site."""

import pytest

from dsnn import DSNNParams
from experiments.declare.experiment import Experiment
from experiments.kinds import registry
from tests.helpers.chapters import check_options
from tools.pages import playground

LEVERS = {lever["key"]: lever for lever in playground.levers()}
SLIDERS = [lever for lever in LEVERS.values() if lever["kind"] == "number"]


@pytest.mark.parametrize("lever", SLIDERS, ids=lambda lever: lever["key"])
def test_a_slider_stands_on_legal_values_and_on_every_preset(lever):
    steps = round((lever["high"] - lever["low"]) / lever["step"])
    assert lever["low"] + steps * lever["step"] == pytest.approx(lever["high"])
    for value in (lever["low"], lever["high"]):
        given = int(value) if lever["step"] == 1 else value
        DSNNParams(**{lever["name"]: given if lever["part"] is None else (given, given)})
    for params in (DSNNParams.offline(), DSNNParams.robot()):
        value = getattr(params, lever["name"])
        value = value if lever["part"] is None else value[lever["part"]]
        assert lever["low"] <= value <= lever["high"]
        assert (value - lever["low"]) / lever["step"] == pytest.approx(round((value - lever["low"]) / lever["step"]))


@pytest.mark.parametrize("folder", playground.RUNS)
def test_a_command_is_one_that_can_be_given(folder):
    command, trials = playground.RUNS[folder]
    check_options(command.split()[1:])
    arguments = playground.arguments(command)
    experiment = registry.find(arguments["experiment"])
    count = len(experiment.conditions() if isinstance(experiment, Experiment) else experiment.clips)
    changed = any(key.startswith("experiment.") for key in arguments["settings"])
    assert max(trials) < (1 if changed else count)
