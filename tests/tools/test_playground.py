"""What the playground takes from the code: ranges, packed frames, commands, modules. In a browser: tests/site."""

from __future__ import annotations

import re
import zlib

import numpy as np
import pytest

from dsnn import DSNNParams
from experiments.bench import registry
from experiments.bench.sources.experiment import Experiment
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


def test_a_range_is_the_papers_where_it_gives_one():
    """In the field's own words; w_i has one value in the paper."""
    assert "(paper: 4..8)" in str(DSNNParams.__pydantic_fields__["n_con"].description)
    assert (LEVERS["n_con"]["low"], LEVERS["n_con"]["high"], LEVERS["n_con"]["step"]) == (4, 8, 1)
    assert (LEVERS["w_i"]["low"], LEVERS["w_i"]["high"]) == (0, 1)
    assert LEVERS["tau_s.0"]["meaning"] != LEVERS["tau_s.1"]["meaning"]
    assert (LEVERS["d"]["unit"], LEVERS["tau_s.0"]["unit"]) == ("px", "ms")


def test_packed_frames_come_back():
    film = np.random.default_rng(0).integers(0, 256, (5, 4, 3)).astype(np.uint8)
    differences = np.frombuffer(zlib.decompress(playground.packed(film)), np.uint8).reshape(film.shape)
    np.testing.assert_array_equal(np.cumsum(differences, axis=0, dtype=np.uint8), film)


@pytest.mark.parametrize("shown", playground.RUNS, ids=lambda run: run.name)
def test_a_command_is_one_that_can_be_given(shown):
    check_options(shown.command.split()[1:])
    arguments = playground.arguments(shown.command)
    experiment = registry.find(arguments["experiment"])
    count = len(experiment.conditions() if isinstance(experiment, Experiment) else experiment.clips)
    changed = any(key.startswith("experiment.") for key in arguments["settings"])
    assert max(shown.trials) < (1 if changed else count)


def test_every_module_is_in_the_page():
    named = {path.stem for path in playground.SOURCES.glob("*.js")}
    asked = {
        name for path in playground.SOURCES.glob("*.js") for name in re.findall(r'from "#(\w+)"', path.read_text())
    }
    assert asked | {"main"} == named == set(playground.MODULES)


def test_footage_ends_where_the_page_says():
    (longest,) = re.findall(r"LONGEST = (\d+);", (playground.SOURCES / "footage.js").read_text())
    assert int(longest) == playground.LONGEST_FOOTAGE
