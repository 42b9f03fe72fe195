"""``colias check``: every registered model keeps the laws, and each mistake is named by the law that it breaks."""

import dataclasses

import numpy as np
import pytest

from dsnn import MODELS, ModelEntry, Response
from dsnn.frames import luma
from experiments.bench.cli.main import command
from experiments.bench.conformance import laws
from experiments.bench.conformance.notes import notes
from experiments.bench.run.models import ConfiguredModel, choose


@pytest.mark.parametrize("name", MODELS)
def test_every_registered_model_keeps_the_laws(name):
    assert [finding for finding in laws.check(choose(name, "offline")) if finding.trouble] == []
    assert notes(choose(name, "offline")) == []


@dataclasses.dataclass(frozen=True)
class Nothing:
    t_sp: float = 0.2


class Sound:
    """Correlates change in time with slope in space."""

    def __init__(self, shape, parameters):
        self.shape = shape
        self.last = None

    def reset(self):
        self.last = None

    def step(self, frame, *, channels="grey", maps=False):
        now = luma(frame, self.shape, channels).astype(float)
        change = 0.0 * now if self.last is None else now - self.last
        self.last = now
        down, right = np.gradient(now)
        return Response(*(float(np.tanh(-0.05 * (change * slope).mean())) for slope in (right, down)))


class Forgetful(Sound):
    def reset(self):
        pass


class Random(Sound):
    def step(self, frame, **of):
        return dataclasses.replace(super().step(frame, **of), hs=float(np.random.default_rng().random() * 1e-3))


class Holding(Sound):
    def step(self, frame, *, channels="grey", maps=False):
        before, self.last = self.last, frame
        change = 0.0 if before is None else np.asarray(frame, float) - before
        return Response(hs=float(np.tanh(np.mean(change * np.gradient(np.asarray(frame, float))[1]))))


class Biased(Sound):
    def step(self, frame, **of):
        return dataclasses.replace(super().step(frame, **of), vs=0.1)


class OneSided(Sound):
    def step(self, frame, **of):
        answer = super().step(frame, **of)
        return dataclasses.replace(answer, hs=abs(answer.hs))


class Lenient(Sound):
    def step(self, frame, **of):
        return super().step(np.resize(frame, self.shape), **of)


class Infinite(Sound):
    def step(self, frame, **of):
        return Response(hs=float("inf"))


class Failing(Sound):
    def step(self, frame, **of):
        raise RuntimeError("no more")


class Writing(Sound):
    def step(self, frame, **of):
        frame[:] = 0
        return super().step(frame, **of)


def checked(cls, monkeypatch, channels=("hs", "vs")):
    entry = ModelEntry("made", "made up", cls, Nothing(), channels=channels)
    monkeypatch.setattr("experiments.bench.run.models.load_model", lambda source: entry)
    return {finding.law: finding.trouble for finding in laws.check(ConfiguredModel("made", "made", Nothing()))}


def test_a_sound_model_keeps_them_all(monkeypatch):
    assert not any(checked(Sound, monkeypatch).values())


@pytest.mark.parametrize(
    ("cls", "law", "says"),
    [
        (Forgetful, "reset", "reset() has to forget every frame"),
        (Random, "determinism", "in frame 0 hs is"),
        (Holding, "buffer", "keep a copy"),
        (Biased, "stillness", "vs is 0.1 with 0 spikes in frame 0 of a still scene"),
        (OneSided, "mirror", "expected the other sign"),
        (Lenient, "refusal", "dsnn.frames.luma"),
        (Infinite, "answers", "in frame 0, hs is inf"),
        (Failing, "answers", "RuntimeError: no more"),
        (Writing, "answers", "read-only"),
    ],
)
def test_a_mistake_is_named_by_its_law(cls, law, says, monkeypatch):
    troubles = checked(cls, monkeypatch)
    assert says in troubles[law]
    if cls in (Forgetful, OneSided, Lenient):
        assert [name for name, trouble in troubles.items() if trouble] == [law], "and by no other"


def test_looming_has_a_range_and_knows_no_direction(monkeypatch):
    class Loud(Sound):
        def step(self, frame, **of):
            return Response(looming=1.2)

    class Sided(Sound):
        def step(self, frame, **of):
            hs = super().step(frame, **of).hs
            return Response(looming=0.5 + 0.5 * max(hs, 0.0))

    assert "legal is from 0.5" in checked(Loud, monkeypatch, ("looming",))["answers"]
    assert "mirror image" in checked(Sided, monkeypatch, ("looming",))["mirror"]


def test_the_command_ends_with_1_where_a_law_is_broken(tmp_path, capsys):
    (tmp_path / "bad.py").write_text(
        "from dataclasses import dataclass\nfrom dsnn import ModelEntry, Response\n\n\n"
        "@dataclass(frozen=True)\nclass P:\n    t_sp: float = 0.2\n\n\n"
        "class Bad:\n    def __init__(self, shape, p):\n        self.n = 0\n\n    def reset(self):\n        pass\n\n"
        "    def step(self, frame, **of):\n        self.n += 1\n        return Response(hs=self.n / 1000)\n\n\n"
        'MODEL = ModelEntry("bad", "counts frames", Bad, P())\n'
    )
    assert command(["check", "edge"]) == 0, "a stimulus that ships"
    assert command(["check", "emd"]) == 0
    assert "emd keeps all 7 laws" in capsys.readouterr().out
    assert command(["check", str(tmp_path / "bad.py")]) == 1
    printed = capsys.readouterr().out
    assert "reset        broken: in frame 0 hs is 0.0" in printed and "bad breaks" in printed


def test_what_is_dropped_and_what_never_spikes_is_noted(tmp_path, capsys):
    (tmp_path / "odd.py").write_text(
        "from dataclasses import dataclass\nimport numpy as np\nfrom dsnn import ModelEntry, Response\n\n\n"
        "@dataclass(frozen=True)\nclass P:\n    t_sp: float = 0.2\n    spikes: int = 0\n\n\n"
        "class Odd:\n    def __init__(self, shape, p):\n        self.p, self.last = p, None\n\n"
        "    def reset(self):\n        self.last = None\n\n"
        "    def step(self, frame, **of):\n        now = frame.astype(float)\n"
        "        change = 0.0 * now if self.last is None else now - self.last\n        self.last = now\n"
        "        hs = float(np.tanh(-(change * np.gradient(now)[1]).mean()))\n"
        "        return Response(hs=hs, hs_spikes=self.p.spikes * (abs(hs) > 0.2), azimuth=hs)\n\n\n"
        'MODEL = ModelEntry("odd", "odd", Odd, P(), channels=("hs",))\n'
    )
    command(["check", str(tmp_path / "odd.py")])
    printed = " ".join(capsys.readouterr().out.split())
    assert "note: answers azimuth, which is not declared: it is dropped" in printed
    assert "note: hs passes t_sp = 0.2 in " in printed
    assert "and hs_spikes stays 0: step itself returns the spikes" in printed
    command(["check", f"{tmp_path / 'odd.py'}:spikes=1"])
    assert "step itself" not in capsys.readouterr().out
