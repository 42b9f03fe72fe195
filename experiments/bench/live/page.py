"""The page of ``colias live``, of viser's parts: what is drawn, and what a person may ask of the session.

Everything that a browser sends comes in on viser's threads. It is put into a queue, and done between two frames in the
thread that runs the trial. What is refused there is shown to everybody who looks at the page, and changes nothing.
"""

from __future__ import annotations

import contextlib
import dataclasses
import io
import math
import queue
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt
import viser
from viser import uplot

from colias_sim.config import CameraConfig, SceneConfig
from dsnn import MODELS
from experiments import NAMES
from experiments.bench.engine.errors import UsageError
from experiments.bench.engine.models import PRESET, ConfiguredModel, family
from experiments.bench.engine.settings import described, preset_of, schema_of
from experiments.bench.figures.palette import marks
from experiments.bench.live.session import START, Robot, Session, View, number_of
from experiments.bench.registry import load

CM = 100.0
"""Units of the page for each of the simulation: it is drawn in centimetres."""
SHOWN_FRAMES = 180
"""Frames of the running traces."""
ENLARGED = 4
"""Pixels of the page for each of the camera's, along either side."""
GREY = "#8c8c8c"
NONE = "none"
BY_HAND = "by hand"
AHEAD, BACK, STOP, LEFT, RIGHT = "ahead", "back", "stop", "left", "right"
MOVES: Mapping[str, tuple[float, float]] = {
    LEFT: (0.0, 90.0), AHEAD: (1.0, 0.0), STOP: (0.0, 0.0), BACK: (-1.0, 0.0), RIGHT: (0.0, -90.0),
}  # fmt: skip
"""Button -> share of the speed, and turn rate in degrees/s."""
KEYS = {AHEAD: "W", BACK: "S", LEFT: "A", RIGHT: "D", STOP: "X"}
"""Move of the stimulus -> its key; with shift it is the observer's."""
RATES = {"1": 1.0, "1/2": 0.5, "1/4": 0.25, "1/10": 0.1, "as fast as it can": math.inf}
"""Name of a pace -> simulated seconds for each second."""
MAPS = {"retina P": "p", "lamina LA": "la", "ON after FDSR": "f_on", "OFF after FDSR": "f_off"}
"""Name of a layer map -> what a `dsnn.Response` calls it."""
WORLD = {
    "scene": ("light", "light_sd", "wall_contrast", "shell_grey"),
    "camera": (PRESET, "shot_noise", "read_noise", "exposure_ms", "blur_px"),
}
"""Section -> its parameters that the page offers."""
Floats = npt.NDArray[np.float64]


