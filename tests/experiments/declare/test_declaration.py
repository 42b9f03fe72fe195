"""What an experiment may declare, refused in one line otherwise."""

import pytest

from experiments.declare.conditions import Condition
from experiments.declare.experiment import Experiment, Translation
from experiments.settings.settings import configure, described, sections
from tests.helpers import user_files

GOOD = {"motion": "translation", "direction": "rightward", "speed_cm_s": 6.0, "distance_cm": 8.0}


@pytest.mark.parametrize(
    "changes",
    [
        {"motion": "teleport"},
        {"direction": "up"},
        {"direction": "straight"},
        {"speed_cm_s": 0.0},
        {"speed_cm_s": float("nan")},
        {"distance_cm": None},
        {"shell_grey": 1.5},
        {"motion": "approach"},
        {"motion": "recession", "far_cm": 20.0},
        {"motion": "approach", "far_cm": 8.0, "angle_deg": 0.0},
    ],
    ids=str,
)
def test_a_condition_no_trial_can_have(changes):
    with pytest.raises(ValueError):
        Condition(**{**GOOD, **changes})


def test_a_model_named_like_a_family_with_other_parameters_has_a_section_of_its_own(tmp_path):
    path = tmp_path / "kin.py"
    path.write_text(user_files.MODEL.replace('"gradient"', '"dsnn-mine"'))
    experiment = Experiment("mine", "", Translation((6.0,), (8.0,)), "speed_cm_s")
    models = ["dsnn", "dsn2017", str(path)]
    keys = {row["key"] for row in described(sections(experiment, models))}
    assert {"dsnn.n_con", "dsnn-mine.gain"} <= keys and "dsnn.gain" not in keys
    _, settings = configure(experiment, models, {"dsnn-mine.gain": 2, "dsnn.n_con": "6"})
    assert settings.models[2].network.gain == 2.0
    assert settings.models[0].network.n_con == 6
