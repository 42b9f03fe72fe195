"""``colias check`` of a stimulus: those that ship keep the laws, and each mistake is named by the law it breaks."""

import dataclasses
import itertools
import json

import numpy as np
import polars as pl
import pytest
from pydantic.dataclasses import dataclass

from dsnn.stimuli import (
    STIMULI,
    Box,
    ClipParams,
    Stimulus,
    StimulusEntry,
    StimulusFrame,
    Truth,
    Velocity,
    stimulus_entry,
)
from experiments.bench.cli.main import command
from experiments.bench.conformance import stimulus_laws

SPEED = 60.0
GRAYS = itertools.cycle(range(100, 200))


def small(entry):
    """The entry at few pixels and frames a second: the laws are the same, and painting is cheap."""
    return dataclasses.replace(entry, params=dataclasses.replace(entry.params, rows=48, columns=80, fps=10))


@pytest.mark.parametrize("name", STIMULI)
def test_every_stimulus_that_ships_keeps_the_laws(name):
    assert [finding for finding in stimulus_laws.check(small(stimulus_entry(name))) if finding.trouble] == []


@dataclass(frozen=True)
class Params(ClipParams):
    fps: float = 30.0


class Sound(Stimulus[Params]):
    """A dark square goes right, 2 px a frame."""

    def __len__(self):
        return 12

    def box(self, index):
        return Box(10.0 + SPEED * index / self.fps, 10.0, 8.0, 8.0)

    def paint(self, index):
        luma = np.full(self.shape, 255, np.uint8)
        left = int(self.box(index).left)
        luma[10:18, left : left + 8] = 0
        return luma

    def frame(self, index):
        return StimulusFrame(self.paint(index), Truth("rightward", self.box(index), Velocity(SPEED, 0.0)))


class Floats(Sound):
    def paint(self, index):
        return super().paint(index).astype(float)


class Accumulating(Sound):
    shift = 0

    def paint(self, index):
        self.shift += 1
        return np.roll(super().paint(index), self.shift % 3, axis=0)


class Unseeded(Sound):
    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.gray = next(GRAYS)  # another for each object

    def paint(self, index):
        luma = super().paint(index)
        luma[12, int(self.box(index).left) + 2] = self.gray
        return luma


class OfOneShape(Sound):
    def paint(self, index):
        return super().paint(index) if self.shape != (48, 80) else np.full((180, 320), 255, np.uint8)


class Wordless(Sound):
    def frame(self, index):
        return dataclasses.replace(super().frame(index), truth=Truth(""))


class Leaking(Sound):
    def paint(self, index):
        luma = super().paint(index)
        luma[0, index] = 0
        return luma


class Slow(Sound):
    def frame(self, index):
        frame = super().frame(index)
        return dataclasses.replace(frame, truth=dataclasses.replace(frame.truth, velocity=Velocity(SPEED / 3, 0.0)))


class Raising(Sound):
    def frame(self, index):
        raise RuntimeError("no more")


@pytest.mark.parametrize(
    ("kind", "law", "words"),
    [(Floats, "bytes", "float64"), (Accumulating, "any frame", "asked for again"), (Unseeded, "seeds", "built alike"),
     (OfOneShape, "shape", "(180, 320)"), (Wordless, "truth", "its motion a word"),
     (Leaking, "what moves", "pixel (0, 0) changes from frame 0 to 1"), (Slow, "velocity", "moves 2 px along x"),
     (Raising, "bytes", "no more")],
)  # fmt: skip
def test_each_mistake_is_named_by_its_law(kind, law, words):
    findings = {finding.law: finding.trouble for finding in stimulus_laws.check(StimulusEntry("s", "", kind, Params()))}
    assert words in findings[law], findings


def test_the_stimulus_of_these_tests_is_sound():
    """The control of the mistakes above."""
    assert not any(finding.trouble for finding in stimulus_laws.check(StimulusEntry("s", "", Sound, Params())))


OWN = """
import numpy as np
from dsnn.stimuli import ClipParams, Stimulus, StimulusEntry, StimulusFrame, Truth
from experiments import Clip, OfflineExperiment

class Flicker(Stimulus[ClipParams]):
    def __len__(self):
        return 9

    def frame(self, index):
        return StimulusFrame(np.full(self.shape, 100 + index % 2, np.uint8), Truth("flickering"))

STIMULUS = StimulusEntry("flicker", "grey that flickers", Flicker, ClipParams(rows=20, columns=30))
EXPERIMENT = OfflineExperiment("flickers", "it flickers", [Clip("one", STIMULUS, {"fps": 60.0})], ["emd"])
"""


def test_a_stimulus_of_one_s_own_is_shown_in_workers_and_by_each_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "flicker.py").write_text(OWN)
    assert command(["run", "flicker.py", "--out", "out", "--workers", "1", "--quiet"]) == 0
    (row,) = pl.read_parquet("out/trials.parquet").to_dicts()
    assert (row["stimulus"], row["clip"], row["frames"]) == ("flicker", "one", 9)
    description = json.loads((tmp_path / "out" / "run.json").read_text())
    assert description["experiment"]["clips"][0]["stimulus"] == "flicker"
    assert description["clips"]["one"] == {"rows": 20, "columns": 30, "fps": 60.0}
    assert [*description["files"]] == [str(tmp_path / "flicker.py")], "what computes it is noted"
    assert command(["stimulus", "flicker.py", "--set", "flicker.rows=24", "--out", "f.avi"]) == 0
    assert "9 frames of 30x24 px" in capsys.readouterr().out
    assert command(["play", "flicker.py", "--no-view", "--record", "f.rrd"]) == 0
    assert command(["check", "flicker.py"]) == 0
    assert "flicker keeps all 7 laws" in capsys.readouterr().out
