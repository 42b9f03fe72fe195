"""What the page draws: running traces of potentials and spikes, and the arena with its robots, in centimetres."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import trimesh
import viser
from PIL import Image
from viser import uplot

from colias_sim import Pose, Simulation
from colias_sim.config import CameraConfig
from dsnn import Response
from dsnn.model import SPIKING
from experiments.base import palette
from experiments.live.session import ROBOTS, Session
from scenes import ARENA_RADIUS_CM

SHOWN_FRAMES = 180
"""Frames of the running traces."""
DASHES: tuple[list[float], ...] = ([], [6, 4], [2, 3], [10, 3, 2, 3])
"""Lines of the models, which share both plots."""
CM = 100.0
"""Units of the page for each of the simulation."""
EYE, FLOOR = palette.rgb(palette.OBSERVER), (196, 200, 206)
Floats = npt.NDArray[np.float64]


class Traces:
    """The two plots: potentials against T, and spikes.

    Parameters
    ----------
    gui
        Where they are added.
    session
        Its models.
    """

    def __init__(self, gui: viser.GuiApi, session: Session) -> None:
        self._session = session
        self._x = (np.arange(SHOWN_FRAMES) - SHOWN_FRAMES + 1) * session.interval_s
        channels = [(one.label, name) for one in session.runners for name in one.chosen.channels]
        blank = [0.0] * SHOWN_FRAMES
        self._traces = [
            {place: deque(blank, SHOWN_FRAMES) for place in channels if place[1] in palette.CHANNELS},
            {place: deque(blank, SHOWN_FRAMES) for place in channels if place[1] in SPIKING},
        ]
        self._limits = self._thresholds()
        scales = {"x": uplot.Scale(time=False, range=(float(self._x[0]), 0.0)), "y": uplot.Scale()}
        looks: dict[str, Any] = {"scales": scales, "legend": uplot.Legend(live=False), "padding": (12, 16, 0, 0)}
        grey, untimed = uplot.Axis(stroke=palette.THRESHOLD), uplot.Axis(show=False)  # the lower has the time axis
        self._plots = [
            gui.add_uplot(curves, series, height=height, axes=axes, **looks)
            for curves, series, height, axes in zip(
                self._curves(), self._series(), (170, 130), ((untimed, grey), (grey, grey)), strict=True
            )
        ]

    def _thresholds(self) -> list[float]:
        """Return T and -T of the models, by their parameters as they are now."""
        now = (replace(runner.chosen, network=runner.network).threshold for runner in self._session.runners)
        return [sign * limit for limit in dict.fromkeys(now) if limit is not None for sign in (1, -1)]

    def _series(self) -> list[tuple[uplot.Series, ...]]:
        dashes = dict(zip((runner.label for runner in self._session.runners), itertools.cycle(DASHES), strict=False))
        x, lines, counts = uplot.Series(label="s"), *(
            [
                uplot.Series(label=f"{label} {palette.TITLES[name]}{what}", stroke=palette.CHANNELS[name], width=2,
                             dash=dashes[label])
                for label, name in traces
            ]
            for traces, what in zip(self._traces, ("", " spikes"), strict=True)
        )  # fmt: skip
        limits = [
            uplot.Series(label=f"T = {limit:g}" if limit > 0 else "-T", stroke=palette.THRESHOLD, width=1, dash=[3, 3])
            for limit in self._limits
        ]
        return [(x, *lines, *limits), (x, *counts)]

    def _curves(self) -> list[tuple[Floats, ...]]:
        potentials, spikes = ([np.array(trace) for trace in traces.values()] for traces in self._traces)
        limits = [np.full(SHOWN_FRAMES, limit) for limit in self._limits]
        return [(self._x, *potentials, *limits), (self._x, *spikes)]

    def add(self, responses: Mapping[str, Response | None]) -> None:
        """Draw the responses to a frame."""
        for traces, ending in zip(self._traces, ("", "_spikes"), strict=True):
            for (label, name), trace in traces.items():
                trace.append(float(getattr(responses[label], f"{name}{ending}", 0.0)))
        if (limits := self._thresholds()) != self._limits:
            self._limits = limits
            for plot, series in zip(self._plots, self._series(), strict=True):
                plot.series = series
        for plot, data in zip(self._plots, self._curves(), strict=True):
            plot.data = data


class Scene:
    """The visible geoms of a trial, those of a robot below a frame that moves with it.

    Parameters
    ----------
    scene
        Where they are drawn.
    """

    def __init__(self, scene: viser.SceneApi) -> None:
        self._scene = scene
        self._frames: dict[str, Any] = {}

    def draw(self, sim: Simulation, camera: CameraConfig) -> None:
        """Draw a trial's arena and robots, and the camera of each that sees, in place of those before."""
        model, data, scene = sim.model, sim.data, self._scene
        scene.reset()
        self._frames = {name: scene.add_frame(f"/{name}", show_axes=False) for name in sim.robots}
        for index in np.flatnonzero(model.geom_group < 3):
            robot = model.body(model.geom_bodyid[index]).name.partition("/")[0]
            position, rotation = data.geom_xpos[index], data.geom_xmat[index].reshape(3, 3)
            if robot in sim.robots:
                base = data.body(f"{robot}/base")
                turn = base.xmat.reshape(3, 3)
                position, rotation = turn.T @ (position - base.xpos), turn.T @ rotation
            quaternion = np.zeros(4)
            mujoco.mju_mat2Quat(quaternion, rotation.ravel())
            name = f"/{robot if robot in sim.robots else 'world'}/{index}"
            mesh = _mesh(model, int(index))
            scene.add_mesh_trimesh(name, mesh, wxyz=tuple(quaternion), position=tuple(CM * position))
        for name in ROBOTS:
            scene.add_label(f"/{name}/caption", name, position=(-3.0, 0.0, 0.0), anchor="top-center")
        aspect, eye = camera.width / camera.height, (camera.forward_cm, 0.0, camera.up_cm)
        vertical = 2 * math.atan(math.tan(math.radians(camera.hfov_deg) / 2) / aspect)
        for name in sim.cameras:
            scene.add_camera_frustum(
                f"/{name}/eye", vertical, aspect, scale=4.0, color=EYE, position=eye, wxyz=(0.5, -0.5, 0.5, -0.5)
            )

    def move(self, poses: Mapping[str, Pose]) -> None:
        """Put the robots where they are."""
        for name, pose in poses.items():
            frame = self._frames[name]
            frame.position = (CM * pose.x, CM * pose.y, 0.0)
            frame.wxyz = (math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2))


