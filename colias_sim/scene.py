"""Compose an arena and robots into one MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.arena import arena_spec, one_line
from colias_sim.config import CameraConfig, RobotConfig, SceneConfig
from colias_sim.obstacles import FENCE, check_room
from dsnn.pictures import read_picture
from scenes import ARENA_RADIUS_CM, ROBOTS, WALL_HEIGHT_CM, WALL_PANELS

COLLISION_GROUP = 3
"""Group of the geoms that collide and are not drawn. MuJoCo draws groups 0 to 2."""
FENCE_DEPTH, FENCE_HEIGHT = 0.01, 0.03  # half extents, metres

WALL_TEXELS = 384, 2048
"""Texels up and around a wall with a picture: twice as fine as the arenas' own."""

SHELL_TEXELS = 256
"""Texels along each edge of a picture on the stimulus."""
UPRIGHT = 1, -1, 2, 0
"""Quarter turns, left positive, by which a picture is upright on the side faces of a cube texture: +x, -x, +y, -y."""
ROUND_STACKS = 24
"""Rings of a drawn sphere. Arenas have 2, which is enough for cylinders."""
ROUND = tuple(
    kind.value
    for kind in (mujoco.mjtGeom.mjGEOM_SPHERE, mujoco.mjtGeom.mjGEOM_ELLIPSOID, mujoco.mjtGeom.mjGEOM_CAPSULE)
)
SHELL_BOTTOM, CARD_HALF_THICKNESS = 0.001, 0.0005
"""Height of a shell's lower edge above the floor, and half the thickness of a card, in metres."""

COMMAND_RATE = 60.0
"""Wheel commands per second. The true rate is the nearest at which a frame has a whole number of commands."""

LONGEST_STEP = 0.0019
"""Longest physics step, in seconds. The drive is tested with steps of up to 2 ms."""


def commands_per_frame(fps: float) -> int:
    """Number of wheel commands in a frame of a camera with ``fps`` frames per second: 2 at 30 fps."""
    return max(1, round(COMMAND_RATE / fps))


def steps_per_command(fps: float) -> int:
    """Number of physics steps between two wheel commands: 9 at 30 fps."""
    return math.ceil(1.0 / (fps * commands_per_frame(fps) * LONGEST_STEP))


def steps_per_frame(fps: float) -> int:
    """Number of physics steps in a frame: 18 at 30 fps."""
    return commands_per_frame(fps) * steps_per_command(fps)


def timestep(fps: float) -> float:
    """Length of a physics step, in seconds: 1.85 ms at 30 fps."""
    return 1.0 / (fps * steps_per_frame(fps))


def compose(
    scene: SceneConfig, robot: RobotConfig, camera: CameraConfig, robots: Mapping[str, str], *, fence: bool = False,
    eyes: Mapping[str, CameraConfig] | None = None,
) -> mujoco.MjSpec:  # fmt: skip
    """Compose an arena and robots into one MuJoCo specification.

    Parts of a robot called ``stimulus`` have the names ``stimulus/base``, ``stimulus/eye`` and so on.

    Parameters
    ----------
    scene, robot, camera
        The settings of the apparatus.
    robots
        Name -> variant (``colias``, ``colias_black``, ...) of each robot.
    fence
        Whether robots collide with the wall; otherwise the wall is only visible.
    eyes
        Name -> settings of the camera of robots that have not ``camera``.

    Returns
    -------
    mujoco.MjSpec
        The specification, not yet compiled.

    Raises
    ------
    ValueError
        The arena or a variant is unknown, or `colias_sim.arena.arena_spec` refuses the arena.
    """
    spec = arena_spec(scene.arena)
    spec.option.timestep = timestep(camera.fps)
    set_room(spec, scene)
    if scene.wall:
        set_wall(spec, scene.wall)
    if any(variant not in list(ROBOTS) for variant in robots.values()):
        raise ValueError(f"robots are {dict(robots)}: variants are {', '.join(ROBOTS)}")
    for name, variant in robots.items():
        child = robot_spec(variant, robot, (eyes or {}).get(name, camera), scene)
        child.option.timestep = spec.option.timestep
        spec.worldbody.add_frame().attach_body(child.body("base"), f"{name}/", "")
    if fence:
        _add_fence(spec, scene.wall_cm / 100)
    return spec


