"""Controls of the page: what they ask of the session is done between two frames, and they show what it then has.

Everything that a browser sends comes in on viser's threads. It is put into a queue, and done in the thread that
advances the session. What is refused there changes nothing: the control goes back to what the session has.
"""

from __future__ import annotations

import contextlib
import math
import queue
from collections.abc import Callable, Mapping
from typing import Any

import viser

from experiments.bench.run.errors import UsageError
from experiments.bench.run.models import PRESET
from experiments.bench.run.settings import described, preset_of, schema_of

CHANGED = "changed"
"""Option of a preset's control that is shown where the values are those of no preset."""


class Inputs:
    """The controls of a page, and the queue of what they ask for.

    Parameters
    ----------
    gui
        Where they are added.
    tell
        Called with a line about what was refused.
    """

    def __init__(self, gui: viser.GuiApi, tell: Callable[[str], None]) -> None:
        self._gui, self._tell = gui, tell
        self._asked: queue.SimpleQueue[Callable[[], None]] = queue.SimpleQueue()
        self._controls: list[tuple[Any, Callable[[], Any]]] = []

    def ask(self, do: Callable[[], None]) -> None:
        """Let something be done between two frames."""
        self._asked.put(do)

    def heed(self) -> None:
        """Do what was asked for, then let every control show what the session has."""
        count = self._asked.qsize()
        for _ in range(count):
            try:
                self._asked.get()()
            except UsageError as error:
                self._tell(str(error))
            except (ValueError, TypeError, KeyError) as error:
                self._tell(f"refused: {error}")
        if count:
            self.refresh()

    def refresh(self) -> None:
        """Let every control show what the session has."""
        self._controls = [(handle, present) for handle, present in self._controls if not handle._impl.removed]
        for handle, present in self._controls:
            # A hostile message may have spoilt a control (viser sets any attribute that one names): no other suffers.
            with contextlib.suppress(Exception):
                if handle.value != (value := present()):
                    handle.value = value

    def follow(self, handle: Any, do: Callable[[Any], None], present: Callable[[], Any]) -> None:
        """Let a control ask for something by each new value.

        Parameters
        ----------
        handle
            The control.
        do
            Called with the value.
        present
            Returns the value that the session has.
        """

        async def update(event: Any) -> None:  # at once, in viser's loop: from its pool a refresh could come before it
            value = event.target.value
            self.ask(lambda: None if value == present() else do(value))

        self._controls.append((handle, present))
        handle.on_update(update)

    def parameter(self, section: str, holder: Callable[[], Any], name: str, do: Callable[[str], None]) -> None:
        """Add the control of a parameter, by its field's range and unit; none of a text, which may name a file.

        Parameters
        ----------
        section
            Of ``--set``.
        holder
            Returns what has the parameter, as it is now.
        name
            Of the parameter.
        do
            Called with a new value's text.
        """
        gui, value = self._gui, holder()
        schema, key = schema_of(value, name), f"{section}.{name}"
        field = next(field for field in described({section: value}) if field.key == key)
        label = f"{name}{f', {field.unit}' if field.unit else ''}"
        hint = f"{field.description}; legal: {field.legal}; here: {field.value or 'none'}"
        now = getattr(value, name, None)
        present: Callable[[], Any] = lambda: getattr(holder(), name)  # noqa: E731
        handle: Any
        if name == PRESET:
            present = lambda: preset_of(holder()) or CHANGED  # noqa: E731
            handle = gui.add_dropdown(label, (*schema["enum"], CHANGED), initial_value=present(), hint=hint)
        elif "enum" in schema:
            present = lambda: str(getattr(holder(), name))  # noqa: E731
            handle = gui.add_dropdown(label, tuple(map(str, schema["enum"])), initial_value=present(), hint=hint)
        elif isinstance(now, bool):
            handle = gui.add_checkbox(label, now, hint=hint)
        elif isinstance(now, int | float):
            handle = _number(gui, label, schema, now, hint)
        elif schema.get("type") == "array":
            present = lambda: ",".join(f"{part:g}" for part in getattr(holder(), name))  # noqa: E731
            handle = gui.add_text(label, present(), hint=hint)
        else:
            return
        self.follow(handle, lambda value: do(str(value)), present)


def _number(gui: viser.GuiApi, label: str, schema: Mapping[str, Any], now: float, hint: str) -> Any:
    """Add the control of a number: a slider where it has two ends, with a mark at the present value."""
    low, high = ends(schema, now)
    if low is None or high is None:
        return gui.add_number(label, now, min=low, max=high, hint=hint)
    slot = 1 if isinstance(now, int) else step(low, high)
    return gui.add_slider(
        label, min(low, now), max(high, now), slot, now, marks=((now, f"{now:g}"),), hint=hint
    )  # fmt: skip


def ends(schema: Mapping[str, Any], present: float) -> tuple[Any, Any]:
    """Return the least and the largest legal value of a number; ``None`` where there is none."""
    low, high = schema.get("minimum"), schema.get("maximum")
    above, below = schema.get("exclusiveMinimum"), schema.get("exclusiveMaximum")
    if low is None and above is not None:
        low = above if high is None else above + step(above, high)
    if high is None and below is not None and low is not None:
        high = below - step(low, below)
    kind = int if isinstance(present, int) else float
    return None if low is None else kind(low), None if high is None else kind(high)


def step(low: float, high: float) -> float:
    """Return a step of a slider: some 200 of them, a power of ten."""
    return float(10.0 ** math.floor(math.log10(max(high - low, 1e-6) / 100)))
