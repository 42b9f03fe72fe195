"""Footage behind the page: the answers of colias watch, and what cannot be shown."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import polars as pl
import pytest

from experiments.bench.cli.main import command
from experiments.bench.live.footage import FootageSession
from experiments.bench.run.errors import TrialError
from tests.helpers.footage import Walker, street, write

FRAMES = 60


@pytest.fixture(scope="module")
def film(tmp_path_factory: pytest.TempPathFactory) -> str:
    return str(write(tmp_path_factory.mktemp("film") / "street.avi", street([Walker(4.0)], FRAMES)))


def hs(session: FootageSession, frames: int, model: str = "dsnn") -> list[float]:
    answers = [session.step().answers[model] for _ in range(frames)]
    return [answer.hs for answer in answers if answer is not None]


def test_the_answers_are_those_of_colias_watch(film: str, tmp_path: Path):
    session = FootageSession(film, ["dsnn", "emd"], ["dsnn.w_i=0.5"])
    answers = hs(session, FRAMES)
    session.change("emd", session_parameter(session), "2")
    told = session.command().split()
    assert told[:3] == ["colias", "watch", film] and "dsnn.w_i=0.5" in told and told[-1].startswith("emd.")
    session.close()
    assert command([*told[1:], "--no-view", "-q", "--out", str(tmp_path / "watched")]) == 0
    rows = pl.read_parquet(tmp_path / "watched" / "frames.parquet")
    assert answers == rows.filter(pl.col("model") == "dsnn")["hs"].to_list()
    assert max(map(abs, answers)) > 0.1, "nothing moved"


def session_parameter(session: FootageSession) -> str:
    """A whole-number parameter of the second model."""
    network = session.watching[1].network
    return next(f.name for f in dataclasses.fields(network) if type(getattr(network, f.name)) is int)


def test_a_file_begins_again_and_other_models_go_on(film: str):
    session = FootageSession(film, ["dsnn"])
    first = hs(session, FRAMES)
    assert hs(session, FRAMES) == first
    begun = session.step()
    assert begun.number == 0 and begun.time_s == 0.0 and not begun.poses
    session.choose_models(["emd"])
    assert session.step().time_s > 0.0, "the next frame, not the first"
    session.begin()
    assert session.step().time_s == 0.0
    session.show_maps(True)
    session.choose_models(["dsnn"])
    assert session.step().answers["dsnn"].maps is not None  # type: ignore[union-attr]
    session.close()


def test_a_changed_parameter_stays_when_the_file_begins_again(film: str):
    session = FootageSession(film, ["dsnn"])
    session.change("dsnn", "t_sp", "0.9")
    for _ in range(FRAMES + 1):
        session.step()
    assert session.watching[0].network.t_sp == 0.9
    session.reset_parameters()
    assert session.watching[0].network.t_sp < 0.9 and not session.values
    session.close()


def test_a_parameter_of_a_model_that_goes_goes_with_it(film: str):
    session = FootageSession(film, ["dsnn"], ["dsnn.w_i=0.5"])
    session.choose_models(["emd"])
    assert "dsnn.w_i" not in session.command()
    session.close()


def test_a_model_that_breaks_is_told_and_the_session_lives(film: str, tmp_path: Path):
    broken = tmp_path / "broken.py"
    broken.write_text(
        "from dataclasses import dataclass\nfrom dsnn import ModelEntry\n"
        "@dataclass(frozen=True)\nclass Parameters:\n    gain: float = 1.0\n"
        "    def build(self, shape):\n        return self\n"
        "class Network:\n    def __init__(self, shape, parameters):\n        pass\n"
        "    def step(self, frame):\n        raise ValueError('no answer')\n"
        "MODEL = ModelEntry('broken', 'breaks', Network, Parameters())\n"
    )
    session = FootageSession(film, [str(broken)])
    with pytest.raises(TrialError, match="no answer"):
        session.step()
    session.choose_models(["dsnn"])
    assert hs(session, 3)
    session.close()
