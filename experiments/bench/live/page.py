"""The page of ``colias live``, of viser's parts: what the network sees and answers, and the controls."""

from __future__ import annotations

import contextlib
import dataclasses
import io
import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from dsnn import MODELS
from experiments.bench.live.arena import ArenaSession
from experiments.bench.live.driving import HINT, Driving
from experiments.bench.live.inputs import Inputs
from experiments.bench.live.session import Session, View
from experiments.bench.live.traces import Traces
from experiments.bench.run.errors import UsageError
from experiments.bench.run.play import ModelRunner

IMAGE_PX = 396
"""Width at which the camera's frame is sent, or a whole number of its pixels below that."""
LEFT_PX, RIGHT_PX = 400.0, 370.0
"""Widths of the two panels."""
SETTLING_FRAMES = 45
"""Frames after which a new browser draws the plots anew: laying out its panels, it may leave out the time axis."""
PAUSED = "  \n**paused**"
NONE, FRAME = "none", "the camera's frame"
RATES = {"1": 1.0, "1/2": 0.5, "1/4": 0.25, "1/10": 0.1, "as fast as it can": math.inf}
"""Name of a pace -> simulated seconds for each second."""
MAPS = {"retina P": "p", "lamina LA": "la", "ON after FDSR": "f_on", "OFF after FDSR": "f_off"}
"""Name of a layer map -> what a `dsnn.Response` calls it."""
FILM_HINT = """**The network watches the footage.** Move its parameters in the tab *Model*.

| | |
|---|---|
"""
SHARED_HINT = """| `Space` `N` | pause or go on; one frame |
| `R` `C` | begin again; record |
| `Z` | the model's parameters as they were |
"""


