"""What pixels truly show: against geometry worked out here, against the pictures, and by laws."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import pytest

from colias_sim import CameraConfig, Pose, SceneConfig, Simulation
from colias_sim.truth import COLUMNS
from tests.colias_sim.views import drawn, owners

IDEAL = CameraConfig.ideal()
FOCAL, ROWS, COLUMNS_PX = 49.5 / math.tan(math.radians(35)), 72, 99
LENS_UP_M, RADIUS, TOP, BOTTOM = 0.02, 0.02, 0.03, 0.001
ROOM, PANELS, WALL_TOP = 0.45, 24, 0.40
HERE, AWAY, CROSSING = Pose(0.0, 0.0, 0.0), Pose(-0.3, 0.0, 0.0), Pose(0.1, 0.03, -math.pi / 2)
STILL = SceneConfig(light_sd=0, turn_wall=False)

Drive = Callable[[Simulation], None]


def drive(robot: str, speed: float, turn: float = 0.0) -> Drive:
    return lambda sim: sim.robots[robot].drive(sim.robots[robot].wheels_for(speed, turn))


def drum(sim: Simulation) -> None:
    sim.turn_wall(sim.wall_turn + math.radians(1.2))


SCENES: dict[str, tuple[dict[str, Pose], Drive, SceneConfig]] = {
    "crossing": ({"observer": HERE, "stimulus": Pose(0.1, 0.05, -math.pi / 2)}, drive("stimulus", 0.06), STILL),
    "approach": ({"observer": HERE, "stimulus": Pose(0.11, 0.01, math.pi)}, drive("stimulus", 0.04), STILL),
    "turn": ({"observer": HERE, "stimulus": Pose(0.12, 0.0, 0.0)}, drive("observer", 0.0, 0.6), STILL),
    "drive": ({"observer": Pose(0.33, -0.2, 1.8), "stimulus": AWAY}, drive("observer", 0.2), STILL),
    "drum": ({"observer": HERE, "stimulus": Pose(0.12, 0.02, 0.0)}, drum, dataclasses.replace(STILL, arena="drum")),
}
"""Scene -> where the robots begin, what moves in every frame, and the arena."""


@cache
def played(name: str, frames: int = 16):
    """The truth and luma of a scene's last two frames, where robots and wall were at the end of each, and how high."""
    poses, move, scene = SCENES[name]
    with Simulation(camera=IDEAL, scene=scene, truth=True) as sim:
        sim.reset(poses, np.random.default_rng(0))
        found = []
        for _ in range(frames):
            move(sim)
            frame = sim.step(np.random.default_rng(0))
            found.append(
                (sim.truth(), frame.luma.astype(float), dict(sim.poses), sim.wall_turn, sim.robots["observer"].height)
            )
        return found[-2:]


# Geometry, in the world: x ahead, y left, z up.


def rays(pose: Pose, height: float) -> tuple[np.ndarray, np.ndarray]:
    """The lens (3,) and a direction (R, C, 3) through the centre of every pixel."""
    right, down = np.meshgrid(
        (np.arange(COLUMNS_PX) + 0.5 - COLUMNS_PX / 2) / FOCAL, (np.arange(ROWS) + 0.5 - ROWS / 2) / FOCAL
    )
    c, s = math.cos(pose.heading), math.sin(pose.heading)
    way = np.stack([c + s * right, s - c * right, -down], axis=-1)
    return np.array([pose.x + 0.0195 * c, pose.y + 0.0195 * s, LENS_UP_M + height]), way


