"""``--set`` reaches every parameter, and refuses with the range."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from colias_sim import RobotConfig, SceneConfig
from colias_sim.envs.options import EnvOptions
from experiments import Condition, Experiment
from experiments.base.errors import UsageError
from experiments.base.files import to_json
from experiments.base.values import by_key, key_values
from experiments.kinds import registry
from experiments.kinds.tables import NAMES
from experiments.settings.settings import configure, described, sections
from experiments.store.asked import ASKED
from tests.helpers.plans import planned


def configured(*assignments):
    return configure(registry.load("speed"), ["dsnn"], key_values(assignments))


def test_every_section_is_reached():
    experiment, settings = configured(
        "dsnn.n_con=6", "dsnn.tau_s=200,10", "dsnn.fdsr=false", "robot.track_cm=3", "camera.read_noise=0",
        "scene.arena=dim", "experiment.direction=both", "experiment.speeds_cm_s=5", "experiment.pose_sd_mm=0",
    )  # fmt: skip
    network = settings.models[0].network
    assert (network.n_con, network.tau_s, network.fdsr) == (6, (200.0, 10.0), False)
    assert (settings.robot.track_cm, settings.camera.read_noise, settings.scene.arena) == (3.0, 0.0, "dim")
    assert (experiment.design.direction, experiment.design.speeds_cm_s, settings.pose_sd_mm) == ("both", (5.0,), 0.0)


def test_every_listed_parameter_can_be_set_to_what_it_is():
    listed = list(described(sections(registry.load("speed"), ["dsnn"])))
    assert len(listed) > 40
    assert all(row["description"] for row in listed)
    assert configured(*(f"{row['key']}={row['value']}" for row in listed)) == configured()


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("dsnn.n_con=0", "between 1 and 64"),
        ("dsnn.n_kon=6", "nearest: dsnn.n_con"),
        ("dsnn.n_con", "SECTION.NAME=VALUE"),
        ("dsnn.w_i=nan", "between 0 and 1"),
        ("scene.arena=brigth", "nearest: bright"),
        ("experiment.speeds_cm_s=6,6", "6 cm/s at 8 cm' is there twice"),
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
    listed = {row["key"]: row for row in described(sections(registry.load("speed"), ["dsnn"]))}
    assert (listed["robot.preset"]["value"], listed["robot.preset"]["legal"]) == ("default", "default, colias4")


@pytest.mark.parametrize("name", NAMES)
def test_every_experiment_is_a_whole_declaration(name):
    """Conformance: the name is its file's, every condition is distinct, and it can run."""
    experiment = registry.load(name)
    assert experiment.name == name
    conditions = experiment.design.conditions()
    assert len(set(conditions)) == len(conditions) > 0
    assert len({getattr(c, experiment.varies) for c in conditions}) > 1
    assert experiment.repeats == 10
    assert len(planned(name, ["dsnn"], repeats=1).trials) == len(conditions), "it can run as declared"


def test_models_have_sections_of_their_own_and_families_share_one():
    three = ["dsnn", "dsnn-reference", "dsn2017"]
    _, settings = configure(registry.load("speed"), three, {"dsnn.n_con": 6, "dsn2017.n_con": "4"})
    assert [m.network.n_con for m in settings.models] == [6, 6, 4]
    assert [m.network.fdsr for m in settings.models] == [True, True, False]
    _, settings = configure(registry.load("speed"), ["dsnn", "dsnn"], {})
    assert [m.label for m in settings.models] == ["dsnn"], "the same under the same settings: shown once"


# --- from Python ------------------------------------------------------------------------------------------------------


@dataclasses.dataclass(frozen=True)
class Design:
    """A design of a user's own, with texts and paths."""

    names: tuple[str, ...] = ("North wall", "b")
    listed: list[str] = dataclasses.field(default_factory=lambda: ["x"])
    picture: Path = Path("In/Here.PNG")
    sizes: tuple[float, ...] = (0.123456789, 1e6)
    note: str | None = "Any"
    turned: bool = True
    pose_sd_mm: float = 0.5
    heading_sd_deg: float = 0.0

    def conditions(self):
        yield Condition("translation", "rightward", 20.0, 6.0)