def compile_model(
    scene: SceneConfig, robot: RobotConfig, camera: CameraConfig, robots: Mapping[str, str], *, fence: bool = False,
    eyes: Mapping[str, CameraConfig] | None = None,
) -> mujoco.MjModel:  # fmt: skip
    """Compose and compile a scene, and set antialiasing and the contrast of the wall's texture.

    The parameters are those of `compose`.

    Returns
    -------
    mujoco.MjModel
        The compiled model.

    Raises
    ------
    ValueError
        As in `compose`. Also, MuJoCo cannot compile the arena, or it does not fit into the room.
    """
    size = scene.wall_cm / ARENA_RADIUS_CM
    model = _compiled(compose(scene, robot, camera, robots, fence=fence, eyes=eyes), scene.arena, size)
    if any(kind in ROUND for kind in model.geom_type[model.geom_group != COLLISION_GROUP]):
        model.vis.quality.numstacks = ROUND_STACKS
    model.vis.quality.offsamples = camera.multisample
    if scene.wall_contrast != 1.0:
        wall = texels(model, "wall")
        wall[:] = contrasted(wall, scene.wall_contrast)
    return model


def compile_arena(source: str) -> mujoco.MjModel:
    """Compile an arena alone, without robots.

    Parameters
    ----------
    source
        Its name, or the path of your own file.

    Returns
    -------
    mujoco.MjModel
        The compiled arena.

    Raises
    ------
    ValueError
        The arena is refused. The message is one line.
    """
    return _compiled(arena_spec(source), source)


def _compiled(spec: mujoco.MjSpec, source: str, size: float = 1.0) -> mujoco.MjModel:
    try:
        model = spec.compile()
    except ValueError as error:
        raise ValueError(f"arena {source}: {one_line(error)}") from None
    check_room(model, source, size)
    return model


