"""Every model, stimulus and arena that ships keeps the laws, and each mistake breaks the law that names it."""

import dataclasses
import itertools
import re

import numpy as np
import pytest

from dsnn import MODELS, ModelEntry, Response
from dsnn.frames import luma
from dsnn.stimuli import STIMULI, Box, ClipParams, Stimulus, StimulusEntry, StimulusFrame, Truth
from experiments.cli import check
from experiments.cli.check import try_laws
from experiments.cli.main import command
from experiments.settings.models import ConfiguredModel, choose
from scenes import ARENAS
from tests.helpers.arenas import written


@pytest.mark.parametrize("law", check.MODELS)
@pytest.mark.parametrize("name", MODELS)
def test_a_model_keeps_the_law(name, law):
    law(choose(name, "offline"))


@pytest.mark.parametrize("law", check.STIMULI)
@pytest.mark.parametrize("name", STIMULI)
def test_a_stimulus_keeps_the_law(name, law):
    """At few pixels and frames a second: the laws are the same, and painting is cheap."""
    entry = STIMULI[name]
    law(dataclasses.replace(entry, params=dataclasses.replace(entry.params, rows=48, columns=80, fps=10)))


@pytest.mark.parametrize("law", check.ARENAS)
@pytest.mark.parametrize("name", ARENAS)
def test_an_arena_keeps_the_law(name, law):
    law(name)


def test_an_arena_that_hides_the_robot_breaks_its_law(tmp_path):
    lid = written(tmp_path, '<geom type="box" size="0.002 0.03 0.03" pos="0.03 0 0.03"/>')
    assert broken(check.ARENAS, lid) == {"camera"}


def broken(laws, subject):
    return {law.__name__ for law, trouble in try_laws(laws, subject).items() if trouble}


# --- models with one mistake each -------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Nothing:
    t_sp: float = 0.2


class Sound:
    """Correlates change in time with slope in space."""

    spikes = 1

    def __init__(self, shape, parameters):
        self.shape, self.last = shape, None

    def reset(self):
        self.last = None

    def take(self, frame):
        return luma(frame, self.shape).astype(float)

    def step(self, frame, *, channels="grey", maps=False):
        now = self.take(frame)
        change = 0.0 if self.last is None else now - self.last
        self.last = now
        down, right = np.gradient(np.asarray(now, float))
        return self.answer(*(float(np.tanh(-(change * slope).mean())) for slope in (right, down)))

    def answer(self, hs, vs):
        return Response(hs, vs, *(self.spikes * int(abs(v) >= 0.2) * int(np.sign(v)) for v in (hs, vs)))


def made(channels=("hs", "vs"), params=Nothing(), **methods):
    """A model of the kind of `Sound`, with other methods."""
    entry = ModelEntry("made", "made up", type("Made", (Sound,), methods), params, channels)
    return ConfiguredModel("made", "made", params, entry)


def writing(self, frame):
    frame[:] = 0
    return frame