OWN = Experiment("own", "own", Design(), "speed_cm_s", repeats=1)


@pytest.mark.parametrize(
    ("settings", "changes"),
    [
        ({"experiment.picture": Path("/Data/Wall.PNG")}, {"picture": Path("/Data/Wall.PNG")}),
        ({"experiment.names": (name for name in ("One", "Two"))}, {"names": ("One", "Two")}),
        ({"experiment.names": [Path("A/B"), "c"]}, {"names": ("A/B", "c")}),
        (
            {"experiment": {"sizes": np.array([0.1, 0.25]), "turned": np.False_}},
            {"sizes": (0.1, 0.25), "turned": False},
        ),
        ({"experiment.note": b"Bytes", "experiment.turned": False}, {"note": "Bytes", "turned": False}),
        ({"experiment.pose_sd_mm": np.float64(0.1)}, {"pose_sd_mm": 0.1}),
        ({"experiment": {"names": ["a,b", "c"], "note": None}}, {"names": ("a,b", "c"), "note": None}),
        ({"experiment.sizes": np.int64(3)}, {"sizes": (3.0,)}),
    ],
)
def test_values_of_python_arrive_as_they_are(settings, changes):
    whole, _ = configure(OWN, ["dsnn"], by_key(settings))
    assert whole.design == dataclasses.replace(Design(), **changes)


@pytest.mark.parametrize("value", [[[1, 2], [3, 4]], {"a": 1}, None])
def test_values_of_another_type_are_refused_by_their_key(value):
    with pytest.raises(UsageError, match=r"experiment\.names"):
        configure(OWN, ["dsnn"], by_key({"experiment.names": value}))


def test_a_call_and_a_command_have_one_document():
    given = {"dsnn": {"n_con": np.int64(6), "tau_s": (200.0, 10.0)}, "camera.read_noise": 0, "dsnn.fdsr": False}
    typed = ("dsnn.n_con=6", "dsnn.tau_s=200,10", "camera.read_noise=0", "dsnn.fdsr=false")
    called, commanded = (to_json({**planned("speed", settings=settings).document(), ASKED: None})
                         for settings in (given, typed))  # fmt: skip
    assert called == commanded


def test_texts_of_a_design_are_listed_as_they_are_set():
    listed = {row["key"]: row["value"] for row in described({"experiment": Design()})}
    assert listed["experiment.names"] == "North wall,b" and listed["experiment.sizes"] == "0.123456789,1e+06"
    whole, _ = configure(OWN, ["dsnn"], listed)
    assert whole.design == Design()


@pytest.mark.parametrize("lacking", [("pose_sd_mm",), ("heading_sd_deg", "pose_sd_mm")])
def test_a_design_without_spreads_is_refused_by_their_names(lacking):
    fields = [name for name in ("pose_sd_mm", "heading_sd_deg") if name not in lacking]
    bare = dataclasses.make_dataclass("Bare", [(name, float, 0.0) for name in fields], frozen=True,
                                      namespace={"conditions": Design.conditions})  # fmt: skip
    with pytest.raises(UsageError) as caught:
        planned(Experiment("own", "own", bare(), "speed_cm_s", file="/there/own.py"), ["dsnn"], repeats=1)
    assert all(text in str(caught.value) for text in ("/there/own.py", "Bare", *lacking))


def test_settings_of_a_declaration_are_read_in_every_plan():
    speeds = Experiment("own", "own", registry.load("speed").design, "speed_cm_s",
                        settings={"experiment.speeds_cm_s": (speed for speed in (20, 30))})  # fmt: skip
    for _ in range(2):
        assert configure(speeds, ["dsnn"], {})[0].design.speeds_cm_s == (20.0, 30.0)


def test_paths_are_places_of_pictures_and_arenas(tmp_path):
    for name in ("Wall.PNG", "Arena.xml"):
        (tmp_path / name).touch()
    wall, arena = tmp_path / "Wall.PNG", tmp_path / "Arena.xml"
    scene = SceneConfig(arena=arena, wall=wall, shell_picture=wall)
    assert scene == SceneConfig(arena=str(arena), wall=str(wall), shell_picture=str(wall))
    assert EnvOptions(arena=arena).arena == str(arena)