def set_room(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """Set the floor's reflectance, and the wall's distance with everything about it in proportion.

    Parameters
    ----------
    spec
        The arena.
    scene
        The settings.

    Raises
    ------
    ValueError
        The wall is to stand elsewhere, but its mesh is not the one that all built-in arenas have.
    """
    floor, wall, size = spec.geom("floor"), spec.mesh("wall"), scene.wall_cm / ARENA_RADIUS_CM
    if scene.floor is not None:
        spec.add_material(name="plain floor", rgba=[scene.floor] * 3 + [1.0], specular=0.0, shininess=0.0)
        floor.material = "plain floor"
    if size != 1.0:
        if wall is None:
            raise ValueError(f"arena {scene.arena}: wall_cm must be {ARENA_RADIUS_CM:g}, as no mesh is called wall")
        wall.scale = size * wall.scale
        floor.size = floor.size * [max(size, 1.0), max(size, 1.0), 1.0]


def set_wall(spec: mujoco.MjSpec, path: str) -> None:
    """Replace the texture of an arena's wall with the grey levels of a picture.

    The picture is as high as the wall. Joined to its mirror image, it is repeated as often as best preserves its
    proportions.

    Parameters
    ----------
    spec
        The arena.
    path
        A file that OpenCV decodes.

    Raises
    ------
    ValueError
        The file is not a picture. The message is one line that begins with the path.
    """
    picture = read_picture(path)
    wide = WALL_HEIGHT_CM * picture.shape[1] / picture.shape[0]
    pairs = max(round(math.pi * ARENA_RADIUS_CM / wide), 1)
    columns = max(round(WALL_TEXELS[1] / (2 * pairs)), 1)
    one = _resized_picture(picture, columns, WALL_TEXELS[0])
    _fill(spec.texture("wall"), np.tile(np.concatenate([one, one[:, ::-1]], axis=1), pairs))


def set_shell(spec: mujoco.MjSpec, scene: SceneConfig) -> None:
    """Give a robot the shell of the scene's settings: grey or picture, shape and size.

    Parameters
    ----------
    spec
        The robot, whose shell is a geom ``cover`` of the material ``shell``. Without a cover only the grey is set.
    scene
        The settings.

    Raises
    ------
    ValueError
        ``scene.shell_picture`` is not a picture. The message is one line that begins with the path.
    """
    material, cover = spec.material("shell"), spec.geom("cover")
    material.rgba = [scene.shell_grey] * 3 + [1.0]
    if cover is None or scene.usual_shell:
        return
    half, half_height = scene.shell_width_cm / 200, scene.shell_height_cm / 200
    if scene.shell_shape == "sphere":
        cover.type, cover.size, half_height = mujoco.mjtGeom.mjGEOM_SPHERE, [half, 0.0, 0.0], half
    elif scene.shell_shape == "card":
        cover.type, cover.size = mujoco.mjtGeom.mjGEOM_BOX, [CARD_HALF_THICKNESS, half, half_height]
    else:
        cover.size = [half, half_height, 0.0]
    cover.pos = [0.0, 0.0, SHELL_BOTTOM + half_height]
    turn = math.radians(scene.shell_turn_deg) / 2
    cover.quat = [math.cos(turn), 0.0, 0.0, math.sin(turn)]
    if scene.shell_picture:
        texture = spec.add_texture(name="shell", type=mujoco.mjtTexture.mjTEXTURE_CUBE)
        face = _resized_picture(read_picture(scene.shell_picture), SHELL_TEXELS, SHELL_TEXELS)
        ends = np.full((2 * SHELL_TEXELS, SHELL_TEXELS), round(face.mean()), np.uint8)  # above and below: its mean grey
        _fill(texture, np.concatenate([*(np.rot90(face, turns) for turns in UPRIGHT), ends]))
        material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "shell"
        material.rgba = [1.0] * 4


def _resized_picture(picture: npt.NDArray[np.uint8], columns: int, rows: int) -> npt.NDArray[np.uint8]:
    shrinks = picture.shape[0] > rows
    one = cv2.resize(picture, (columns, rows), interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR)
    return np.asarray(one, np.uint8)


def _fill(texture: mujoco.MjsTexture, grey: npt.NDArray[np.uint8]) -> None:
    """Fill a texture with grey levels (H, W) instead of its file."""
    texture.file = ""
    texture.height, texture.width = grey.shape
    texture.nchannel = 3
    texture.data = np.repeat(grey[:, :, np.newaxis], 3, axis=2).tobytes()


def _add_fence(spec: mujoco.MjSpec, radius: float) -> None:
    """Add boxes that stop hulls at the wall. The wall that is drawn is a concave mesh, which cannot collide."""
    for panel in range(WALL_PANELS):
        turn = 2 * math.pi * (panel + 0.5) / WALL_PANELS
        away = radius * math.cos(math.pi / WALL_PANELS) + FENCE_DEPTH
        spec.worldbody.add_geom(
            name=f"{FENCE}{panel}", type=mujoco.mjtGeom.mjGEOM_BOX, group=COLLISION_GROUP, contype=2, conaffinity=2,
            pos=[away * math.cos(turn), away * math.sin(turn), FENCE_HEIGHT],
            size=[FENCE_DEPTH, radius * math.sin(math.pi / WALL_PANELS) + FENCE_DEPTH, FENCE_HEIGHT],
            quat=[math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)],
        )  # fmt: skip


def robot_spec(variant: str, robot: RobotConfig, camera: CameraConfig, scene: SceneConfig) -> mujoco.MjSpec:
    """Make one robot for a scene. The settings of the shell do not apply to a ``colias``."""
    spec = _driving(mujoco.MjSpec.from_file(str(ROBOTS[variant])), robot, camera)
    if variant != "colias":
        set_shell(spec, scene)
    return spec


