"""A declaration that is not one ends in a line that says what it should be, before anything runs."""

import sys

import pyarrow.parquet as pq
import pytest

from experiments.bench.cli.entry import run as main

QUICK = ("--workers", "0", "--no-recordings", "-q", "--out", "out")

ROBOT = """
import itertools
from dataclasses import dataclass
from experiments.bench.robot.experiment import Condition, Experiment

GOOD = Condition("translation", "rightward", 30.0, 8.0)
OTHER = Condition("translation", "leftward", 30.0, 8.0)
NUMBERS = itertools.count(20)


@dataclass(frozen=True)
class Own:
    pose_sd_mm: float = 0.0
    heading_sd_deg: float = 0.0
    speed: float = 30.0

    def conditions(self):
        {body}


FIELDS = dict(name="mine", summary="mine", design=Own(), varies="speed_cm_s", repeats=1)
EXPERIMENT = Experiment(**{**FIELDS, {changes}})
"""


def robot(body, changes=""):
    return ROBOT.replace("{body}", body).replace("{changes}", changes)


@pytest.fixture
def refused(tmp_path, monkeypatch, capfd):
    """What ``colias run mine.py`` says of a file that cannot be run: one line, and nothing is made."""

    def run(text, *arguments):
        (tmp_path / "mine.py").write_text(text)
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["colias", "run", "mine.py", *arguments, *QUICK])
        with pytest.raises(SystemExit) as ended:
            main()
        printed, errors = capfd.readouterr()
        assert (ended.value.code, printed, errors.count("\n")) == (2, "", 1), errors
        assert not (tmp_path / "out").exists()
        return errors

    return run


WHAT = "expected experiments.Condition(motion, direction, speed_cm_s, distance_cm,"

BODIES = {
    "yield {'speed_cm_s': 6}": ("its conditions()[0] is {'speed_cm_s': 6}", WHAT),
    "return ({'speed_cm_s': 6},)": ("its conditions()[0] is {'speed_cm_s': 6}", WHAT),
    "return [GOOD, ('translation', 'leftward')]": ("its conditions()[1] is ('translation', 'leftward')", WHAT),
    "return {'a': GOOD}": ("its conditions()[0] is 'a'", WHAT),
    "return GOOD": ("its conditions() answers Condition(motion='translation'", WHAT),
    "return 'fast'": ("its conditions()[0] is 'f'", WHAT),
    "return None": ("its conditions() answers None", WHAT),
    "pass": ("its conditions() answers None", WHAT),
    "return ()": ("its design has no conditions",),
    "return (Condition('translation', 'rightward', 1 / 0, 8.0),)": ("its conditions() raises ZeroDivisionError",),
    "return (Condition('translation', 'up', 6.0, 8.0),)": ("direction='up': legal is rightward, leftward, straight",),
    "return (Condition(speed=6.0),)": ("its conditions() raises TypeError", "'speed'"),
    "return itertools.repeat(GOOD)": ("over 100000 conditions",),
    "yield Condition('translation', 'rightward', next(NUMBERS), 8.0)": ("answers otherwise when it is asked again",),
}


@pytest.mark.parametrize("body", BODIES)
def test_a_design_that_yields_something_else(refused, body):
    message = refused(robot(body))
    assert message.startswith("colias: mine.py, line "), "which file"
    assert "experiment mine: " in message and "AttributeError" not in message
    assert all(words in message for words in BODIES[body]), message


def test_a_design_that_yields_dicts_as_a_user_sees_it(colias):
    (colias.folder / "mine.py").write_text(robot("yield {'speed_cm_s': 6}"))
    done = colias("run", "mine.py", *QUICK)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert WHAT in done.stderr


@pytest.mark.parametrize("body", ["return [GOOD, OTHER]", "yield GOOD; yield OTHER", "return iter((GOOD, OTHER))"])
def test_any_way_to_give_conditions_does(colias, body):
    (colias.folder / "mine.py").write_text(robot(body))
    done = colias("run", "mine.py", *QUICK)
    assert done.returncode == 0, done.stderr
    rows = pq.read_table(colias.folder / "out" / "trials.parquet").to_pylist()
    assert [row["direction"] for row in rows] == ["rightward", "leftward"]


