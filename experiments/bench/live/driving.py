"""The arena on the page of a session: the tabs for driving and for the world, their keys, and the arena itself."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any

import viser

from experiments.bench.live.arena import ROBOTS, ArenaSession, Robot
from experiments.bench.live.inputs import Inputs
from experiments.bench.live.scene import Scene
from experiments.bench.live.session import View, number_of
from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import PRESET

BY_HAND = "by hand"
AHEAD, BACK, STOP, LEFT, RIGHT = "ahead", "back", "stop", "left", "right"
MOVES: Mapping[str, tuple[float, float]] = {
    LEFT: (0.0, 90.0), AHEAD: (1.0, 0.0), STOP: (0.0, 0.0), BACK: (-1.0, 0.0), RIGHT: (0.0, -90.0),
}  # fmt: skip
"""Button -> share of the speed, and turn rate in degrees/s."""
KEYS = {AHEAD: "I", BACK: "K", LEFT: "J", RIGHT: "L", STOP: "X"}
"""Move of the stimulus -> its key; with shift it is the observer's. By W, A, S, D, Q and E viser moves the view."""
WORLD = {
    "scene": ("light", "light_sd", "wall_contrast", "shell_grey"),
    "camera": (PRESET, "shot_noise", "read_noise", "exposure_ms", "blur_px"),
}
"""Section -> its parameters that the page offers."""
HINT = """**Make it fire: press `I`.** The black robot crosses the camera's view, and HS passes T.

| | |
|---|---|
| `I` `K` | drive the stimulus ahead, back |
| `J` `L` `X` | turn it left, right; stop |
| with shift | the same for the observer |
"""


class Driving:
    """The arena of a session on the page.

    Parameters
    ----------
    server
        Of the page.
    inputs
        Its controls.
    session
        What they drive.
    """

    def __init__(self, server: viser.ViserServer, inputs: Inputs, session: ArenaSession) -> None:
        self._server, self._inputs, self._session = server, inputs, session
        server.scene.set_up_direction("+z")
        server.initial_camera.position, server.initial_camera.look_at = (-34.0, 0.0, 66.0), (5.0, 0.0, 0.0)
        self._scene = Scene(server.scene, lambda x, y: inputs.ask(lambda: session.send("stimulus", x, y)))
        self._clicked: Any = None
        self._drawn_trial: object = None
        server.scene.on_click()(lambda event: inputs.ask(lambda: self.click(event.ray_origin, event.ray_direction)))
        for robot in ROBOTS:
            for move, key in KEYS.items():
                command = server.gui.add_command(
                    f"{robot}: {move}", hotkey=key, modifier=None if robot == "stimulus" else "shift"
                )
                command.on_trigger(lambda _, robot=robot, move=move: inputs.ask(partial(self.move, robot, move)))

    @property
    def handle(self) -> Any:
        """The handle by which the stimulus is dragged."""
        return self._scene.handle

    def build_drive(self) -> None:
        """Add the controls of the robots."""
        gui, session, follow = self._server.gui, self._session, self._inputs.follow
        for robot in ROBOTS:
            group = gui.add_button_group(robot, tuple(MOVES), hint=f"keys J, I, X, K, L{_shift(robot)}")
            group.on_click(
                lambda event, robot=robot: self._inputs.ask(partial(self.move, robot, str(event.target.value)))
            )
        speed = gui.add_slider("speed, cm/s", 0.5, 35.0, 0.5, session.speed_cm_s)
        self._clicked = gui.add_dropdown("a click on the floor sends", ROBOTS)
        drivers = (BY_HAND, *session.behaviours)
        driver = gui.add_dropdown("the observer's driver", drivers, initial_value=session.behaviour or BY_HAND)
        trials = (BY_HAND, *session.experiments)
        trial = gui.add_dropdown(
            "trial", trials, initial_value=self._trial(), hint="by hand, or a condition of an experiment in a loop"
        )
        self.condition = gui.add_dropdown("its condition", self._labels(), initial_value=self._label())
        follow(speed, lambda value: session.set_speed(number_of(value)), lambda: session.speed_cm_s)
        follow(driver, lambda value: session.behave("" if value == BY_HAND else str(value)),
               lambda: session.behaviour or BY_HAND)  # fmt: skip
        follow(trial, lambda value: session.show("" if value == BY_HAND else str(value)), self._trial)
        follow(self.condition, self._choose, self._label)

    def build_world(self) -> None:
        """Add the controls of light, wall and eye."""
        session = self._session
        for section, names in WORLD.items():
            for name in names:
                holder = partial(lambda section: getattr(session.spec.settings, section), section)
                self._inputs.parameter(section, holder, name, partial(session.set, f"{section}.{name}"))
        reset = self._server.gui.add_button("reset the world")
        reset.on_click(lambda _: self._inputs.ask(session.reset_world))

    def move(self, robot: Robot, name: str) -> None:
        """Drive a robot as a button or a key says."""
        self._session.drive(robot, *MOVES[name])

    def click(self, origin: Iterable[float], direction: Iterable[float]) -> None:
        """Send a robot to where a ray meets the floor; nowhere, where it meets none."""
        (x, y, z), (dx, dy, dz) = map(number_of, origin), map(number_of, direction)
        if dz < 0.0:
            robot: Robot = "observer" if self._clicked.value == "observer" else "stimulus"
            self._session.send(robot, x - dx * z / dz, y - dy * z / dz)

    def show(self, view: View) -> None:
        """Show where the robots are; the arena anew, where a trial began."""
        session = self._session
        if self._drawn_trial is not session.trial:
            self._drawn_trial = session.trial
            self._scene.draw(session.trial.sim, session.spec.settings.camera)
            if self.condition.options != (labels := self._labels()):
                self.condition.options = labels
            self._inputs.refresh()
        self._scene.move(view.poses)

    def _trial(self) -> str:
        return self._session.looped[0] if self._session.looped else BY_HAND

    def _labels(self) -> tuple[str, ...]:
        looped = self._session.looped
        if not looped:
            return ("",)
        return tuple(f"{i}: {condition.label()}" for i, condition in enumerate(self._session.conditions(looped[0])))

    def _label(self) -> str:
        looped = self._session.looped
        return self._labels()[looped[1]] if looped else ""

    def _choose(self, label: str) -> None:
        if not self._session.looped:
            raise UsageError("no experiment is looped: choose one as the trial first")
        self._session.show(self._session.looped[0], int(number_of(label.partition(":")[0])))


def _shift(robot: str) -> str:
    return "; or drag its handle" if robot == "stimulus" else ", with shift"