class Page:
    """The page of a session.

    Attributes
    ----------
    paused
        Whether the trial stands still.
    pace
        Simulated seconds for each second.

    Parameters
    ----------
    session
        What it shows.
    host, port
        Where it listens.
    """

    def __init__(self, session: Session, host: str, port: int, *, dark: bool = False) -> None:
        self.session = session
        self.paused, self.pace, self._steps = False, 1.0, 0
        self._asked: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._times: deque[float] = deque(maxlen=30)
        self._traces: dict[str, deque[float]] = {}
        self._ghost: Floats | None = None
        with contextlib.redirect_stdout(io.StringIO()):  # its banner: the command prints the address
            self.server = viser.ViserServer(host, port, label="colias live", verbose=False)
        self.server.scene.set_up_direction("+z")
        self.server.initial_camera.position = (-30.0, 0.0, 42.0)
        self.server.initial_camera.look_at = (9.0, 0.0, 0.0)
        self._theme(dark)
        self.server.gui.main_panel.dock_right()
        self._dark = dark
        self._world: list[Any] = []
        self._parameters: list[Any] = []
        self._sliders: dict[tuple[str, str], Any] = {}
        self._accepted: dict[int, Any] = {}
        self._map = NONE
        self._build()
        self._draw_arena()
        self._draw_parameters()

    @property
    def address(self) -> str:
        """Where a browser finds it."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def close(self) -> None:
        """Stop listening."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    # What comes in

    def ask(self, do: Callable[[], None]) -> None:
        """Let something be done between two frames."""
        self._asked.put(do)

    def heed(self) -> None:
        """Do what was asked for; what is refused is shown, and changes nothing."""
        for _ in range(self._asked.qsize()):
            do = self._asked.get()
            try:
                do()
            except UsageError as error:
                self.tell(str(error))
            except (ValueError, TypeError, KeyError) as error:
                self.tell(f"refused: {error}")

    def follow(self, handle: Any, do: Callable[[Any], None]) -> None:
        """Do something with every new value of a control; one that is refused goes back to the value before."""
        self._accepted[id(handle)] = handle.value

        def new(value: Any) -> None:
            before = self._accepted[id(handle)]
            if value == before:
                return
            try:
                do(value)
            except (ValueError, TypeError, KeyError):
                handle.value = before
                raise
            self._accepted[id(handle)] = value

        handle.on_update(lambda event: self.ask(lambda: new(event.target.value)))

    def put(self, handle: Any, value: Any) -> None:
        """Let a control show a value, without doing anything."""
        self._accepted[id(handle)] = value
        handle.value = value

    def tell(self, text: str) -> None:
        """Show a line to everybody who looks at the page."""
        self._note.content = text.replace("<", "&lt;")
        for client in self.server.get_clients().values():
            client.add_notification("colias live", text, auto_close_seconds=6.0)

    def due(self) -> bool:
        """Say whether a frame is to be computed: not while it is paused, but for single steps."""
        if not self.paused:
            return True
        if self._steps:
            self._steps -= 1
            return True
        return False

    # What is built once

    def _theme(self, dark: bool) -> None:
        self.server.gui.configure_theme(control_width="large", dark_mode=dark, show_logo=False, show_share_button=False)

    def _build(self) -> None:
        gui = self.server.gui
        self._status = gui.add_markdown("starting")
        camera = self.session.spec.settings.camera
        blank = np.zeros((camera.height * ENLARGED, camera.width * ENLARGED, 3), np.uint8)
        self._image = gui.add_image(blank, label="what the camera sees", format="jpeg", jpeg_quality=90)
        self._plot: Any = None
        self._spikes: Any = None
        self._plots = gui.add_folder("HS and VS against T, spikes")
        self._note = gui.add_markdown("")
        tabs = gui.add_tab_group()
        with tabs.add_tab("Drive"):
            self._build_drive()
        with tabs.add_tab("Time"):
            pause = gui.add_button_group("time", ("pause", "step", "again"), hint="Space, N, R")
            pace = gui.add_dropdown("pace", tuple(RATES), initial_value="1")
            dark = gui.add_checkbox("dark", self._dark)
            maps = gui.add_dropdown("layer map", (NONE, *MAPS), hint="of the first model, instead of the frame")
        pause.on_click(lambda event: self.ask(lambda: self._time(str(event.target.value))))
        self.follow(pace, lambda value: self._set_pace(str(value)))
        self.follow(dark, lambda value: self._theme(bool(value)))
        self.follow(maps, lambda value: self._set_map(str(value)))
        self._tab = tabs.add_tab("Model")
        with tabs.add_tab("World"):
            self._build_world()
        with tabs.add_tab("Record"):
            gui.add_markdown("Records this trial since it began, as a run that `colias rerun` repeats bit for bit.")
            record = gui.add_button("record", hint="key E")
        record.on_click(lambda _: self.ask(self._record))
        self._build_commands()

    def _build_drive(self) -> None:
        gui, session = self.server.gui, self.session
        stimulus = gui.add_button_group("stimulus", tuple(MOVES), hint="keys A, W, X, S, D; or drag its handle")
        observer = gui.add_button_group("observer", tuple(MOVES), hint="the same keys with shift")
        speed = gui.add_slider("speed, cm/s", 0.5, 35.0, 0.5, session.speed_cm_s)
        click = gui.add_dropdown("a click on the floor sends", ("stimulus", "observer"), initial_value="stimulus")
        # Behaviours of files are none of a page's business: it names registered ones alone.
        from experiments.behaviours import BEHAVIOURS

        driven = [name for name, entry in BEHAVIOURS.items() if entry.senses == "neural"]
        behaviour = gui.add_dropdown("the observer's driver", (BY_HAND, *driven))
        names = tuple(NAMES)
        experiment = gui.add_dropdown("trial", (BY_HAND, *names), hint="a condition of an experiment, looped")
        condition = gui.add_slider("its condition", 0, 40, 1, 0)
        for group, robot in ((stimulus, "stimulus"), (observer, "observer")):
            group.on_click(lambda event, robot=robot: self.ask(lambda: self._move(robot, str(event.target.value))))
        self.follow(speed, lambda value: session.set_speed(number_of(value)))
        self.follow(behaviour, lambda value: self._behave(str(value), driven))
        self.follow(experiment, lambda value: self._show(str(value), int(number_of(condition.value)), names))
        self.follow(condition, lambda value: self._show(str(experiment.value), int(number_of(value)), names))

        def floor(event: Any) -> None:
            self.ask(lambda: self._click(str(click.value), event.ray_origin, event.ray_direction))

        self.server.scene.on_click()(floor)

        self._handle = self.server.scene.add_transform_controls(
            "/handle", scale=5.0, active_axes=(True, True, False), disable_rotations=True,
            translation_limits=((-44.0, 44.0), (-44.0, 44.0), (4.5, 4.5)), depth_test=False,
        )  # fmt: skip
        self._dragged = 0.0

        def drag(event: Any) -> None:
            x, y = (float(value) for value in event.target.position[:2])
            self._dragged = time.monotonic()
            self.ask(lambda: session.send("stimulus", number_of(x), number_of(y)))

        self._handle.on_update(drag)

    def _build_world(self) -> None:
        gui, settings = self.server.gui, self.session.spec.settings
        for section, names in WORLD.items():
            value: SceneConfig | CameraConfig = settings.scene if section == "scene" else settings.camera
            for name in names:
                self._control(section, value, name, partial(self._set_world, f"{section}.{name}"))
        reset = gui.add_button("reset the world")
        reset.on_click(lambda _: self.ask(self._reset_world))

    def _build_commands(self) -> None:
        gui = self.server.gui
        robots: tuple[Robot, ...] = ("stimulus", "observer")
        for robot in robots:
            for move, key in KEYS.items():
                command = gui.add_command(
                    f"{robot}: {move}", hotkey=key, modifier=None if robot == "stimulus" else "shift"
                )  # fmt: skip
                command.on_trigger(lambda _, robot=robot, move=move: self.ask(lambda: self._move(robot, move)))
        for label, hotkey, word in (("pause or go on", "space", "pause"), ("one frame", "N", "step"),
                                    ("begin again", "R", "again")):  # fmt: skip
            key_command = gui.add_command(label, hotkey=hotkey)
            key_command.on_trigger(lambda _, word=word: self.ask(lambda: self._time(word)))
        gui.add_command("record", hotkey="E").on_trigger(lambda _: self.ask(self._record))
        gui.add_command("reset the model's parameters", hotkey="Z").on_trigger(lambda _: self.ask(self._reset_model))

    # What is asked for

    def _time(self, word: str) -> None:
        if word == "pause":
            self.paused = not self.paused
        elif word == "step":
            self.paused, self._steps = True, self._steps + 1
        elif word == "again":
            self.session.begin(START)
        else:
            raise UsageError(f"time {word}: legal is pause, step, again")

    def _set_map(self, name: str) -> None:
        if name != NONE and name not in MAPS:
            raise UsageError(f"layer map {name}: legal is {NONE}, {', '.join(MAPS)}")
        self._map = name
        self.session.show_maps(name != NONE)

    def _set_pace(self, name: str) -> None:
        if name not in RATES:
            raise UsageError(f"pace {name}: legal is {', '.join(RATES)}")
        self.pace = RATES[name]

    def _move(self, robot: Robot, move: str) -> None:
        if move not in MOVES:
            raise UsageError(f"move {move}: legal is {', '.join(MOVES)}")
        self.session.drive(robot, *MOVES[move])

    def _behave(self, name: str, known: Iterable[str]) -> None:
        if name != BY_HAND and name not in known:
            raise UsageError(f"behaviour {name}: legal is {BY_HAND}, {', '.join(known)}")
        self.session.behave("" if name == BY_HAND else name)

    def _show(self, name: str, index: int, known: Iterable[str]) -> None:
        if name != BY_HAND and name not in known:
            raise UsageError(f"trial {name}: legal is {BY_HAND}, {', '.join(known)}")
        if name == BY_HAND:
            if not self.session.by_hand:
                self.session.show("")
        else:
            last = len(load(name).conditions()) - 1
            self.session.show(name, min(index, last))
            self.tell(f"{name}, condition {min(index, last)} of {last}: {self.session.spec.condition.label()}")
        self._begun()

    def _click(self, robot: str, origin: Iterable[float], direction: Iterable[float]) -> None:
        (x, y, z), (dx, dy, dz) = map(number_of, origin), map(number_of, direction)
        if dz >= 0.0:
            return
        self.session.send("observer" if robot == "observer" else "stimulus", x - dx * z / dz, y - dy * z / dz)

    def _record(self) -> None:
        folder = self.session.record().folder
        self.tell(f"recorded into {folder}; repeat it by: colias rerun {folder}")

    def _set_models(self, names: Iterable[str]) -> None:
        chosen = [name for name in names if name != NONE]
        for name in chosen:
            if name not in MODELS and name not in self.session.models:
                raise UsageError(f"model {name}: legal are the registered ones")
        self.session.choose_models(chosen)
        self._begun()

    def _begun(self) -> None:
        """Draw what belongs to the models and the apparatus anew."""
        self._draw_arena()
        self._draw_parameters()

    def _set_world(self, key: str, text: str) -> None:
        self.session.set(key, text)
        self._draw_arena()

    def _reset_world(self) -> None:
        for key in [k for k in self.session.settings if k.partition(".")[0] in WORLD]:
            self.session.set(key, "")
        for (section, name), handle in self._sliders.items():
            if section in WORLD:
                settings = self.session.spec.settings
                value = getattr(settings.scene if section == "scene" else settings.camera, name, None)
                if name == PRESET:
                    self.put(handle, preset_of(settings.camera) or handle.value)
                elif isinstance(value, int | float):
                    self.put(handle, value)
        self._draw_arena()

    def _change(self, label: str, name: str, text: str) -> None:
        self._snapshot()
        self.session.change(label, name, text)

    def _snapshot(self) -> None:
        """Keep the present trace of HS as a ghost."""
        first = next(iter(self._traces), None)
        if first is not None:
            self._ghost = _padded(self._traces[first])

    def _reset_model(self) -> None:
        self._snapshot()
        self.session.reset_parameters()
        self._draw_parameters()

    # Controls of parameters

    def _control(self, section: str, value: Any, name: str, changed: Callable[[str], None]) -> None:
        """Add the control of a parameter, by its field's range and unit."""
        gui, schema = self.server.gui, schema_of(value, name)
        described_ = {parameter.key: parameter for parameter in described({section: value})}[f"{section}.{name}"]
        label = f"{name}{f', {described_.unit}' if described_.unit else ''}"
        hint = f"{described_.description}; legal: {described_.legal}; here: {described_.value or 'none'}"
        present = getattr(value, name, None)
        handle: Any
        if "enum" in schema:
            options = tuple(map(str, schema["enum"]))
            first = described_.value if described_.value in options else options[0]
            handle = gui.add_dropdown(label, options, initial_value=first, hint=hint)
        elif isinstance(present, bool):
            handle = gui.add_checkbox(label, present, hint=hint)
        elif isinstance(present, int | float):
            low, high = _ends(schema, present)
            if low is None or high is None:
                handle = gui.add_number(label, present, min=low, max=high, hint=hint)
            else:
                step = 1 if isinstance(present, int) else _step(low, high)
                handle = gui.add_slider(
                    label, min(low, present), max(high, present), step, present,
                    marks=((present, "preset"),), hint=hint,
                )  # fmt: skip
        elif schema.get("type") == "array":
            handle = gui.add_text(label, described_.value, hint=hint)
        else:  # a text may name a file, which is none of a page's business
            return
        self.follow(handle, lambda value: changed(str(value)))
        self._sliders[section, name] = handle

    def _draw_parameters(self) -> None:
        """Draw the models' names and sliders, one folder a model."""
        for handle in self._parameters:
            handle.remove()
        self._parameters.clear()
        gui, session = self.server.gui, self.session
        names = tuple(dict.fromkeys([*MODELS, *session.models]))
        with self._tab:
            shown = list(session.models)
            first = gui.add_dropdown("model", names, initial_value=shown[0])
            second = gui.add_dropdown("beside it", (NONE, *names), initial_value=shown[1] if len(shown) > 1 else NONE)
            reset = gui.add_button("reset the parameters", hint="key Z")
            self._parameters += [first, second, reset]
            for model in session.spec.settings.models:
                folder = gui.add_folder(model.label)
                self._parameters.append(folder)
                with folder:
                    self._draw_model(model)
        self.follow(first, lambda value: self._set_models((str(value), str(second.value))))
        self.follow(second, lambda value: self._set_models((str(first.value), str(value))))
        reset.on_click(lambda _: self.ask(self._reset_model))
        self._draw_plots()

    def _draw_model(self, model: ConfiguredModel) -> None:
        section = family(model.label, type(model.network))
        for field in dataclasses.fields(model.network):
            self._control(section, model.network, field.name, partial(self._change, model.label, field.name))

    # Plots

    def _draw_plots(self) -> None:
        for plot in (self._plot, self._spikes):
            if plot is not None:
                plot.remove()
        models = self.session.spec.settings.models
        looks = marks([model.label for model in models])
        self._traces = {}
        series: list[Any] = [{"label": "s"}, uplot.Series(label="before the change", stroke="#b9a88a", width=2)]
        counts: list[Any] = [{"label": "s"}]
        self._limits: list[float] = []
        for model in models:
            colour, label = looks[model.label].colour, model.label
            for channel in (c for c in ("hs", "vs", "looming") if c in model.channels):
                self._traces[f"{label} {channel}"] = deque([0.0] * SHOWN_FRAMES, SHOWN_FRAMES)
                dash = {} if channel == "hs" else {"dash": [6, 4] if channel == "vs" else [2, 3]}
                series.append(uplot.Series(label=f"{label} {channel.upper()}", stroke=colour, width=2, **dash))
            self._traces[f"{label} spikes"] = deque([0.0] * SHOWN_FRAMES, SHOWN_FRAMES)
            counts.append(uplot.Series(label=f"{label} spikes", stroke=colour, width=2))
            if model.threshold is not None and model.threshold not in self._limits:
                self._limits += [model.threshold, -model.threshold]
        for limit in self._limits:
            series.append(
                uplot.Series(label=f"{'' if limit > 0 else '-'}T {abs(limit):g}", stroke=GREY, width=1, dash=[3, 3])
            )
        self._ghost = None
        axes = (uplot.Axis(stroke=GREY), uplot.Axis(stroke=GREY))
        scales = {"x": uplot.Scale(time=False), "y": uplot.Scale(auto=True)}
        with self._plots:
            self._plot = self.server.gui.add_uplot(
                self._curves(), tuple(series), scales=scales, axes=axes, height=210, legend=uplot.Legend(live=False)
            )
            self._spikes = self.server.gui.add_uplot(
                self._counts(), tuple(counts), scales=scales, axes=axes, height=130, legend=uplot.Legend(live=False)
            )

    def _x(self) -> Floats:
        fps = self.session.spec.settings.camera.fps
        return (np.arange(SHOWN_FRAMES) - SHOWN_FRAMES + 1) / fps

    def _curves(self) -> tuple[Floats, ...]:
        potentials = [_padded(trace) for name, trace in self._traces.items() if not name.endswith(" spikes")]
        blank = potentials[0] if potentials else np.zeros(SHOWN_FRAMES)
        ghost = blank if self._ghost is None else self._ghost  # where there is none, it lies under the first trace
        limits = [np.full(SHOWN_FRAMES, limit) for limit in self._limits]
        return (self._x(), ghost, *potentials, *limits)

    def _counts(self) -> tuple[Floats, ...]:
        return (self._x(), *(_padded(trace) for name, trace in self._traces.items() if name.endswith(" spikes")))

    # The arena

    def _draw_arena(self) -> None:
        """Draw the visible geoms: those of a robot below a frame that moves with it."""
        for handle in self._world:
            handle.remove()
        sim, scene = self.session.trial.sim, self.server.scene
        model, data = sim.model, sim.data
        self._frames = {name: scene.add_frame(f"/{name}", show_axes=False) for name in sim.robots}
        self._world = list(self._frames.values())
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
                self._world.append(handle)
        camera = self.session.spec.settings.camera
        vertical = 2 * math.atan(math.tan(math.radians(camera.hfov_deg) / 2) * camera.height / camera.width)
        self._world.append(
            scene.add_camera_frustum(
                "/observer/eye", vertical, camera.width / camera.height, scale=4.0, color=(17, 55, 177),
                position=(camera.forward_cm, 0.0, 2.5), wxyz=(0.5, -0.5, 0.5, -0.5),
            )
        )  # fmt: skip

    def _draw_geom(self, model: mujoco.MjModel, index: int, name: str) -> Any:
        scene, kind, size = self.server.scene, mujoco.mjtGeom, CM * model.geom_size[index]
        material = model.geom_matid[index]
        rgba = model.mat_rgba[material] if material >= 0 else model.geom_rgba[index]
        colour = tuple(int(255 * part) for part in rgba[:3])
        match model.geom_type[index]:
            case kind.mjGEOM_PLANE:
                return scene.add_box(name, (205, 205, 205), (90.0, 90.0, 0.02), opacity=0.6)
            case kind.mjGEOM_BOX:
                return scene.add_box(name, colour, tuple(2 * size))
            case kind.mjGEOM_CYLINDER:
                return scene.add_cylinder(name, size[0], 2 * size[1], colour)
            case kind.mjGEOM_SPHERE:
                return scene.add_icosphere(name, size[0], colour)
            case kind.mjGEOM_MESH:
                mesh = model.geom_dataid[index]
                first, faces = model.mesh_vertadr[mesh], model.mesh_faceadr[mesh]
                vertices = model.mesh_vert[first : first + model.mesh_vertnum[mesh]]
                triangles = model.mesh_face[faces : faces + model.mesh_facenum[mesh]]
                return scene.add_mesh_simple(name, CM * vertices, triangles, color=colour, opacity=0.35, side="double")
        return None

    # Every frame

    def show(self, view: View, simulated: float) -> None:
        """Show a frame, with ``simulated`` seconds for each second of the clock."""
        with self.server.atomic():
            for name, pose in view.poses.items():
                frame = self._frames[name]
                frame.position = (CM * pose.x, CM * pose.y, 0.0)
                frame.wxyz = (math.cos(pose.heading / 2), 0.0, 0.0, math.sin(pose.heading / 2))
            if time.monotonic() - self._dragged > 1.5:
                stimulus = view.poses["stimulus"]
                self._handle.position = (CM * stimulus.x, CM * stimulus.y, 4.5)
            self._image.image = _enlarged(self._picture(view))
            for label, answer in view.answers.items():
                for channel in ("hs", "vs", "looming", "spikes"):
                    trace = self._traces.get(f"{label} {channel}")
                    if trace is not None:
                        trace.append(0.0 if answer is None else _value(answer, channel))
            self._plot.data, self._spikes.data = self._curves(), self._counts()
            self._status.content = self._line(view, simulated)

    def _picture(self, view: View) -> npt.NDArray[np.uint8]:
        """Return the camera's frame, or the chosen map of the first model that has it, about a middle grey."""
        answer = next(iter(view.answers.values()), None)
        layer = getattr(answer and answer.maps, MAPS[self._map], None) if self._map != NONE else None
        if layer is None:
            return view.frame.luma
        most = max(float(np.abs(layer).max()), 1e-9)
        return np.asarray(127.5 + 127.5 * layer / most, np.uint8)

    def _line(self, view: View, simulated: float) -> str:
        cost = ", ".join(f"{label} {1000 * seconds:.2f} ms" for label, seconds in view.seconds.items())
        broken = [
            f"**{runner.label} broke: {runner.trouble}**" for runner in self.session.trial.watching if runner.trouble
        ]
        trial = (
            "by hand"
            if self.session.by_hand
            else f"{self.session.spec.experiment}: {self.session.spec.condition.label()}"
        )
        counted = {runner.label: runner.chosen.counted for runner in self.session.trial.watching}
        answers = ", ".join(
            f"{label} {counted[label].upper()} {getattr(answer, counted[label]):+.3f}"
            for label, answer in view.answers.items() if answer is not None and counted[label]
        )  # fmt: skip
        return "  \n".join([
            f"frame {view.number}, {view.frame.time:.2f} s{', paused' if self.paused else ''}; {trial}",
            f"{answers}; a frame costs {cost}; simulated / wall time {simulated:.2f}", *broken,
        ])  # fmt: skip