def surfaces(lens: np.ndarray, way: np.ndarray, stimulus: Pose, wall: float) -> tuple[np.ndarray, np.ndarray]:
    """Which of floor 0, wall 1, stimulus 2 each direction meets first, -1 none, and how many directions away."""
    with np.errstate(divide="ignore", invalid="ignore"):
        floor = np.where(way[..., 2] < 0, -lens[2] / way[..., 2], np.inf)
        walls = np.full(way.shape[:2], np.inf)
        for panel in range(PANELS):
            angle = wall + 2 * math.pi * (panel + 0.5) / PANELS
            normal = np.array([math.cos(angle), math.sin(angle), 0.0])
            away = (ROOM * math.cos(math.pi / PANELS) - lens @ normal) / (way @ normal)
            walls = np.minimum(walls, np.where(way @ normal > 0, away, np.inf))
        walls[lens[2] + walls * way[..., 2] > WALL_TOP] = np.inf
        off, flat = lens[:2] - np.array([stimulus.x, stimulus.y]), way[..., :2]
        a, b, c = (flat**2).sum(-1), flat @ off, off @ off - RADIUS**2
        side = (-b - np.sqrt(b**2 - a * c)) / a
        height = lens[2] + side * way[..., 2]
        side = np.where((height >= BOTTOM) & (height <= TOP) & (side > 0), side, np.inf)
    away = np.stack([floor, walls, side])
    first = away.argmin(axis=0)
    return np.where(np.isinf(away.min(axis=0)), -1, first), away.min(axis=0)


def carried(point: np.ndarray, now: Pose, before: Pose) -> np.ndarray:
    """Where points of a body were, when it was at another pose."""
    turn = before.heading - now.heading
    c, s = math.cos(turn), math.sin(turn)
    x, y = point[..., 0] - now.x, point[..., 1] - now.y
    return np.stack([before.x + c * x - s * y, before.y + s * x + c * y, point[..., 2]], axis=-1)