def _driving(spec: mujoco.MjSpec, robot: RobotConfig, camera: CameraConfig) -> mujoco.MjSpec:
    base = spec.body("base")
    if not spec.actuators:  # parked for good
        return spec
    radius, half_track = robot.wheel_radius_cm / 100, robot.track_cm / 200
    wheels = {"left": half_track, "right": -half_track}
    for side, y in wheels.items():
        spec.body(f"{side}_wheel").pos = [-robot.axle_back_cm / 100, y, radius]
        for geom in spec.body(f"{side}_wheel").geoms:
            geom.size = _resized(geom, radius)
        actuator = spec.actuator(side)
        actuator.gainprm[0], actuator.biasprm[2] = robot.motor_gain, -robot.motor_gain
        actuator.ctrlrange = np.array([-1.0, 1.0]) * robot.max_speed_cm_s / robot.wheel_radius_cm
    base.mass = robot.mass_g / 1000 - 2 * spec.geom("left_tyre").mass
    eye = spec.camera("eye")
    eye.pos = [camera.forward_cm / 100, 0.0, camera.up_cm / 100]
    eye.resolution = [camera.width, camera.height]
    eye.focal_pixel = [camera.focal_px] * 2
    eye.sensor_size = [camera.width * 1e-4, camera.height * 1e-4]
    return spec


def _resized(geom: mujoco.MjsGeom, radius: float) -> list[float]:
    """Return a wheel's size with another radius: a tyre is an ellipsoid (r, w, r), the drawn wheel a cylinder."""
    _, second, _ = geom.size
    return [radius, second, radius] if geom.type == mujoco.mjtGeom.mjGEOM_ELLIPSOID else [radius, second, 0.0]


def groups_of(model: mujoco.MjModel, robot: str) -> npt.NDArray[np.int32]:
    """Find the groups of a robot's geoms, for `hidden`.

    Parameters
    ----------
    model
        The compiled scene.
    robot
        Name of the robot.

    Returns
    -------
    ndarray of int32
        (N,): a view into the model, of the robot's body and wheels, drawn or not.

    Raises
    ------
    KeyError
        The scene has no robot of that name.
    """
    own = np.flatnonzero(model.body_rootid[model.geom_bodyid] == model.body(f"{robot}/base").id)
    groups: npt.NDArray[np.int32] = model.geom_group
    return groups[own[0] : own[-1] + 1]


@contextmanager
def hidden(own: npt.NDArray[np.int32]) -> Iterator[None]:
    """Hide a robot's geoms from its own eye, whose lens is in front of the whole body.

    Parameters
    ----------
    own
        The groups of its geoms, from `groups_of`. Until the end of the block they are in `COLLISION_GROUP`, which
        neither ``mjv_updateScene`` nor a ray at the drawn groups takes in.
    """
    groups = own.copy()
    own[:] = COLLISION_GROUP
    try:
        yield
    finally:
        own[:] = groups


def texels(model: mujoco.MjModel, texture: str) -> npt.NDArray[np.uint8]:
    """Return a view of a texture's bytes in the model. A renderer has its own copy from the time it was made."""
    tex = model.tex(texture).id
    start = model.tex_adr[tex]
    size = model.tex_height[tex] * model.tex_width[tex] * model.tex_nchannel[tex]
    every: npt.NDArray[np.uint8] = model.tex_data
    return every[start : start + size]


def contrasted(texture: npt.NDArray[np.uint8], contrast: float) -> npt.NDArray[np.uint8]:
    """Multiply the contrast of a texture's bytes about their mean, clipped to 0..255."""
    plain = texture.astype(np.float64)
    scaled = plain.mean() + contrast * (plain - plain.mean())
    cut: npt.NDArray[np.uint8] = np.clip(np.rint(scaled), 0, 255).astype(np.uint8)
    return cut


def base_mass(robot: RobotConfig, model: mujoco.MjModel, name: str) -> float:
    """Compute the mass of a robot's base in kg, as `compose` sets it: the whole mass minus the wheels."""
    return robot.mass_g / 1000 - float(
        model.body(f"{name}/left_wheel").mass[0] + model.body(f"{name}/right_wheel").mass[0]
    )


def set_motor_gain(model: mujoco.MjModel, name: str, gain: float) -> None:
    """Set the gain of a robot's two wheel servos in N m s/rad, as `compose` does."""
    for side in ("left", "right"):
        actuator = model.actuator(f"{name}/{side}")
        actuator.gainprm[0], actuator.biasprm[2] = gain, -gain