def test_a_design_that_breaks_under_a_parameter(refused):
    body = "return (Condition('translation', 'rightward', 30.0 / (self.speed - 29.0), 8.0),)"
    message = refused(robot(body), "--set", "experiment.speed=29")
    assert "--set: experiment mine: its conditions() raises ZeroDivisionError" in message


CLIPS = """
from experiments.bench.clips.experiment import Clip, Figure, OfflineExperiment

SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
GOOD = dict(name="mine", summary="mine", clips=(Clip("right", "plain", SMALL),), models=("dsnn",))
EXPERIMENT = OfflineExperiment(**{**GOOD, {changes}})
"""

CHANGES = {
    "'clips': ({'stimulus': 'plain'},)": "clips[0] is {'stimulus': 'plain'}: expected experiments.Clip(",
    "'clips': None": "clips=None: legal is a tuple of experiments.Clip(",
    "'clips': 'plain'": "clips='plain': legal is a tuple of",
    "'clips': ()": "it needs clips and models",
    "'models': 'dsnn'": "models='dsnn': legal is a tuple of names",
    "'models': ('dsnn', 3)": "models[1] is 3: expected a name or a path",
    "'models': None": "models=None: legal is a tuple of names",
    "'name': None": "its name: legal are letters, digits",
    "'summary': None": "summary=None: legal is a text",
    "'repeats': 1.5": "repeats=1.5: legal is a whole number from 1 up",
    "'claims': 'C1'": "claims='C1': legal is a tuple of names",
    "'claims': None": "claims=None: legal is a tuple of names",
    "'claims': (1,)": "claims=(1,): legal is a tuple of names",
    "'claims': ('C13',)": "no clips answer for claim 'C13': those of clips are C1, ",
    "'figure': 'peaks'": "figure='peaks': legal is a Figure",
    "'figure': Figure('bars')": "figure: kind='bars': legal is traces, peaks",
    "'figure': Figure('peaks', along='colour')": "figure: along='colour': legal is speed, grey, background_speed",
    "'figure': Figure('peaks')": "the clip 'right', a plain, has no background_speed to draw peaks against",
    "'recorded': 'no'": "recorded='no': legal is True or False",
    "'clips': (Clip(None, 'plain'),)": "clip None: its name: legal is a text",
    "'clips': (Clip('a', 'plain', 'speed=3'),)": "clip a: changes='speed=3': legal is pairs of",
    "'clips': (Clip('a', 'plain', (), None),)": "clip a: jitter_px=None: legal is a number",
}


@pytest.mark.parametrize("changes", CHANGES)
def test_an_off_line_experiment_that_is_none(refused, changes):
    message = refused(CLIPS.replace("{changes}", changes))
    assert message.startswith("colias: mine.py") and CHANGES[changes] in message


def test_clips_may_come_in_any_way(colias):
    changes = "'clips': (Clip(name, 'plain', dict(SMALL, motion=name)) for name in ('rightward', 'leftward')), "
    (colias.folder / "mine.py").write_text(CLIPS.replace("{changes}", changes + "'models': ['dsnn']"))
    done = colias("run", "mine.py", *QUICK)
    assert done.returncode == 0, done.stderr
    rows = pq.read_table(colias.folder / "out" / "trials.parquet").to_pylist()
    assert [(row["clip"], row["motion"]) for row in rows] == [("rightward",) * 2, ("leftward",) * 2]


FIELDS = {
    "'summary': None": "summary=None: legal is a text",
    "'claims': 'C13'": "claims='C13': legal is a tuple of names",
    "'claims': (13,)": "claims=(13,): legal is a tuple of names",
    "'repeats': '3'": "repeats='3': legal is a whole number",
    "'design': Own": "legal is a dataclass with conditions()",
    "'design': None": "design=None: legal is a dataclass with conditions()",
    "'varies': None": "varies=None: no value of it in every condition",
}


@pytest.mark.parametrize("changes", FIELDS)
def test_an_experiment_with_a_field_of_another_kind(refused, changes):
    """Relatives of conditions that are none."""
    assert FIELDS[changes] in refused(robot("return (GOOD,)", changes))
