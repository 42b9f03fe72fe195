"""The page of ``colias live``, made of viser's parts: the camera's frame, the network's responses, controls, the loop.

Browsers' events arrive on viser's threads. They are put into a queue, and handled between two frames in the thread that
advances the session. A change that is refused changes nothing: its control returns to the session's value.
"""

from __future__ import annotations

import dataclasses
import math
import queue
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
import viser

from experiments.base.errors import TrialError, UsageError
from experiments.declare.conditions import FASTEST_CM_S
from experiments.live.drawing import Scene, Traces
from experiments.live.session import ROBOTS, Session
from experiments.settings.settings import described, schema_of
from experiments.show.play import Sample

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
| `Z` | the model's first parameters |
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

    def _parameter(self, section: str, holder: Callable[[], Any], name: str, do: Callable[[str], None]) -> None:
        """Add the control of a parameter, by its field's range and unit; none of a text, which may name a file."""
        gui, value = self.server.gui, holder()
        schema, now = schema_of(value, name), getattr(value, name, None)
        field = next(field for field in described({section: value}) if field["key"] == f"{section}.{name}")
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
        self.follow(handle, lambda value: do(str(value)), present)

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
                self._parameter(section, holder, name, partial(session.set, f"{section}.{name}"))
        commands: tuple[tuple[str, Any, Callable[[], None]], ...] = (
            ("pause or continue", "space", partial(self.time, "pause")), ("one frame", "N", partial(self.time, "step")),
            ("begin again", "R", partial(self.time, "again")), ("record", "C", self.record),
            ("reset the model's parameters", "Z", session.reset_parameters),
        )  # fmt: skip
        for label, key, do in commands:
            gui.add_command(label, hotkey=key).on_trigger(lambda _, do=do: enqueue(do))

    def _build_models(self) -> None:
        """Add the models' parameters, a folder a model."""
        gui, session = self.server.gui, self.session
        gui.add_button("reset the parameters", hint="key Z").on_click(lambda _: self.enqueue(session.reset_parameters))
        for place, runner in enumerate(session.runners):
            holder = partial(lambda place: session.runners[place].network, place)
            with gui.add_folder(runner.label):
                for field in dataclasses.fields(runner.network):
                    do = partial(session.change, runner.label, field.name)
                    self._parameter(runner.section, holder, field.name, do)

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
            if self._drawn is not session.trial:
                self._drawn = session.trial
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
