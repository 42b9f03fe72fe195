"""Driving by hand: what is seen, what is recorded, what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.bench.cli.main import command
from experiments.bench.live.arena import START
from experiments.bench.live.arena import ArenaSession as Session
from experiments.bench.result import load
from experiments.bench.run.errors import UsageError
from experiments.bench.sources import visit
from experiments.bench.sources.hand import Command, Hand

T = 0.2
"""The robot's spiking threshold of the DSNN."""


def hs(session: Session, frames: int, model: str = "dsnn") -> list[float]:
    answers = [session.step().answers[model] for _ in range(frames)]
    return [answer.hs for answer in answers if answer is not None]


def test_rightward_passes_t_and_leftward_minus_t():
    session = Session(["dsnn"])
    assert max(map(abs, hs(session, 20))) < T  # nothing moves
    session.drive("stimulus", 1.0)
    there = hs(session, 75)
    session.drive("stimulus", -1.0)
    back = hs(session, 75)
    assert max(there) > T and min(there) > -T
    assert min(back) < -T


def test_a_recording_is_the_visit_bit_for_bit_and_so_is_its_repetition(tmp_path: Path):
    session = Session(["dsnn", "emd"], ["scene.light=0.8"], seed=3)
    session.drive("stimulus", 1.0)
    seen = hs(session, 40)
    session.change("dsnn", "w_i", "0.3")
    session.drive("observer", 0.2, 15.0)
    seen += hs(session, 30)
    session.send("stimulus", 15.0, 2.0)
    session.behave("fixation")
    seen += hs(session, 30)
    done = session.record(tmp_path / "run")
    rows = done.frames.to_dicts()
    assert [row["hs"] for row in rows if row["model"] == "dsnn"] == seen
    assert done.description["paths"], "commands and changes by frame"
    assert load(tmp_path / "run").kind == "trials"
    repetition = ["--out", str(tmp_path / "again"), "--workers", "0", "-q"]
    assert command(["run", "--again", str(tmp_path / "run"), *repetition]) == 0
    assert load(tmp_path / "again").frames.equals(load(tmp_path / "run").frames)


def test_another_command_is_no_equal_repetition(tmp_path: Path):
    session = Session(["dsnn"])
    session.drive("stimulus", 1.0)
    seen = hs(session, 60)
    hand = session.hand()
    slower = Hand(hand.frames, hand.stimulus, hand.observer, (Command(0, "stimulus", 7.9, 0.0),))
    import experiments

    done = experiments.run(visit.visit(slower), workers=0, quiet=True, out=tmp_path / "run", recordings=False)
    assert done.frames["hs"].to_list() != seen


def test_a_parameter_changes_the_answer_and_comes_back():
    session = Session(["dsnn"])
    session.drive("stimulus", 1.0)
    as_set = max(hs(session, 70))
    session.begin(START)
    session.change("dsnn", "t_sp", "0.9")
    session.drive("stimulus", 1.0)
    spikes = [view.answers["dsnn"].hs_spikes for view in (session.step() for _ in range(70))]  # type: ignore[union-attr]
    assert as_set > T and not any(spikes)
    session.reset_parameters()
    session.drive("stimulus", -1.0)
    assert any(session.step().answers["dsnn"].hs_spikes for _ in range(70))  # type: ignore[union-attr]


@pytest.mark.parametrize(
    "refused",
    [
        lambda s: s.change("dsnn", "w_i", "nan"),
        lambda s: s.change("dsnn", "t_sp", "-1"),
        lambda s: s.change("dsnn", "no_such", "1"),
        lambda s: s.change("../etc", "w_i", "1"),
        lambda s: s.set("scene.light", "1e9"),
        lambda s: s.set("no.such", "1"),
        lambda s: s.send("stimulus", float("nan"), 0.0),
        lambda s: s.send("stimulus", 1e6, 0.0),
        lambda s: s.set_speed(float("inf")),
        lambda s: s.behave("still"),
        lambda s: s.behave("no-such-behaviour"),
        lambda s: s.choose_models(["no-such-model"]),
        lambda s: s.show("no-such-experiment"),
        lambda s: s.show("speed", 10_000),
    ],
)
def test_what_is_refused_changes_nothing(refused):
    session = Session(["dsnn"])
    session.drive("stimulus", 1.0)
    hs(session, 5)
    trial, hand, settings = session.trial, session.hand(), dict(session.settings)
    with pytest.raises(UsageError) as refusal:
        refused(session)
    assert "\n" not in str(refusal.value)
    assert (session.trial, session.hand(), session.settings, session.values) == (trial, hand, settings, {})


def test_a_behaviour_takes_the_observer_and_gives_it_back():
    session = Session(["dsnn"])
    session.behave("avoidance")
    hs(session, 20)
    assert any(c.robot == "observer" and (c.speed_cm_s or c.turn_deg_s) for c in session.hand().commands)
    session.behave("")
    hs(session, 2)
    last = [c for c in session.hand().commands if c.robot == "observer"][-1]
    assert (last.speed_cm_s, last.turn_deg_s) == (0.0, 0.0)


def test_a_condition_is_looped_as_colias_run_runs_it(tmp_path: Path):
    import experiments

    session = Session(["dsnn"])
    session.show("general")
    looped = []
    while not session.trial.drive.over:
        looped += hs(session, 1)
    assert session.step().number == 0
    with pytest.raises(UsageError, match="colias run general"):
        session.record(tmp_path / "none")
    run = experiments.run("general", repeats=1, workers=0, quiet=True, recordings=False, out=tmp_path / "run")
    rows = [row["hs"] for row in run.frames.to_dicts() if row["trial"] == 0 and row["model"] == "dsnn"]
    assert looped == rows


def test_the_world_goes_back_to_what_the_command_gave():
    session = Session(["dsnn"], ["scene.light=0.7", "dsnn.w_i=0.5"])
    session.set("scene.light", "0.4")
    session.set("camera.read_noise", "3")
    session.reset_world()
    assert session.settings == {"scene.light": "0.7", "dsnn.w_i": "0.5"}
    session.choose_models(["emd"])  # a parameter of a model that goes, goes with it
    assert session.settings == {"scene.light": "0.7"}


def test_an_arena_of_ones_own_stands_in_the_trial_and_is_recorded(tmp_path: Path):
    arena = tmp_path / "pillar.xml"
    arena.write_text(
        '<mujoco model="pillar"><include file="bright.xml"/><worldbody>'
        '<geom name="pillar" type="cylinder" size="0.01 0.04" pos="0.18 0 0.04"/></worldbody></mujoco>'
    )
    session = Session(["dsnn"], [f"scene.arena={arena}"])
    assert [geom.name for geom in (session.trial.sim.model.geom(i) for i in range(5))].count("pillar") == 1
    session.drive("stimulus", 1.0)
    seen = hs(session, 40)
    done = session.record(tmp_path / "run")
    assert [row["hs"] for row in done.frames.to_dicts()] == seen


def test_robots_stop_before_the_wall_and_before_each_other():
    session = Session(["dsnn"])
    session.set_speed(30.0)
    session.send("stimulus", 3.0, 0.0)  # where the observer is in the way
    hs(session, 120)
    robots = session.trial.sim.robots
    stimulus, observer = robots["stimulus"].pose, robots["observer"].pose
    assert ((stimulus.x - observer.x) ** 2 + (stimulus.y - observer.y) ** 2) ** 0.5 > 0.04
    session.drive("stimulus", 1.0)
    hs(session, 150)
    stimulus = robots["stimulus"].pose
    assert (stimulus.x**2 + stimulus.y**2) ** 0.5 < 0.45