def _enlarged(grey: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    return np.repeat(np.repeat(np.repeat(grey[:, :, None], 3, 2), ENLARGED, 0), ENLARGED, 1)


def _padded(trace: Iterable[float]) -> Floats:
    return np.array(list(trace), np.float64)


def _value(answer: Any, channel: str) -> float:
    if channel == "spikes":
        return float(answer.hs_spikes or answer.vs_spikes or answer.looming_spikes)
    return float(getattr(answer, channel))


def _ends(schema: Mapping[str, Any], present: float) -> tuple[Any, Any]:
    """Return the least and the largest legal value of a number; ``None`` where there is none."""
    low, high = schema.get("minimum"), schema.get("maximum")
    if low is None and (above := schema.get("exclusiveMinimum")) is not None and high is not None:
        low = above + _step(above, high)
    elif low is None:
        low = schema.get("exclusiveMinimum")
    if high is None and (below := schema.get("exclusiveMaximum")) is not None and low is not None:
        high = below - _step(low, below)
    kind = int if isinstance(present, int) else float
    return None if low is None else kind(low), None if high is None else kind(high)


def _step(low: float, high: float) -> float:
    """Return a step of a slider: some 200 of them, a power of ten."""
    return float(10.0 ** math.floor(math.log10(max(high - low, 1e-6) / 100)))
