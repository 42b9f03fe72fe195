"""Driving by hand behind the page: what is seen, what is recorded, what is refused."""

from pathlib import Path

import polars as pl
import pytest

import experiments
from experiments.base.errors import UsageError
from experiments.cli.main import command
from experiments.declare.conditions import Hand
from experiments.declare.experiment import visit
from experiments.live.session import START, Session
from tests.helpers.arenas import pillar, written

T = 0.2
"""The robot's spiking threshold of the DSNN."""


def hs(session: Session, frames: int, channel: str = "hs") -> list[float]:
    """Return HS, or another channel, of so many frames from now on."""
    seen = []
    for _ in range(frames):
        session.step()
        seen.append(getattr(session.responses["dsnn"], channel))
    return seen


def test_a_recording_is_the_visit_bit_for_bit_and_so_is_its_repetition(tmp_path: Path):
    arena = written(tmp_path, pillar(0.18, 0.0))
    session = Session(["dsnn", "emd"], {"scene.light": "0.8", "scene.arena": str(arena)}, seed=3)
    session.set("dsnn.w_i", "0.3")
    session.drive("stimulus", 1.0)
    seen = hs(session, 40)
    session.drive("observer", 0.2, 15.0)
    seen += hs(session, 30)
    session.drive("stimulus", -0.5, 20.0)
    seen += hs(session, 30)
    hand = session.hand()
    frames = session.record(tmp_path / "run").frames
    assert frames.filter(pl.col("model") == "dsnn")["hs"].to_list() == seen
    again = ["--out", str(tmp_path / "again"), "--workers", "0", "-q"]
    assert command(["run", "--again", str(tmp_path / "run"), *again]) == 0
    assert experiments.load(tmp_path / "again").frames.equals(frames)
    slower = Hand(40, hand.stimulus, hand.observer, ((0, "stimulus", 7.9, 0.0),))
    other = experiments.run(visit(slower), workers=0, quiet=True, out=tmp_path / "run2", recordings=False)
    assert other.frames["hs"].to_list() != seen[:40]


def test_a_parameter_begins_a_trial_where_robots_drive_on_and_comes_back():
    session = Session(["dsnn"])

    def responses():
        return zip(*((hs(session, 1)[0], session.responses["dsnn"].hs_spikes) for _ in range(75)), strict=True)

    assert max(map(abs, hs(session, 20))) < T  # nothing moves
    session.drive("stimulus", 1.0)
    session.set("dsnn.t_sp", "0.9")
    assert session.number == 0
    there, spikes = responses()
    assert max(there) > T and min(there) > -T and not any(spikes)
    session.drive("stimulus", -1.0)
    session.reset_parameters()
    back, spikes = responses()
    assert min(back) < -T and min(spikes) < 0


@pytest.mark.parametrize(
    "refused",
    [
        lambda s: s.set("dsnn.w_i", "nan"),
        lambda s: s.set("dsnn.no_such", "1"),
        lambda s: s.set("scene.light", "1e9"),
        lambda s: s.set("no.such", "1"),
    ],
)
def test_what_is_refused_changes_nothing(refused):
    session = Session(["dsnn"])
    session.drive("stimulus", 1.0)
    hs(session, 5)
    trial, hand, settings = session.trial, session.hand(), dict(session.settings)
    with pytest.raises(UsageError):
        refused(session)
    assert (session.trial, session.hand(), session.settings) == (trial, hand, settings)


def test_robots_stop_before_the_wall_and_before_each_other():
    session = Session(["dsnn"])
    session.speed_cm_s = 30.0
    session.begin({"stimulus": (12.0, 0.0, 180.0), "observer": (0.0, 0.0, 0.0)})
    session.drive("stimulus", 1.0)  # the observer is in the way
    hs(session, 120)
    stimulus, observer = session.poses["stimulus"], session.poses["observer"]
    assert ((stimulus.x - observer.x) ** 2 + (stimulus.y - observer.y) ** 2) ** 0.5 > 0.04
    session.drive("stimulus", -1.0)
    hs(session, 150)
    stimulus = session.poses["stimulus"]
    assert 0.35 < (stimulus.x**2 + stimulus.y**2) ** 0.5 < 0.45
    session.begin(START)
    assert session.number == 0 and session.poses["stimulus"].y == pytest.approx(0.11)


def test_a_visit_says_how_far_how_fast_and_which_way():
    """Four cm and three cm apart are five; twice as long at 2 as at 5 cm/s is 3 on average."""
    commands = ((0, "stimulus", -2.0, 0.0), (20, "stimulus", 5.0, 3.0), (25, "observer", 9.0, 0.0))
    hand = Hand(30, (5.0, 2.0, 90.0), (1.0, -1.0, 0.0), commands)
    (condition,) = visit(hand).conditions()
    assert (condition.distance_cm, condition.speed_cm_s, condition.direction) == (5.0, 3.0, "rightward")