def _mesh(model: mujoco.MjModel, index: int) -> Any:
    """Return the surface of a geom about its own middle, in its colour or its texture."""
    kind, (x, y, z), make = mujoco.mjtGeom, CM * model.geom_size[index], trimesh.creation
    material, mesh = model.geom_matid[index], None
    colour = 255 * (model.mat_rgba[material] if material >= 0 else model.geom_rgba[index])
    match model.geom_type[index]:
        case kind.mjGEOM_PLANE:
            mesh, colour = make.cylinder(ARENA_RADIUS_CM, 0.02, sections=72), (*FLOOR, 255)
        case kind.mjGEOM_BOX:
            mesh = make.box((2 * x, 2 * y, 2 * z))
        case kind.mjGEOM_CYLINDER:
            mesh = make.cylinder(x, 2 * y)
        case kind.mjGEOM_CAPSULE:
            mesh = make.capsule(2 * y, x)
            mesh.apply_translation((0.0, 0.0, -mesh.bounds.mean(axis=0)[2]))
        case kind.mjGEOM_MESH:
            mesh = _of_file(model, index)
        case _:
            mesh = make.icosphere()
            mesh.apply_scale((x, y or x, z or x))
    if mesh.visual.kind != "texture":
        mesh.visual.face_colors = np.asarray(colour, np.uint8)
    return mesh


def _of_file(model: mujoco.MjModel, index: int) -> Any:
    """Return the mesh of a geom, with its texture where it has one; a vertex for each corner of a face."""
    which, material = model.geom_dataid[index], model.geom_matid[index]
    faces = slice(first := model.mesh_faceadr[which], first + model.mesh_facenum[which])
    corners = (CM * model.mesh_vert[model.mesh_vertadr[which] :])[model.mesh_face[faces].ravel()]
    mesh: Any = trimesh.Trimesh(corners, np.arange(len(corners)).reshape(-1, 3), process=False)
    texture = -1 if material < 0 else model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB.value]
    if texture >= 0 and model.mesh_texcoordadr[which] >= 0:
        shape = model.tex_height[texture], model.tex_width[texture], model.tex_nchannel[texture]
        pixels = model.tex_data[model.tex_adr[texture] :][: math.prod(shape)].reshape(shape)
        uv = model.mesh_texcoord[model.mesh_texcoordadr[which] :][model.mesh_facetexcoord[faces].ravel()]
        visual: Any = trimesh.visual
        look = visual.material.PBRMaterial(
            baseColorTexture=Image.fromarray(pixels), metallicFactor=0.0, roughnessFactor=1.0, doubleSided=False
        )
        mesh.visual = visual.TextureVisuals(uv * (1, -1) + (0, 1), material=look)
    return mesh
