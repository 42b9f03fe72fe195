"""A declaration that is not one is refused with the place in its file, before anything runs."""

import sys

import polars as pl
import pytest

from experiments.bench.cli.entry import run as main

QUICK = ("--workers", "0", "--no-recordings", "-q", "--out", "out")

ROBOT = """
import itertools
from dataclasses import dataclass
from experiments.bench.sources.conditions import Condition
from experiments.bench.sources.experiment import Experiment

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
    """What ``colias run mine.py`` says of a file that cannot be run; nothing is made."""

    def run(text, *arguments):
        (tmp_path / "mine.py").write_text(text)
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["colias", "run", "mine.py", *arguments, *QUICK])
        with pytest.raises(SystemExit) as ended:
            main()
        printed, errors = capfd.readouterr()
        assert (ended.value.code, printed) == (2, "") and "mine.py" in errors, errors
        assert not (tmp_path / "out").exists()
        return errors

    return run


@pytest.mark.parametrize("body", ["return [GOOD, OTHER]", "yield GOOD; yield OTHER", "return iter((GOOD, OTHER))"])
def test_any_way_to_give_conditions_does(colias, body):
    (colias.folder / "mine.py").write_text(robot(body))
    done = colias("run", "mine.py", *QUICK)
    assert done.returncode == 0, done.stderr
    rows = pl.read_parquet(colias.folder / "out" / "trials.parquet").to_dicts()
    assert [row["direction"] for row in rows] == ["rightward", "leftward"]


def test_a_design_that_breaks_under_a_parameter(refused):
    body = "return (Condition('translation', 'rightward', 30.0 / (self.speed - 29.0), 8.0),)"
    assert "ZeroDivisionError" in refused(robot(body), "--set", "experiment.speed=29")


CLIPS = """
from experiments.bench.sources.clips import Clip
from experiments.bench.sources.clips import Figure
from experiments.bench.sources.clips import OfflineExperiment

SMALL = (("rows", 40), ("columns", 60), ("width", 9), ("height", 20), ("speed", 240.0))
GOOD = dict(name="mine", summary="mine", clips=(Clip("right", "plain", SMALL),), models=("dsnn",))
EXPERIMENT = OfflineExperiment(**{**GOOD, {changes}})
"""


def test_clips_may_come_in_any_way(colias):
    changes = "'clips': (Clip(name, 'plain', dict(SMALL, motion=name)) for name in ('rightward', 'leftward')), "
    (colias.folder / "mine.py").write_text(CLIPS.replace("{changes}", changes + "'models': ['dsnn']"))
    done = colias("run", "mine.py", *QUICK)
    assert done.returncode == 0, done.stderr
    rows = pl.read_parquet(colias.folder / "out" / "trials.parquet").to_dicts()
    assert [(row["clip"], row["motion"]) for row in rows] == [("rightward",) * 2, ("leftward",) * 2]


FIELDS = (
    "'summary': None",
    "'claims': 'C13'",
    "'claims': (13,)",
    "'repeats': '3'",
    "'design': Own",
    "'design': None",
    "'varies': None",
)
