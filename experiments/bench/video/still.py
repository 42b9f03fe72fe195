"""The still part of a video's frames: axes, titles, thresholds. matplotlib draws it once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from experiments.bench.figures.plotting import STYLE, drawing, plain
from experiments.bench.video.layout import KEYS_A_ROW, Layout, Panel, apart, levels_of, moves_on, traces_of
from experiments.bench.video.pictures import Picture
from experiments.bench.video.reading import Reel, Trace
from scenes import ARENA_RADIUS_CM

LEVEL_COLOUR, FRAME_COLOUR, FAINT = "#7a7a7a", "#555555", 0.2
BINS = {"potential": 5, "spikes": 3}
"""Most intervals between the numbers of a panel that all models share."""
OBSTACLE_COLOUR = "#9a9a9a"
SCALE_CM = 10.0
"""Length of the plan's scale."""
TYPE_PX = 15.0
"""Size of type, in pixels at plain size."""


def draw_still(reel: Reel, layout: Layout, caption: str) -> Picture:
    """Return the picture of what `still_of` draws, (H, W, 3) uint8, RGB; the parameters are the same."""
    return still_of(reel, layout, caption).picture()


def still_of(reel: Reel, layout: Layout, caption: str) -> Still:
    """Draw all of a frame that does not move.

    Parameters
    ----------
    reel
        The recording.
    layout
        Where its panels are.
    caption
        The text at the top.

    Returns
    -------
    Still
        The figure.
    """
    still = Still(layout.width, layout.height, layout.scale)
    still.caption(caption)
    for panel, eye in zip(layout.eyes, reel.eyes, strict=True):
        still.empty(panel, eye_title(eye))
    if layout.plan is not None:
        still.plan(layout.plan, "from above", reel.obstacles)
    for key in layout.traces:
        still.traces(reel, key, layout.traces, faint=True)
    return still


