"""The page of ``colias live``, made of viser's parts: the camera's frame, the network's responses, controls, the loop.

Browsers' events arrive on viser's threads. They are put into a queue, and handled between two frames in the thread that
advances the session. A change that is refused changes nothing: its control returns to the session's value.

It draws running traces of potentials and spikes, and the arena with its robots, in centimetres.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
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
from experiments.base.errors import TrialError, UsageError
from experiments.declare.conditions import FASTEST_CM_S
from experiments.live.session import ROBOTS, Session
from experiments.settings.settings import described, schema_of
from experiments.show.play import Sample
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
        now = (runner.chosen.threshold for runner in self._session.runners)
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


IMAGE_PX = 396
"""Width at which the camera's frame is sent, or a whole number of its pixels below that."""
IDLE_S = 0.02
"""Time between two looks at the queue."""
MOVES: Mapping[str, tuple[float, float, str]] = {
    "left": (0.0, 90.0, "J"), "ahead": (1.0, 0.0, "I"), "stop": (0.0, 0.0, "X"), "back": (-1.0, 0.0, "K"),
    "right": (0.0, -90.0, "L"),
}  # fmt: skip
"""Button -> share of the speed, turn rate in degrees/s, and its key; with shift it is the observer's."""
WORLD = {
    "scene": ("light", "light_sd", "wall_contrast", "shell_grey"),
    "camera": ("shot_noise", "read_noise", "exposure_ms", "blur_px"),
}
"""Section -> its parameters that the page offers."""
HINT = """**Make it fire: press `I`.** The black robot crosses the camera's view, and HS passes T.

| | |
|---|---|
| `I` `K` | drive the stimulus ahead, back |
| `J` `L` `X` | turn it left, right; stop |
| with shift | the same for the observer |
| `Space` `N` | pause or go on; one frame |
| `R` `C` | begin again; record |
| `Z` | the first parameters |
"""