def expected(last) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Flow (R, C, 2) of every pixel, seen before or not, its surface, and whether it was in view and not hidden."""
    (_, _, then, wall_then, _), (_, _, now, wall_now, height) = last
    lens, way = rays(now["observer"], height)
    surface, away = surfaces(lens, way, now["stimulus"], wall_now)
    point = lens + away[..., np.newaxis] * way
    was = np.where((surface == 2)[..., None], carried(point, now["stimulus"], then["stimulus"]), point)
    turned = carried(point, Pose(0.0, 0.0, wall_now), Pose(0.0, 0.0, wall_then))
    was = np.where((surface == 1)[..., None], turned, was)
    eye, (old, _) = then["observer"], rays(then["observer"], height)
    c, s = math.cos(eye.heading), math.sin(eye.heading)
    ahead, left = (was - old) @ np.array([c, s, 0.0]), (was - old) @ np.array([-s, c, 0.0])
    place = np.stack([-left / ahead, -(was - old)[..., 2] / ahead], axis=-1) * FOCAL
    right, down = np.meshgrid(np.arange(COLUMNS_PX) + 0.5 - COLUMNS_PX / 2, np.arange(ROWS) + 0.5 - ROWS / 2)
    first = surfaces(old, was - old, then["stimulus"], wall_then)[1]  # 1 is the point itself
    inside = (ahead > 0) & (np.abs(place) < (COLUMNS_PX / 2, ROWS / 2)).all(axis=-1)
    return np.stack([right, down], axis=-1) - place, surface, inside & (first > 0.999)


def off_outlines(surface: np.ndarray) -> np.ndarray:
    """The pixels (R, C) whose eight neighbours show the same surface."""
    kind = surface.astype(np.int16)
    around = np.ones((3, 3), np.uint8)
    return np.asarray(cv2.dilate(kind, around) == cv2.erode(kind, around))


@pytest.mark.parametrize("name", SCENES)
def test_flow_depth_and_surface_are_those_of_geometry(name):
    scene = played(name)
    truth = scene[-1][0]
    flow, surface, seen = expected(scene)
    known = np.isfinite(truth.flow[..., 0])
    assert np.mean((known == seen)[off_outlines(surface)]) > 0.999
    if name in ("crossing", "turn", "drum"):  # what comes into view, or from behind the shell
        assert (~seen & (surface == 1)).sum() > 20
    inside = off_outlines(surface) & known
    wrong = np.abs(truth.flow - flow).max(axis=-1)[inside]
    assert np.mean(wrong < 0.02) >= 0.99
    assert (truth.geom >= 0).all(), "the room is closed, also where two panels of its wall meet"
    names = np.array(["floor", "wall", "stimulus/cover", ""])[surface]
    assert np.mean(np.array([*truth.geoms, ""])[truth.geom] == names) > 0.99
    _, _, now, wall, height = scene[-1]
    lens, way = rays(now["observer"], height)
    _, away = surfaces(lens, way, now["stimulus"], wall)
    assert np.nanpercentile(np.abs(truth.depth_m / away - 1)[inside], 99) < 0.01  # a direction is 1 long ahead


@pytest.mark.parametrize("frames", [2, 16])  # from the first on that has one before it
def test_a_standing_observers_background_does_not_flow(frames):
    truth = played("crossing", frames=frames)[-1][0]
    background = truth.flow[(truth.robot < 0) & np.isfinite(truth.flow[..., 0])]
    assert len(background) > 5000 and not background.any()


@pytest.mark.parametrize("name", SCENES)
def test_flow_predicts_the_picture(name):
    """Each wrong flow fails: of the other sign, of half the size, a row off."""
    (_, before, *_), (truth, now, *_) = played(name)
    moving = np.isfinite(truth.flow[..., 0]) & (np.hypot(*np.moveaxis(truth.flow, -1, 0)) >= 0.5)
    assert moving.sum() > 300

    def error(flow: np.ndarray, rows: int = 0) -> float:
        column, row = np.meshgrid(np.arange(99, dtype=np.float32), np.arange(72, dtype=np.float32))
        flow = np.nan_to_num(flow).astype(np.float32)
        there = cv2.remap(before, column - flow[..., 0], row - flow[..., 1] - rows, cv2.INTER_LINEAR)
        return float(((there - now)[moving] ** 2).sum())

    still = error(0 * truth.flow)
    assert error(truth.flow) < still / 5
    for wrong in (error(-truth.flow), error(truth.flow / 2), error(truth.flow, rows=1)):
        assert wrong > still / 5


def test_mirrored_scenes_have_mirrored_flow():
    found = []
    for side in (1, -1):
        with Simulation(camera=IDEAL, scene=STILL, truth=True) as sim:
            poses = {"observer": HERE, "stimulus": Pose(0.1, side * 0.02, -side * math.pi / 2)}
            sim.reset(poses, np.random.default_rng(0))
            for _ in range(8):
                drive("stimulus", 0.06)(sim)
                drive("observer", 0.05, side * 0.3)(sim)
                sim.step(np.random.default_rng(0))
            found.append(sim.truth())
    one, other = found
    both = np.isfinite(one.flow[..., 0]) & np.isfinite(other.flow[:, ::-1, 0]) & off_outlines(one.robot)
    mirrored = other.flow[:, ::-1] * np.array([-1.0, 1.0])
    assert both.mean() > 0.8 and np.abs(one.flow - mirrored)[both].max() < 0.02
    named = one.columns(["stimulus"]), other.columns(["stimulus"])
    for name in ("true_flow_x", "true_heading_deg"):
        assert named[0][name] == pytest.approx(-named[1][name], abs=0.02) and named[0][name] != 0.0


def test_the_observer_s_own_body_is_hidden():
    """Also with the lens above the axle, within it."""
    with Simulation(camera=dataclasses.replace(IDEAL, forward_cm=0.0), scene=STILL, truth=True) as sim:
        sim.reset({"observer": HERE, "stimulus": Pose(0.1, 0.0, 0.0)}, np.random.default_rng(0))
        sim.step(np.random.default_rng(0))
        assert set(np.unique(sim.truth().robot)) == {-1, 1}


def test_robots_are_those_of_a_render_in_flat_colours():
    robots = {"observer": "colias", "near": "colias_black", "bare": "colias", "post": "colias_parked"}
    poses = {"near": Pose(0.12, 0.02, 1.0), "bare": Pose(0.1, -0.05, 2.0), "post": Pose(0.2, 0.06, 0.0)}
    with Simulation(camera=IDEAL, scene=STILL, robots=robots, truth=True) as sim:
        sim.reset(poses, np.random.default_rng(0))
        sim.step(np.random.default_rng(0))
        truth, drawn_owner = sim.truth(), owners(sim.model, drawn(sim, "observer"))
    drawn_owner[np.isin(drawn_owner, ["world", "wall"])] = ""
    owner, inside = np.array([*truth.robots, ""])[truth.robot], off_outlines(truth.robot)
    assert np.mean((owner == drawn_owner)[inside]) >= 0.995
    assert {"near", "bare", "post"} == set(np.unique(owner[inside])) - {""}
    share, both = np.isin(owner, ["near", "bare"]).mean(), truth.columns(["near", "bare"])
    assert both["true_share"] == pytest.approx(share) and 0 < truth.columns(["bare"])["true_share"] < share


def steps(camera: CameraConfig, count: int, **options: bool):
    with Simulation(camera=camera, scene=STILL, **options) as sim:
        sim.reset({"observer": HERE, "stimulus": CROSSING}, np.random.default_rng(1))
        drive("stimulus", 0.06)(sim)
        noise = np.random.default_rng(2)
        for _ in range(count):
            yield sim, sim.step(noise)


def test_it_changes_no_frame_and_is_off_otherwise():
    camera = CameraConfig.preset("ov7670")
    plain = [frame.luma for _, frame in steps(camera, 6)]
    for (sim, frame), luma in zip(steps(camera, 6, truth=True), plain, strict=True):
        sim.truth()
        assert np.array_equal(frame.luma, luma)
    with pytest.raises(ValueError, match="truth=True"):
        next(sim.truth() for sim, _ in steps(camera, 1))


def test_a_dropped_frame_has_no_flow_and_no_interval():
    dropped = False
    for sim, frame in steps(dataclasses.replace(IDEAL, drop_probability=0.5), 12, truth=True):
        truth = sim.truth()
        if frame.age_ms > 0.0:
            dropped = True
            assert not np.nan_to_num(truth.flow).any() and truth.interval_ms.tolist() == [0.0]
    assert dropped


def test_frames_further_back():
    """A body that keeps its speed has moved by as many times its way of a frame; six frames are remembered."""
    for number, (sim, _) in enumerate(steps(IDEAL, 10, truth=True)):
        assert np.isnan(sim.truth().flow).all() == (number == 0)
        assert np.isnan(sim.truth(since=6).interval_ms).all() == (number < 6)
    one, six = sim.truth().columns(["stimulus"]), sim.truth(since=6).columns(["stimulus"])
    assert six["true_interval_ms"] == pytest.approx(200.0) and one["true_interval_ms"] == pytest.approx(1000 / 30)
    assert six["true_flow_x"] == pytest.approx(6 * one["true_flow_x"], rel=0.1)
    with pytest.raises(ValueError, match="between 1 and 6, got 7"):
        sim.truth(since=7)


CLOCKS: dict[str, dict[str, float]] = {
    "global": {"exposure_ms": 8.0},
    "mean of four": {"exposure_ms": 16.0, "exposure_samples": 4},
    "rolling": {"exposure_ms": 8.0, "row_time_us": 418.0, "row_bands": 6},
    "jitter": {"exposure_ms": 8.0, "row_time_us": 200.0, "row_bands": 6, "jitter_ms": 3.0},
}
"""Clock of a camera -> how it exposes."""


@pytest.mark.parametrize("clock", CLOCKS)
def test_a_pixels_moment_is_the_middle_of_its_bands_exposure(clock):
    """An approaching shell was further away then than at the frame's end, by its speed times the time between both."""
    camera = dataclasses.replace(IDEAL, **CLOCKS[clock])
    with Simulation(camera=camera, scene=STILL, truth=True) as sim:
        sim.reset({"observer": HERE, "stimulus": Pose(0.2, 0.0, math.pi)}, np.random.default_rng(0))
        places, intervals, noise = [], set(), np.random.default_rng(3)
        for _ in range(15):
            drive("stimulus", 0.2)(sim)
            sim.step(noise)
            truth = sim.truth()
            places.append(sim.pose("stimulus").x)
            intervals |= set(truth.interval_ms[~np.isnan(truth.interval_ms)])
    speed = 30 * (places[-2] - places[-1])
    rows = np.arange(ROWS)
    shell = (truth.robot[:, 49] == 1) & np.isfinite(truth.flow[:, 49, 0])
    depths = ((truth.depth_before_m, places[-2]), (truth.depth_m, places[-1]))  # column 49 has no bearing
    before, early = ((depth[:, 49] - (place - RADIUS - 0.0195)) / speed for depth, place in depths)
    was = np.rint(rows - np.nan_to_num(truth.flow[:, 49, 1])).astype(int)
    bands = len(truth.interval_ms)
    middle = (rows * bands // ROWS + 0.5) * ROWS / bands - 0.5
    due = 0.0005 * camera.exposure_ms + 1e-6 * camera.row_time_us * (ROWS - 1 - middle) * (bands > 1)
    slack = 0.0006 * 1000 / 540 + 0.0005 * camera.exposure_ms * (camera.exposure_samples > 1) / 4
    assert shell.sum() > 25 and speed > 0.15
    if clock == "jitter":
        assert len(intervals) > 3
    else:
        assert max(intervals) - min(intervals) < 1e-9 and np.abs(early - due)[shell].max() < slack
        assert np.abs(before - due[was])[shell].max() < slack, "in the band where the point was then"
    closing = 1000 * (truth.depth_before_m - truth.depth_m)[:, 49] / truth.interval_ms[rows * bands // ROWS]
    stays = shell & (was * bands // ROWS == rows * bands // ROWS)
    assert np.abs(closing[stays] - speed).max() < 0.005


def test_the_columns_of_an_approach_and_a_crossing_are_those_of_geometry():
    before, truth = played("approach")
    speed = 30 * (before[2]["stimulus"].x - truth[2]["stimulus"].x)
    named, gap = truth[0].columns(["stimulus"]), truth[2]["stimulus"].x - RADIUS - 0.0195
    off = math.atan2(truth[2]["stimulus"].y, gap + RADIUS)
    nearest = (gap + RADIUS) / math.cos(off) - RADIUS
    assert set(named) == set(COLUMNS)
    assert named["true_time_to_contact_s"] == pytest.approx(nearest / (speed * math.cos(off)), rel=0.02)
    assert math.isnan(named["true_heading_deg"]) and named["true_interval_ms"] == pytest.approx(1000 / 30)
    half = math.degrees(math.asin(RADIUS / math.hypot(gap + RADIUS, truth[2]["stimulus"].y)))
    assert named["true_width_deg"] == pytest.approx(2 * half, abs=1.5)
    assert named["true_share"] == pytest.approx(truth[0].mask(["stimulus"]).mean())
    crossing = played("crossing")[-1]
    named, away = crossing[0].columns(["stimulus"]), crossing[2]["stimulus"].x - 0.0195 - RADIUS
    assert named["true_image_speed_deg_s"] == pytest.approx(math.degrees(0.06 / away), rel=0.15)
    assert math.isnan(crossing[0].columns(["nothing"])["true_share"])
    for name, way in (
        ("drive", 0.0),
        ("turn", -90.0),
    ):  # the lens is ahead of the axle: a turn to the left takes it left
        assert played(name)[-1][0].columns(["wall"])["true_heading_deg"] == pytest.approx(way, abs=1.0)


def test_errors_of_an_estimate_are_those_worked_by_hand():
    """2.2 px to the right: half of it is off by 1.1 px and by atan 2.2 - atan 1.1; the truth itself by nothing."""
    truth = played("crossing")[-1][0]
    assert truth.errors(truth.flow) == (0.0, 0.0)
    moving = truth.flow[np.hypot(truth.flow[..., 0], truth.flow[..., 1]) >= 0.5].astype(float)
    assert np.abs(moving[:, 1]).max() < 0.01
    end_point, angular = truth.errors(truth.flow / 2)
    right = moving[:, 0]
    assert end_point == pytest.approx(right.mean() / 2, abs=1e-3)
    assert angular == pytest.approx(np.degrees(np.arctan(right) - np.arctan(right / 2)).mean(), abs=0.01)
    assert all(map(math.isnan, truth.errors(truth.flow, least_px=100.0)))