class Still:
    """A figure whose unit is the pixel.

    Parameters
    ----------
    width, height
        In pixels.
    scale
        Size of type and lines.

    Attributes
    ----------
    figure
        The figure, at 72 dots an inch.
    """

    def __init__(self, width: int, height: int, scale: float) -> None:
        self._width, self._height, self._scale = width, height, scale
        self._style = {**STYLE, "font.size": TYPE_PX * scale, "axes.linewidth": 0.8 * scale}
        self.figure = Figure(figsize=(width / 72, height / 72), dpi=72)  # a point is a pixel
        self._canvas = FigureCanvasAgg(self.figure)

    def caption(self, text: str) -> None:
        """Write the text at the top."""
        scale = self._scale
        self.figure.text(14 * scale / self._width, 1 - 24 * scale / self._height, plain(text), va="center",
                          fontsize=1.2 * TYPE_PX * scale)  # fmt: skip

    def empty(self, panel: Panel, title: str) -> Axes:
        """Draw the frame of a picture, with its title."""
        axes = self._axes(panel)
        axes.set(xticks=[], yticks=[])
        axes.set_title(plain(title), loc="left", fontsize=TYPE_PX * self._scale, pad=4 * self._scale,
                       color=FRAME_COLOUR)  # fmt: skip
        return axes

    def plan(self, panel: Panel, title: str, obstacles: Sequence[npt.NDArray[np.float64]] = ()) -> None:
        """Draw the arena from above: its wall, its obstacles and a scale."""
        axes, scale = self.empty(panel, title), self._scale
        axes.set(facecolor="#f4f4f2")
        turn = np.linspace(0.0, 2 * np.pi, 181)
        axes.plot(ARENA_RADIUS_CM * np.cos(turn), ARENA_RADIUS_CM * np.sin(turn), color=FRAME_COLOUR, lw=2 * scale)
        for outline in obstacles:
            axes.fill(*outline.T, facecolor=OBSTACLE_COLOUR, edgecolor=FRAME_COLOUR, lw=scale)
        start, level = (near + 0.06 * (far - near) for near, far in (panel.x, panel.y))
        axes.plot([start, start + SCALE_CM], [level, level], color="black", lw=2 * scale, solid_capstyle="butt")
        axes.annotate(f"{SCALE_CM:g} cm", (start, level), xytext=(0, 4 * scale), textcoords="offset points",
                      fontsize=0.85 * TYPE_PX * scale)  # fmt: skip

    def traces(self, reel: Reel, key: str, panels: Mapping[str, Panel], *, faint: bool) -> None:
        """Draw the axes of potentials or spikes, and the thresholds; the traces themselves only where they are whole.

        ``key`` is that of one of the ``panels``. ``faint`` traces are a background for what moves.
        """
        panel, (kind, _, model) = panels[key], key.partition("/")
        axes, scale = self._axes(panel), self._scale
        axes.axhline(0.0, color="#c9c9c9", lw=0.8 * scale)
        traces = traces_of(reel, key)
        if kind == "potential":
            for trace in traces if not (faint and moves_on(reel)) else ():
                axes.plot(trace.time_s, trace.values, color=_hex(trace), ls=":" if trace.dotted else "-",
                          lw=1.4 * scale, alpha=FAINT if faint else 1.0)  # fmt: skip
            for level in levels_of(reel, key):
                axes.axhline(level, color=LEVEL_COLOUR, lw=1.0 * scale, ls="--")
            self._key(axes, reel, traces, model)
        elif not faint:
            for trace in traces:
                fired = trace.values != 0
                if trace.dotted:
                    axes.plot(trace.time_s[fired], trace.values[fired], ".", color=_hex(trace), ms=5 * scale)
                else:
                    axes.vlines(trace.time_s[fired], 0.0, trace.values[fired], color=_hex(trace), lw=1.4 * scale)
        beside = [other for name, other in panels.items() if name.partition("/")[0] == kind]
        lowest = all(other.left != panel.left or other.top <= panel.top for other in panels.values())
        axes.tick_params(width=0.8 * scale, length=3 * scale, labelbottom=lowest)
        if kind == "spikes" and model and not apart(reel):  # a row among others, one below the other
            axes.set_yticks([int(panel.y[1])])
            labelled = panel == beside[len(beside) // 2]
        else:
            axes.locator_params(axis="y", nbins=2 if model and kind == "spikes" else 3 if model else BINS[kind],
                                integer=kind == "spikes")  # fmt: skip
            labelled = not model or (kind == "potential" and panel.left == min(other.left for other in beside))
        if labelled:
            axes.set_ylabel(kind)
        if lowest:
            axes.locator_params(axis="x", nbins=4 if apart(reel) else 9)
            axes.set_xlabel("time before now (s)" if faint and moves_on(reel) else "time (s)")

    def _key(self, axes: Axes, reel: Reel, traces: Sequence[Trace], model: str) -> None:
        """Draw the key above a panel of potentials: of all models, or of one, whose name is its title."""
        scale = self._scale
        size = TYPE_PX * scale * (0.85 if model else 1.0)
        prefix = f"{model} " if model else ""
        keys = [Line2D([], [], color=_hex(trace), lw=2.5 * scale, ls=":" if trace.dotted else "-",
                       label=plain(trace.name.removeprefix(prefix))) for trace in traces]  # fmt: skip
        if reel.levels and not model:
            keys.append(Line2D([], [], color=LEVEL_COLOUR, ls="--", lw=1.0 * scale, label=_levels(reel)))
        key = axes.legend(handles=keys, ncols=min(len(keys), KEYS_A_ROW), loc="lower right", bbox_to_anchor=(1.0, 1.0),
                    frameon=False, borderaxespad=0.1, handlelength=1.4, columnspacing=1.2 if not model else 0.8,
                    fontsize=size)  # fmt: skip
        if model:
            title = axes.set_title(plain(model), loc="left", fontsize=size, pad=4 * scale)
            renderer = self._canvas.get_renderer()  # type: ignore[no-untyped-call]
            with drawing({}):
                room = key.get_window_extent(renderer).x0
                for length in range(len(model) - 1, 0, -1):  # cut to where the key begins
                    if title.get_window_extent(renderer).x1 <= room:
                        break
                    title.set_text(plain(f"{model[:length]}..."))

    def picture(self) -> Picture:
        """Return the figure, (H, W, 3) uint8, RGB."""
        with drawing(self._style):
            self._canvas.draw()  # type: ignore[no-untyped-call]
            pixels = np.asarray(self._canvas.buffer_rgba(), np.uint8)  # type: ignore[no-untyped-call]
            return pixels[..., :3].copy()

    def _axes(self, panel: Panel) -> Axes:
        bottom = self._height - panel.top - panel.height
        place = (
            panel.left / self._width, bottom / self._height, panel.width / self._width, panel.height / self._height,
        )  # fmt: skip
        with mpl.rc_context(self._style):
            return self.figure.add_axes(place, xlim=panel.x, ylim=panel.y)


def eye_title(entity: str) -> str:
    """Return what is written above the pictures of an eye."""
    name = entity.partition("_")[2]
    return {"picture": "what the network sees", "clip": "clip"}.get(
        entity, f"the robot's camera{f', {name}' if name else ''}"
    )


def _levels(reel: Reel) -> str:
    sizes = sorted({abs(level) for level in reel.levels})
    return f"threshold {'±' if min(reel.levels) < 0 else ''}{', '.join(f'{size:g}' for size in sizes)}"


def _hex(trace: Trace) -> str:
    return "#{:02x}{:02x}{:02x}".format(*trace.colour)
