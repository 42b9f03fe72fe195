"""``--set`` reaches every parameter, and refuses with the range."""

import dataclasses

import pytest
from pydantic import ValidationError

from colias_sim import CameraConfig, RobotConfig
from dsnn import DSNNParams, LPLC2Params
from experiments import NAMES, Angular, Clutter, Contrast, Egomotion, Translation
from experiments.bench import registry
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import family
from experiments.bench.trials import configure, parameters, plan


def configured(*assignments):
    return configure(registry.load("speed"), ["dsnn"], assignments)


def test_defaults_are_the_robot_preset():
    experiment, settings = configured()
    assert settings.models[0].network.t_sp == 0.2
    assert experiment.design.speeds_cm_s == (2, 4, 6, 10)


def test_every_section_is_reached():
    experiment, settings = configured(
        "dsnn.n_con=6", "dsnn.tau_s=200,10", "dsnn.fdsr=false", "robot.track_cm=3", "camera.read_noise=0",
        "scene.arena=dim", "experiment.direction=both", "experiment.speeds_cm_s=5", "experiment.pose_sd_mm=0",
    )  # fmt: skip
    assert (settings.models[0].network.n_con, settings.models[0].network.tau_s, settings.models[0].network.fdsr) == (
        6,
        (200.0, 10.0),
        False,
    )
    assert (settings.robot.track_cm, settings.camera.read_noise, settings.scene.arena) == (3.0, 0.0, "dim")
    assert (experiment.design.direction, experiment.design.speeds_cm_s, settings.pose_sd_mm) == ("both", (5.0,), 0.0)


def test_every_listed_parameter_can_be_set_to_what_it_is():
    listed = list(parameters(registry.load("speed"), ["dsnn"]))
    assert len(listed) > 40
    assert all(row.description for row in listed)
    assert configured(*(f"{row.key}={row.value}" for row in listed)) == configured()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dsnn.n_con=0", "between 1 and 64"),
        ("dsnn.n_con=2.5", "whole number"),
        ("dsnn.n_kon=6", "nearest: dsnn.n_con"),
        ("n_con=6", "nearest: dsnn.n_con"),
        ("dsnn.n_con", "SECTION.NAME=VALUE"),
        ("dsnn.w_i=nan", "between 0 and 1"),
        ("dsnn.k_sig=0", "above 0"),
        ("dsnn.tau_s=10", "2 values"),
        ("scene.arena=brigth", "nearest: bright"),
        ("experiment.speeds_cm_s=-2", "between 0.5 and 35"),
        ("experiment.direction=up", "rightward, leftward, both"),
        ("experiment.speeds_cm_s=6,6", "6 cm/s at 8 cm' is there twice"),
        ("camera.fps=0", "between 5 and 120"),
    ],
)
def test_refusals_name_value_and_range(text, says):
    with pytest.raises(UsageError) as caught:
        configured(text)
    assert f"--set {text}" in str(caught.value) or "--set: experiment speed" in str(caught.value)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_preset_comes_first_whatever_the_order():
    _, settings = configured("robot.dead_band=0", "robot.preset=colias4", "robot.open_loop=false")
    robot = RobotConfig.preset("colias4")
    assert settings.robot == dataclasses.replace(robot, dead_band=0, open_loop=False)
    assert configured("robot.preset=default") == configured() != configured("robot.preset=colias4")
    listed = {row.key: row for row in parameters(registry.load("speed"), ["dsnn"])}
    assert (listed["robot.preset"].value, listed["robot.preset"].legal) == ("default", "default, colias4")


@pytest.mark.parametrize("name", NAMES)
def test_every_experiment_is_a_whole_declaration(name):
    """Conformance: the name is its file's, every condition is distinct, every claim has words and a judge."""
    from experiments.bench.sources.robot_claims import paper_claims

    experiment = registry.load(name)
    assert experiment.name == name
    conditions = experiment.design.conditions()
    assert len(set(conditions)) == len(conditions) > 0
    assert len({getattr(c, experiment.varies) for c in conditions}) > 1
    assert experiment.repeats == 10
    assert set(experiment.claims) <= set(paper_claims())
    assert dataclasses.is_dataclass(experiment.design)


def test_models_have_sections_of_their_own_and_families_share_one():
    three = ["dsnn", "dsnn-reference", "dsn2017"]
    _, settings = configure(registry.load("speed"), three, ["dsnn.n_con=6", "dsn2017.n_con=4"])
    assert [m.network.n_con for m in settings.models] == [6, 6, 4]
    assert [m.network.fdsr for m in settings.models] == [True, True, False]
    _, settings = configure(registry.load("speed"), ["dsnn", "dsnn"], [])
    assert [m.label for m in settings.models] == ["dsnn"], "the same under the same settings: shown once"


@pytest.mark.parametrize("name", NAMES)
def test_every_experiment_can_run_as_declared(name):
    trial_plan = plan(registry.load(name), ["dsnn"], [], 1, 0)
    assert trial_plan.frames() > 30 * len(trial_plan.specs())


def test_a_model_with_parameters_of_its_own_is_a_family_of_its_own():
    names = ("dsnn-reference", "dsnn:w_i=1", "lplc2", "lplc2-gf:fps=100", "si-lgmd1", "si-lgmd2", "of-a-user",
             "dsnn-of-a-user")  # fmt: skip
    assert [family(name) for name in names] == [
        "dsnn", "dsnn", "lplc2", "lplc2-gf", "si-lgmd1", "si-lgmd2", "of-a-user", "dsnn",
    ]  # fmt: skip
    assert family("dsnn-of-a-user", DSNNParams) == "dsnn"
    assert family("dsnn-of-a-user", LPLC2Params) == "dsnn-of-a-user"


@pytest.mark.parametrize(
    "kind", [Translation, Angular, Contrast, Clutter, Egomotion, CameraConfig], ids=lambda kind: kind.__name__
)
def test_one_wrong_value_of_several_is_one_error(kind):
    """Pydantic counts the values that are left, and would tell of too few as well."""
    with pytest.raises(ValidationError) as refused:
        kind(**{field.name: (10**9,) for field in dataclasses.fields(kind)})
    places = [error["loc"] for error in refused.value.errors() if error["type"] != "missing"]
    wrong = [name for name, *index in places if index]
    assert wrong and not {(name,) for name in wrong} & {*places}
