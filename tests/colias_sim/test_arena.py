"""Arenas of one's own, and those that ship: read alike, refused in one line, the same pixels, the units of MJCF."""

import math
import re

import cv2
import numpy as np
import pytest

from colias_sim import Pose, SceneConfig, Simulation
from colias_sim.obstacles import Obstacle, obstacles, outline
from colias_sim.scene import compile_arena
from tests.helpers.arenas import pillar, written

PILLAR = pillar(0.2, 0.05)
PICTURE = '<asset><texture name="t" type="2d" file="{}"/><material name="t" texture="t"/></asset>'


def seen(source, **scene):
    rng = np.random.default_rng(1)
    with Simulation(scene=SceneConfig(arena=source, light_sd=0.0, turn_wall=False, **scene)) as simulation:
        simulation.reset({"stimulus": Pose(0.12, 0.0, -math.pi / 2)}, rng)
        return simulation.step(rng).luma


def test_a_python_file_gives_the_pixels_of_the_mjcf_that_it_returns(tmp_path):
    source = written(tmp_path, PILLAR)
    (tmp_path / "own.py").write_text(f"def ARENA():\n    return {(tmp_path / 'own.xml').read_text()!r}\n")
    assert np.array_equal(seen(source), seen(str(tmp_path / "own.py")))


def test_an_obstacle_is_where_the_mjcf_says_and_is_seen_there(tmp_path):
    source = written(tmp_path, PILLAR)
    (pillar,) = obstacles(compile_arena(source))
    assert pillar.name == "pillar" and pillar.height == pytest.approx(0.08)
    assert pillar.nearest(0.0, 0.0)[0] == pytest.approx(math.hypot(0.2, 0.05) - 0.01, rel=1e-3)
    changed = np.argwhere(seen(source) != seen("bright"))
    assert len(changed) and changed[:, 1].max() < 49, "left of the middle alone, as y is the observer's left"


def test_what_only_is_seen_and_what_hangs_above_a_hull_is_no_obstacle(tmp_path):
    body = (
        '<geom type="box" size="0.01 0.01 0.01" pos="0.2 0 0.01" contype="0" conaffinity="0"/>'
        '<geom type="box" size="0.01 0.3 0.01" pos="0.2 0 0.06"/>'
    )
    assert not obstacles(compile_arena(written(tmp_path, body)))


@pytest.mark.parametrize(
    ("kind", "size", "reach"),
    [("sphere", "0.02", 0.02), ("box", "0.03 0.01 0.02", 0.03), ("capsule", "0.02 0.01", 0.02),
     ("ellipsoid", "0.03 0.02 0.02", 0.03)],
)  # fmt: skip
def test_outlines_have_the_geoms_extent(tmp_path, kind, size, reach):
    (there,) = obstacles(compile_arena(written(tmp_path, f'<geom type="{kind}" size="{size}" pos="0.2 0 0.02"/>')))
    assert there.nearest(0.0, 0.0)[0] == pytest.approx(0.2 - reach, rel=2e-3)
    assert there.nearest(0.2, 0.0)[0] < 0.0, "inside"


def test_the_distance_to_a_square_is_that_of_geometry():
    square = Obstacle("square", outline(np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], float)), 1.0)
    places = np.array([[2.0, 0.0], [2.0, 2.0], [0.0, 0.5], [0.0, -3.0]])
    assert square.distances(places) == pytest.approx([1.0, math.sqrt(2), -0.5, 2.0])


@pytest.mark.parametrize(
    ("body", "before"),
    [
        ('<geom name="w" type="box" size="0.1 30 1" pos="0.3 0 1"/>', ""),  # in cm: MJCF is in metres
        ('<geom type="plane" size="1 1 1" pos="0.3 0 0"/>', ""),
        ('<body><freejoint/><geom type="sphere" size="0.01"/></body>', ""),
        ("", '<option gravity="0 0 -1"/>'),
        ("", PICTURE.format("no.png")),
    ],
)
def test_what_would_be_another_world_is_refused_with_its_file(tmp_path, body, before):
    source = written(tmp_path, body, before)
    with pytest.raises(ValueError, match=re.escape(source)):
        compile_arena(source)


def test_a_robot_cannot_be_put_into_an_obstacle(tmp_path):
    source = written(tmp_path, PILLAR)
    with Simulation(scene=SceneConfig(arena=source), seeing=False) as simulation:
        rng = np.random.default_rng(0)
        simulation.reset({"stimulus": Pose(0.2, 0.0, 0.0)}, rng)
        with pytest.raises(ValueError, match=r"stimulus at .* stands in the obstacle pillar"):
            simulation.reset({"stimulus": Pose(0.2, 0.021, 0.0)}, rng)


def test_a_picture_on_the_shell_is_upright_and_no_mirror_image_from_every_side(tmp_path):
    """The picture is dark in its upper left quarter."""
    picture = np.full((64, 64), 255, np.uint8)
    picture[:32, :32] = 0
    cv2.imwrite(str(tmp_path / "own.png"), picture)
    scene = SceneConfig(arena="plain", light_sd=0.0, turn_wall=False, shell_picture=str(tmp_path / "own.png"))
    with Simulation(scene=scene) as simulation:
        for quarter in range(4):
            rng = np.random.default_rng(1)
            simulation.reset({"stimulus": Pose(0.1, 0.0, quarter * math.pi / 2)}, rng)
            rows, columns = np.nonzero(simulation.step(rng).luma[:, 40:59] < 60)
            assert len(rows) and columns.max() < 12, "dark left of the axis"
            assert rows.max() < 45, "and not below the shell's middle"