NAMELESS = dataclasses.make_dataclass("Nameless", [("theta", float, 0.2)], frozen=True)()
MISTAKES = {
    "sound": (made(), set()),
    "forgetful": (made(reset=lambda self: None), {"reset"}),
    "random": (
        made(answer=lambda self, hs, vs: Response(hs=float(np.random.default_rng().random() * 1e-3))),
        {"reset", "determinism", "buffer", "stillness", "mirror"},
    ),
    "holding": (made(take=lambda self, frame: luma(frame, self.shape)), {"buffer"}),
    "biased": (made(answer=lambda self, hs, vs: Sound.answer(self, hs, 0.1)), {"stillness", "mirror"}),
    "one-sided": (made(answer=lambda self, hs, vs: Sound.answer(self, abs(hs), vs)), {"mirror"}),
    "lenient": (made(take=lambda self, frame: np.resize(frame, self.shape).astype(float)), {"refusal"}),
    "infinite": (made(answer=lambda self, hs, vs: Response(hs=np.inf)), {"answers"}),
    "failing": (made(take=lambda self, frame: 1 / 0), {"answers"}),
    "writing": (made(take=writing), {"answers"}),
    "undeclared": (made(answer=lambda self, hs, vs: Response(hs, vs, azimuth=hs)), {"declaration"}),
    "without spikes": (made(spikes=0), {"declaration"}),
    "spikes without a threshold": (made(params=NAMELESS), {"declaration"}),
    "looming beyond 1": (made(("looming",), answer=lambda self, hs, vs: Response(looming=1.2)), {"answers"}),
    "looming to a side": (
        made(("looming",), answer=lambda self, hs, vs: Response(looming=0.5 + 0.5 * max(hs, 0.0))),
        {"declaration", "mirror"},
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_model_s_mistake_breaks_its_law(mistake):
    model, expected = MISTAKES[mistake]
    found = broken(check.MODELS, model)
    assert found == expected or (expected == {"answers"} <= found), found  # of one that fails, what is built on it


# --- stimuli with one mistake each ------------------------------------------------------------------------------------

SPEED = 60.0
GREYS = itertools.cycle(range(100, 200))


class Square(Stimulus[ClipParams]):
    """A dark square goes right, 2 px a frame."""

    velocity, word, shift = SPEED, "rightward", 0

    def __init__(self, *arguments):
        super().__init__(*arguments)
        self.grey = next(GREYS)  # another for each object

    def __len__(self):
        return 12

    def paint(self, index, left):
        picture = np.full(self.shape, 255, np.uint8)
        picture[10:18, left : left + 8] = 0
        return picture

    def frame(self, index):
        left = 10.0 + SPEED * index / self.fps
        truth = Truth(self.word, Box(left, 10.0, 8.0, 8.0), (self.velocity, 0.0))
        return StimulusFrame(self.paint(index, int(left)), truth)


def accumulating(self, index, left):
    self.shift += 1
    return np.roll(Square.paint(self, index, left), self.shift % 3, axis=0)


def drawn(grey, row, column=None):
    """Return a method that paints one more pixel; at the square where no column is given."""

    def paint(self, index, left):
        picture = Square.paint(self, index, left)
        picture[row, left + 2 if column is None else index] = grey or self.grey
        return picture

    return paint


def panorama(speed):
    """Return a method that paints noise which moves by 2 px a frame, and says that it moves at a speed."""
    noise = np.random.default_rng(0).integers(0, 256, (180, 320), np.uint8)

    def frame(self, index):
        truth = Truth("panorama", background_velocity=(speed, 0.0))
        return StimulusFrame(np.roll(noise, 2 * index, axis=1)[: self.shape[0], : self.shape[1]], truth)

    return frame


FLAWS = {
    "none": ({}, set()),
    "floats": ({"paint": lambda *of: Square.paint(*of).astype(float)}, {"frames"}),
    "accumulating": ({"paint": accumulating}, {"order"}),
    "unseeded": ({"paint": drawn(0, 12)}, {"seeds"}),
    "of one shape": ({"shape": (180, 320)}, {"frames"}),
    "wordless": ({"word": ""}, {"truth"}),
    "not a number": ({"velocity": np.nan}, {"truth"}),
    "panorama": ({"frame": panorama(SPEED)}, set()),
    "panorama of the other sign": ({"frame": panorama(-SPEED)}, {"truth"}),
    "leaking": ({"paint": drawn(1, 0, 0)}, {"place"}),
    "slow": ({"velocity": SPEED / 3}, {"velocity"}),
    "raising": ({"paint": lambda *of: 1 / 0}, {"frames"}),
}


@pytest.mark.parametrize("flaw", FLAWS)
def test_a_stimulus_s_mistake_breaks_its_law(flaw):
    methods, expected = FLAWS[flaw]
    found = broken(check.STIMULI, StimulusEntry("s", "", type("Flawed", (Square,), methods), ClipParams()))
    assert expected <= found and bool(found) == bool(expected), found


def test_a_model_that_is_checked_is_shown_one_clip_and_its_controls():
    lines = {
        line.split()[0]: dict(re.findall(r"(\w+) (-?[\d.]+)", line[13:])) for line in check.vision(choose("hybrid"))
    }
    for channel in ("hs", "vs"):
        shown, frozen, absent, mirrored, backward = map(float, lines[channel].values())
        assert frozen == absent == 0.0 and shown > 0.0 > max(mirrored, backward)
    assert lines["looming"]["frozen"] == lines["looming"]["absent"] == "0.5" and float(lines["looming"]["shown"]) > 0.5


def test_the_command_ends_with_1_where_a_law_is_broken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert [command(["check", name]) for name in ("edge", "emd", "drum")] == [0, 0, 0]
    assert command(["new", "model", "bad"]) == 0
    text = (tmp_path / "bad.py").read_text()
    (tmp_path / "bad.py").write_text(text.replace("    def reset(self)", "    def unused(self)"))
    assert command(["check", "bad.py"]) == 1