class Page:
    """The page of a session.

    Attributes
    ----------
    paused
        Whether the session stands still.

    Parameters
    ----------
    session
        What it shows.
    port
        Where it listens, on this machine.
    """

    def __init__(self, session: Session, port: int = 8099) -> None:
        self.session, self.paused = session, False
        self._steps = 0
        self._drawn: object = None
        self._asked: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._controls: list[tuple[Any, Callable[[], Any]]] = []
        self.server = viser.ViserServer("127.0.0.1", port, label="colias live", verbose=False)
        self._build()

    def enqueue(self, do: Callable[[], None]) -> None:
        """Queue a call, to be made between two frames."""
        self._asked.put(do)

    def handle_queue(self) -> None:
        """Make the queued calls, then let every control show the session's value."""
        count = self._asked.qsize()
        for _ in range(count):
            try:
                self._asked.get()()
            except (ValueError, TypeError, KeyError) as error:
                self.show_note(str(error))
        if count:
            self._refresh()

    def _refresh(self) -> None:
        for handle, present in self._controls:
            if handle.value != (value := present()):
                handle.value = value

    def show_note(self, text: str) -> None:
        """Show a text to everybody who looks at the page."""
        self.note.content = text.replace("<", "&lt;").replace("\n", "  \n")

    def follow(self, handle: Any, do: Callable[[Any], None], present: Callable[[], Any]) -> None:
        """Let a control queue ``do`` with each new value; ``present`` returns the session's value."""

        async def update(event: Any) -> None:  # at once, in viser's loop: from its pool a refresh could come before it
            value = event.target.value
            self.enqueue(lambda: None if value == present() else do(value))

        self._controls.append((handle, present))
        handle.on_update(update)

    def _parameter(self, section: str, holder: Callable[[], Any], name: str) -> None:
        """Add the control of a parameter, by its field's range and unit; none of a text, which may name a file."""
        gui, value, key = self.server.gui, holder(), f"{section}.{name}"
        schema, now = schema_of(value, name), getattr(value, name, None)
        field = next(field for field in described({section: value}) if field["key"] == key)
        label = f"{name}, {field['unit']}" if field["unit"] else name
        hint = f"{field['description']}; {field['legal']}; here: {field['value'] or 'none'}"
        present: Callable[[], Any] = lambda: getattr(holder(), name)  # noqa: E731
        handle: Any
        if "enum" in schema:
            present = lambda: str(getattr(holder(), name))  # noqa: E731
            handle = gui.add_dropdown(label, tuple(map(str, schema["enum"])), initial_value=present(), hint=hint)
        elif isinstance(now, bool):
            handle = gui.add_checkbox(label, now, hint=hint)
        elif isinstance(now, int | float):
            handle = _number(gui, label, schema, now, hint)
        else:
            return
        self.follow(handle, lambda value: self.session.set(key, str(value)), present)

    def _build(self) -> None:
        """Add the panels and the controls."""
        gui, enqueue, session = self.server.gui, self.enqueue, self.session
        gui.configure_theme(show_logo=False, show_share_button=False)
        panel = gui.add_panel()
        with panel.add_tab("Network"):
            self._status = gui.add_markdown("")
            self._image = gui.add_image(np.zeros((72, 99, 3), np.uint8), label="the camera's frame")
            with gui.add_folder("HS and VS against T, spikes"):
                self.traces = Traces(gui, session)
        panel.dock_left()
        panel.set_width(400.0)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(370.0)
        gui.add_markdown(HINT)
        self.note = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Drive"):
            self._build_drive()
        with tabs.add_tab("Model"):
            self._build_models()
        with tabs.add_tab("World"):
            for section, name in ((section, name) for section, names in WORLD.items() for name in names):
                holder = partial(lambda section: getattr(session.spec.settings, section), section)
                self._parameter(section, holder, name)
        commands: tuple[tuple[str, Any, Callable[[], None]], ...] = (
            ("pause or continue", "space", partial(self.time, "pause")), ("one frame", "N", partial(self.time, "step")),
            ("begin again", "R", partial(self.time, "again")), ("record", "C", self.record),
            ("reset the parameters", "Z", session.reset_parameters),
        )  # fmt: skip
        for label, key, do in commands:
            gui.add_command(label, hotkey=key).on_trigger(lambda _, do=do: enqueue(do))

    def _build_models(self) -> None:
        """Add the models' parameters, a folder a model."""
        gui, session = self.server.gui, self.session
        gui.add_button("reset the parameters", hint="key Z").on_click(lambda _: self.enqueue(session.reset_parameters))
        for place, runner in enumerate(session.runners):
            holder = partial(lambda place: session.runners[place].chosen.network, place)
            with gui.add_folder(runner.label):
                for field in dataclasses.fields(runner.chosen.network):
                    self._parameter(runner.chosen.section, holder, field.name)

    def _build_drive(self) -> None:
        """Add the controls of the robots, and the arena."""
        session, server, gui = self.session, self.server, self.server.gui
        enqueue = self.enqueue
        server.scene.set_up_direction("+z")
        server.initial_camera.position, server.initial_camera.look_at = (-34.0, 0.0, 66.0), (5.0, 0.0, 0.0)
        self.scene = Scene(server.scene)

        for robot in ROBOTS:
            group = gui.add_button_group(robot, tuple(MOVES))
            group.on_click(
                lambda event, robot=robot: enqueue(partial(session.drive, robot, *MOVES[event.target.value][:2]))
            )
            for move, (ahead, turn, key) in MOVES.items():
                shift: Any = None if robot == "stimulus" else "shift"
                command = gui.add_command(f"{robot}: {move}", hotkey=key, modifier=shift)
                do = partial(session.drive, robot, ahead, turn)
                command.on_trigger(lambda _, do=do: enqueue(do))
        speed = gui.add_slider("speed, cm/s", 0.5, FASTEST_CM_S, 0.5, session.speed_cm_s)
        self.follow(speed, lambda value: setattr(session, "speed_cm_s", float(value)), lambda: session.speed_cm_s)
        pause = gui.add_button_group("time", ("pause", "step", "again"))
        pause.on_click(lambda event: enqueue(partial(self.time, str(event.target.value))))
        record = gui.add_button("record", hint="C: a run of this trial since its beginning")
        record.on_click(lambda _: enqueue(self.record))

    def time(self, word: str) -> None:
        """Pause or continue, advance one frame, or begin again."""
        if word == "pause":
            self.paused = not self.paused
        elif word == "step":
            self.paused, self._steps = True, self._steps + 1
        else:
            self.session.begin()

    def record(self) -> None:
        """Record the trial since its beginning."""
        folder = self.session.record().folder
        self.show_note(f"recorded into {folder}; repeat it by: colias run --again {folder}")

    def show(self, sample: Sample) -> None:
        """Show a frame."""
        session = self.session
        with self.server.atomic():
            if self._drawn is not session.trial.sim:  # a new trial of the same scene is drawn already
                self._drawn = session.trial.sim
                self.scene.draw(session.trial.sim, session.spec.settings.camera)
                self._refresh()
            self.scene.move(session.poses)
            times = max(1, IMAGE_PX // sample.image.shape[1])
            self._image.image = np.repeat(sample.image.repeat(times, 0).repeat(times, 1)[:, :, None], 3, 2)
            self.traces.add(session.responses)
            self._status.content = self._line(sample)

    def _line(self, sample: Sample) -> str:
        session = self.session
        lines = [f"frame {session.number - 1}, {sample.time_s:.2f} s"]
        for runner, response in zip(session.runners, session.responses.values(), strict=True):
            label, channel = runner.label, runner.chosen.counted
            if response is None:
                lines.append(f"**{label} raised**\n```\n{runner.trouble}\n```" if runner.trouble else label)
                continue
            value = f"{channel.upper()} {getattr(response, channel):+.3f}, " if channel else ""
            lines.append(f"{label}: {value}{1000 * session.cost_s[label]:.2f} ms a frame")
        return "  \n".join(lines)

    def serve(self) -> None:
        """Show frame after frame at the pace of the clock. A slow machine slows it down; no frame is skipped."""
        session, due = self.session, time.perf_counter()
        while True:
            self.handle_queue()
            if self.paused and not self._steps:
                time.sleep(IDLE_S)
                due = time.perf_counter()
                continue
            self._steps = max(self._steps - 1, 0)
            try:
                sample = session.step()
            except (TrialError, UsageError) as error:
                self.show_note(str(error))
                self.paused = True
                continue
            self.show(sample)
            due = max(due + session.interval_s, time.perf_counter() - session.interval_s)
            while (left := due - time.perf_counter()) > 0.0:
                time.sleep(min(left, IDLE_S))
                self.handle_queue()


def _number(gui: viser.GuiApi, label: str, schema: Mapping[str, Any], now: float, hint: str) -> Any:
    """Add the control of a number: a slider where it has two ends, with a mark at the present value."""
    low, high = (schema.get(name, schema.get(f"exclusive{name.capitalize()}")) for name in ("minimum", "maximum"))
    if low is None or high is None:
        return gui.add_number(label, now, min=None if low is None else type(now)(low), hint=hint)
    slot = 1 if isinstance(now, int) else float(10.0 ** math.floor(math.log10(max(high - low, 1e-6) / 100)))
    marks = ((now, f"{now:g}"),)
    return gui.add_slider(label, type(now)(min(low, now)), type(now)(max(high, now)), slot, now, marks=marks, hint=hint)