class Page:
    """The page of a session.

    Attributes
    ----------
    paused
        Whether the session stands still.
    pace
        Simulated seconds for each second.

    Parameters
    ----------
    session
        What it shows.
    host, port
        Where it listens.
    dark
        Whether it begins dark.
    """

    def __init__(self, session: Session, host: str, port: int, *, dark: bool = False) -> None:
        self.session = session
        self.paused, self.pace, self.dark = False, 1.0, dark
        self._steps, self._map, self._settling = 0, NONE, 0
        with contextlib.redirect_stdout(io.StringIO()):  # its banner: the command prints the address
            self.server = viser.ViserServer(host, port, label="colias live", verbose=False)
        self.inputs = Inputs(self.server.gui, self.tell)
        self.driving = Driving(self.server, self.inputs, session) if isinstance(session, ArenaSession) else None
        self._traces: Traces | None = None
        self._film: Any = None
        self._drawn: list[Any] = []
        self._drawn_models: object = None
        self._theme()
        self._build()

    @property
    def address(self) -> str:
        """The URL of the page."""
        return f"http://{self.server.get_host()}:{self.server.get_port()}"

    def close(self) -> None:
        """Stop listening."""
        with contextlib.redirect_stdout(io.StringIO()):
            self.server.stop()

    def tell(self, text: str) -> None:
        """Show a text to everybody who looks at the page."""
        self._note.content = text.replace("<", "&lt;").replace("\n", "  \n")
        for client in self.server.get_clients().values():
            client.add_notification("colias live", text, auto_close_seconds=6.0)

    def due(self) -> bool:
        """Say whether a frame is to be computed: not while it is paused, but for single steps."""
        if self.paused and not self._steps:
            return False
        self._steps = max(self._steps - 1, 0)
        return True

    # What is built once

    def _theme(self) -> None:
        self.server.gui.configure_theme(dark_mode=self.dark, show_logo=False, show_share_button=False)

    def _build(self) -> None:
        gui, ask, follow = self.server.gui, self.inputs.ask, self.inputs.follow
        panel = gui.add_panel()
        with panel.add_tab("Network"):
            self._status = gui.add_markdown("")
            self._image = gui.add_image(np.zeros((72, 99, 3), np.uint8), label=FRAME)
            self._plots = gui.add_folder("HS and VS against T, spikes")
        panel.dock_left()
        panel.set_width(LEFT_PX)
        gui.main_panel.dock_right()
        gui.main_panel.set_width(RIGHT_PX)
        gui.add_markdown((HINT if self.driving else FILM_HINT) + SHARED_HINT)
        self._note = gui.add_markdown("")
        tabs = gui.add_tab_group()
        if self.driving:
            with tabs.add_tab("Drive"):
                self.driving.build_drive()
        self._tab = tabs.add_tab("Model")
        if self.driving:
            with tabs.add_tab("World"):
                self.driving.build_world()
        with tabs.add_tab("View"):
            pause = gui.add_button_group("time", ("pause", "step", "again"), hint="Space, N, R")
            pace = gui.add_dropdown("pace", tuple(RATES), initial_value="1", hint="seconds shown for each second")
            maps = gui.add_dropdown("layer map", (NONE, *MAPS), hint="of the first model, in place of the frame")
            dark = gui.add_checkbox("dark", self.dark)
            record = gui.add_button("record", hint="C: a run of what was done since the beginning")
        pause.on_click(lambda event: ask(partial(self.time, str(event.target.value))))
        record.on_click(lambda _: ask(self.record))
        follow(pace, self._set_pace, lambda: next(name for name, rate in RATES.items() if rate == self.pace))
        follow(maps, self._set_map, lambda: self._map)
        follow(dark, self._set_dark, lambda: self.dark)
        commands: tuple[tuple[str, Any, Callable[[], None]], ...] = (
            ("pause or go on", "space", partial(self.time, "pause")),
            ("one frame", "N", partial(self.time, "step")),
            ("begin again", "R", partial(self.time, "again")),
            ("record", "C", self.record),
            ("reset the model's parameters", "Z", self.reset_model),
        )
        self.server.on_client_connect(lambda _: self.inputs.ask(self._settle))
        for label, key, do in commands:
            gui.add_command(label, hotkey=key).on_trigger(lambda _, do=do: ask(do))

    # What is asked for

    def time(self, word: str) -> None:
        """Pause or go on, go one frame, or begin again."""
        if word == "pause":
            self.paused = not self.paused
            self._status.content = self._status.content.replace(PAUSED, "")
            if self.paused:
                self._status.content += PAUSED
        elif word == "step":
            self.paused, self._steps = True, self._steps + 1
        elif word == "again":
            self.session.begin()
        else:
            raise UsageError(f"time {word}: legal is pause, step, again")

    def record(self) -> None:
        """Record what was done since the beginning."""
        folder = self.session.record().folder
        self.tell(f"recorded into {folder}; repeat it by: colias run --again {folder}")

    def change(self, model: str, name: str, text: str) -> None:
        """Change a parameter of a model; the trace before stays as a ghost."""
        self.session.change(model, name, text)
        self._freeze()

    def reset_model(self) -> None:
        """Give the models the parameters that they began with."""
        self.session.reset_parameters()
        self._freeze()

    def set_models(self, names: Iterable[str]) -> None:
        """Show other models."""
        chosen = [name for name in dict.fromkeys(names) if name != NONE]
        for name in chosen:
            if name not in self._known():
                raise UsageError(f"model {name}: legal are {', '.join(self._known())}")
        self.session.choose_models(chosen)

    def _known(self) -> tuple[str, ...]:
        """Return the models that a page may name: those registered, and those that the command was given."""
        return tuple(dict.fromkeys([*MODELS, *self.session.given]))

    def _settle(self) -> None:
        self._settling = SETTLING_FRAMES

    def _freeze(self) -> None:
        if self._traces is not None:
            self._traces.freeze()

    def _set_dark(self, dark: bool) -> None:
        self.dark = dark
        self._theme()
        if self._traces is not None:
            self._traces.dark = dark
            self._traces.paint()

    def _set_map(self, name: str) -> None:
        if name != NONE and name not in MAPS:
            raise UsageError(f"layer map {name}: legal is {NONE}, {', '.join(MAPS)}")
        self._map = name
        self._image.label = FRAME if name == NONE else name
        self.session.show_maps(name != NONE)

    def _set_pace(self, name: str) -> None:
        if name not in RATES:
            raise UsageError(f"pace {name}: legal is {', '.join(RATES)}")
        self.pace = RATES[name]

    # Every frame

    def show(self, view: View, rate: float) -> None:
        """Show a frame, at ``rate`` simulated seconds for each second of the clock."""
        with self.server.atomic():
            if self._drawn_models != (models := [runner.chosen for runner in self.session.watching]):
                self._drawn_models = models
                self._draw_models()
            if self.driving:
                self.driving.show(view)
            else:
                self._show_film(view.luma)
            picture = self._picture(view)
            times = max(1, IMAGE_PX // picture.shape[1])
            self._image.image = _grey(np.repeat(np.repeat(picture, times, 0), times, 1))
            assert self._traces is not None
            self._traces.add(view)
            if self._settling == 1:
                self._traces.redraw()
            self._settling = max(self._settling - 1, 0)
            self._status.content = self._line(view, rate)

    def _show_film(self, luma: npt.NDArray[np.uint8]) -> None:
        """Show footage where the arena would be, facing the viewer."""
        if self._film is None:
            scene, (rows, columns) = self.server.scene, luma.shape
            scene.set_up_direction("-y")
            self.server.initial_camera.position, self.server.initial_camera.look_at = (0.0, 0.0, -1.2), (0.0, 0.0, 0.0)
            self._film = scene.add_image("/film", _grey(luma), columns / rows, 1.0)
        self._film.image = _grey(luma)

    def _draw_models(self) -> None:
        """Draw the models' names and sliders, a folder a model, and their traces."""
        for handle in self._drawn:
            handle.remove()
        if self._traces is not None:
            self._traces.remove()
        gui, session = self.server.gui, self.session
        names, (one, *others) = self._known(), session.models
        with self._tab:
            first = gui.add_dropdown("model", names, initial_value=one)
            second = gui.add_dropdown("beside it", (NONE, *names), initial_value=others[0] if others else NONE)
            reset = gui.add_button("reset the parameters", hint="key Z")
            self._drawn = [first, second, reset]
            for runner in session.watching:
                folder = gui.add_folder(runner.label)
                self._drawn.append(folder)
                with folder:
                    self._draw_parameters(runner)
        reset.on_click(lambda _: self.inputs.ask(self.reset_model))
        self.inputs.follow(
            first, lambda name: self.set_models((name, *self.session.models[1:])), lambda: self.session.models[0]
        )
        self.inputs.follow(
            second, lambda name: self.set_models((self.session.models[0], name)),
            lambda: (*self.session.models, NONE)[1],
        )  # fmt: skip
        with self._plots:
            self._traces = Traces(gui, session, self.dark)

    def _draw_parameters(self, runner: ModelRunner) -> None:
        label = runner.label

        def network() -> Any:
            return next(runner.network for runner in self.session.watching if runner.label == label)

        for field in dataclasses.fields(runner.network):
            self.inputs.parameter(runner.section, network, field.name, partial(self.change, label, field.name))

    def _picture(self, view: View) -> npt.NDArray[np.uint8]:
        """Return the camera's frame, or the chosen map of the first model that has it, about a middle grey."""
        answer = next(iter(view.answers.values()), None)
        layer = getattr(answer and answer.maps, MAPS[self._map], None) if self._map != NONE else None
        if layer is None:
            return view.luma
        most = max(float(np.abs(layer).max()), 1e-9)
        return np.asarray(127.5 + 127.5 * layer / most, np.uint8)

    def _line(self, view: View, rate: float) -> str:
        number = f"frame {view.number}, {view.time_s:.2f} s; simulated / wall time {rate:.2f}"
        lines = [self.session.title, number]
        for runner in self.session.watching:
            answer, channel, label = view.answers[runner.label], runner.chosen.counted, runner.label
            if runner.trouble:
                lines.append(f"**{label} broke**\n```\n{runner.trouble}\n```")
                continue
            value = f"{channel.upper()} {getattr(answer, channel):+.3f}, " if answer is not None and channel else ""
            lines.append(f"{label}: {value}{1000 * view.seconds[label]:.2f} ms a frame")
            began = runner.chosen.network
            changed = (
                f"{name} {getattr(began, name)} -> {now}"
                for name in self.session.values.get(label, ())
                if (now := getattr(runner.network, name)) != getattr(began, name)
            )
            if text := ", ".join(changed):
                lines.append(f"**{label} changed: {text}**")
        return "  \n".join(lines) + (PAUSED if self.paused else "")


def _grey(luma: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    return np.repeat(luma[:, :, None], 3, 2)
