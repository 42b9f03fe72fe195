"""What a model responds is its own, whichever other models see the frames."""

from dataclasses import replace

import cv2
import pytest

from dsnn import DSNN
from experiments.declare.conditions import Condition, Hand
from experiments.declare.experiment import visit
from experiments.kinds import episodes as behave
from experiments.paper.benchmark import entry as benchmark
from experiments.settings.settings import watchers
from experiments.show.play import play
from experiments.store.asked import Asked
from tests.experiments.show.test_trial import trial_of

SHOWN = (
    "dsnn",
    "dsnn:k_sig=0.03,t_sp=0.05",
    "dsnn-on-blocked",
    "dsnn:n_con=2,tau_mp=20",
    "emd",
    "emd:gain=3,log=false",
)
COMMANDS = ((0, "stimulus", 9.0, 0.0),)
STEADY = Hand(40, (8.0, 5.0, -90.0), (0.0, 0.0, 0.0), COMMANDS)


def by_hand(hand):
    return visit(hand).conditions()[0]


CROSSING = Condition("translation", "rightward", 35.0, 8.0)


def test_models_that_share_a_network_or_its_front_respond_as_if_each_was_alone(monkeypatch):
    """They share what does not differ."""
    respond, follow, steps, follows = DSNN._respond, DSNN.follow, [], []
    monkeypatch.setattr(DSNN, "_respond", lambda *given: steps.append(1) or respond(*given))
    monkeypatch.setattr(DSNN, "follow", lambda *given: follows.append(1) or follow(*given))

    def responses(*models):
        frames = play(trial_of(CROSSING, models=models)).frames
        return {model.label: frames.filter(model=model.label) for model in models}

    models = watchers(SHOWN)
    together = responses(*models)
    assert (len(steps), len(follows)) == (2 * together["dsnn"].height, 1)
    for model in models[1:]:
        assert together[model.label].equals(responses(model)[model.label]), model.label


def trial():
    return play(trial_of(by_hand(replace(STEADY, frames=2)), models=watchers(("emd",))))


def episode():
    options = {"env": "Optomotor", "baselines": False, "steps": 2}
    planned = behave.plan(Asked(kind="episodes", what=("straight",), repeats=1, options=options))
    return planned.work(planned.trials[0])


def costs():
    return benchmark.time_models(watchers(("emd",)), (24, 32))


@pytest.mark.parametrize("work", [trial, episode, costs])
def test_a_caller_s_threads_are_put_back(work):
    before = cv2.getNumThreads()
    cv2.setNumThreads(before + 2)
    try:
        assert work()
        assert cv2.getNumThreads() == before + 2
    finally:
        cv2.setNumThreads(before)
