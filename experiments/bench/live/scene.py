"""The arena and its robots on the page, drawn of viser's primitives, in centimetres."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import trimesh
import viser
from PIL import Image

from colias_sim import Pose, Simulation
from colias_sim.config import CameraConfig
from experiments.bench.live.arena import ROBOTS
from scenes import ARENA_RADIUS_CM

CM = 100.0
"""Units of the page for each of the simulation."""
DRAGGED_S = 1.5
"""Time after a drag for which the handle stays where it was left, while the stimulus follows."""
EYE, FLOOR = (17, 55, 177), (196, 200, 206)
RGB = mujoco.mjtTextureRole.mjTEXROLE_RGB.value


class Scene:
    """The visible geoms of a trial, those of a robot below a frame that moves with it, and the stimulus's handle.

    Parameters
    ----------
    scene
        Where they are drawn.
    drag
        Called with the place (x, y) in cm to which the handle is dragged.
    """

    def __init__(self, scene: viser.SceneApi, drag: Callable[[float, float], None]) -> None:
        self._scene, self._dragged = scene, -math.inf
        self._frames: dict[str, Any] = {}
        self._drawn: list[Any] = []
        self.handle = scene.add_transform_controls(
            "/handle", scale=5.0, active_axes=(True, True, False), disable_rotations=True,
            translation_limits=((-44.0, 44.0), (-44.0, 44.0), (4.5, 4.5)), depth_test=False,
        )  # fmt: skip

        def update(event: Any) -> None:
            self._dragged = time.monotonic()
            drag(*(float(value) for value in event.target.position[:2]))

        self.handle.on_update(update)

    def draw(self, sim: Simulation, camera: CameraConfig) -> None:
        """Draw a trial's arena and robots in place of those before.

        Parameters
        ----------
        sim
            The simulation.
        camera
            The observer's.
        """
        for handle in self._drawn:
            handle.remove()
        model, data, scene = sim.model, sim.data, self._scene
        self._frames = {name: scene.add_frame(f"/{name}", show_axes=False) for name in sim.robots}
        self._drawn = [*self._frames.values()]  # and with them all that is below them
        for index in range(model.ngeom):
            if model.geom_group[index] >= 3:
                continue
            robot = model.body(model.geom_bodyid[index]).name.partition("/")[0]
            position, rotation = data.geom_xpos[index].copy(), data.geom_xmat[index].reshape(3, 3).copy()
            if robot in sim.robots:
                base = data.body(f"{robot}/base")
                turn = base.xmat.reshape(3, 3)
                position, rotation = turn.T @ (position - base.xpos), turn.T @ rotation
            handle = self._draw_geom(model, index, f"/{robot}/{index}" if robot in sim.robots else f"/world/{index}")
            if handle is not None:
                quaternion = np.zeros(4)
                mujoco.mju_mat2Quat(quaternion, rotation.ravel())
                handle.position, handle.wxyz = tuple(CM * position), tuple(quaternion)
                if robot not in sim.robots:
                    self._drawn.append(handle)
        for name in ROBOTS:
            scene.add_label(f"/{name}/caption", name, position=(-3.0, 0.0, 0.0), anchor="top-center")
        aspect, eye = camera.width / camera.height, (camera.forward_cm, 0.0, camera.up_cm)
        vertical = 2 * math.atan(math.tan(math.radians(camera.hfov_deg) / 2) / aspect)
        scene.add_camera_frustum(
            "/observer/eye", vertical, aspect, scale=4.0, color=EYE, position=eye, wxyz=(0.5, -0.5, 0.5, -0.5)
        )

    def _draw_geom(self, model: mujoco.MjModel, index: int, name: str) -> Any:
        scene, kind, size = self._scene, mujoco.mjtGeom, CM * model.geom_size[index]
        material = model.geom_matid[index]
        rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[index]
        colour = tuple(int(255 * part) for part in rgba[:3])
        match model.geom_type[index]:
            case kind.mjGEOM_PLANE:
                return scene.add_cylinder(name, ARENA_RADIUS_CM, 0.02, FLOOR, radial_segments=72)
            case kind.mjGEOM_BOX:
                return scene.add_box(name, colour, tuple(2 * size))
            case kind.mjGEOM_CYLINDER:
                return scene.add_cylinder(name, size[0], 2 * size[1], colour)
            case kind.mjGEOM_SPHERE:
                return scene.add_icosphere(name, size[0], colour)
            case kind.mjGEOM_CAPSULE | kind.mjGEOM_ELLIPSOID:
                return scene.add_mesh_trimesh(name, _rounded(model.geom_type[index], size, colour))
            case kind.mjGEOM_MESH:
                return scene.add_mesh_trimesh(name, _mesh(model, index, colour))
        return None

    def move(self, poses: Mapping[str, Pose]) -> None:
        """Put the robots where they are."""
        for name, pose in poses.items():
            frame = self._frames[name]
            frame.position = (CM * pose.x, CM * pose.y, 0.0)
            frame.wxyz = (math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2))
        if time.monotonic() - self._dragged > DRAGGED_S:
            stimulus = poses["stimulus"]
            self.handle.position = (CM * stimulus.x, CM * stimulus.y, 4.5)


def _rounded(kind: int, size: npt.NDArray[np.float64], colour: tuple[int, ...]) -> Any:
    """Return a capsule, along z, or an ellipsoid, of MuJoCo's ``size``."""
    mesh: Any
    if kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        mesh = trimesh.creation.capsule(height=2 * size[1], radius=size[0])
        mesh.apply_translation((0.0, 0.0, -mesh.bounds.mean(axis=0)[2]))
    else:
        mesh = trimesh.creation.icosphere()
        mesh.apply_scale(size)
    mesh.visual.face_colors = (*colour, 255)
    return mesh


def _mesh(model: mujoco.MjModel, index: int, colour: tuple[int, ...]) -> Any:
    """Return the mesh of a geom, with its texture where it has one; a vertex for each corner of a face."""
    which = model.geom_dataid[index]
    first, count = model.mesh_faceadr[which], model.mesh_facenum[which]
    corners = (CM * model.mesh_vert[model.mesh_vertadr[which] :])[model.mesh_face[first : first + count].ravel()]
    mesh: Any = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
    texture = -1 if model.geom_matid[index] < 0 else model.mat_texid[model.geom_matid[index], RGB]
    if texture < 0 or model.mesh_texcoordadr[which] < 0:
        mesh.visual.face_colors = (*colour, 255)
        return mesh
    shape = model.tex_height[texture], model.tex_width[texture], model.tex_nchannel[texture]
    pixels = model.tex_data[model.tex_adr[texture] :][: math.prod(shape)].reshape(shape)
    uv = model.mesh_texcoord[model.mesh_texcoordadr[which] :][model.mesh_facetexcoord[first : first + count].ravel()]
    visual: Any = trimesh.visual
    material = visual.material.PBRMaterial(
        baseColorTexture=Image.fromarray(pixels), metallicFactor=0.0, roughnessFactor=1.0, doubleSided=False
    )
    mesh.visual = visual.TextureVisuals(uv * (1, -1) + (0, 1), material=material)
    return mesh
