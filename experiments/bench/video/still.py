"""The still part of a video's frames: axes, titles, thresholds. matplotlib draws it once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text

from experiments.bench.figures.plotting import STYLE, drawing, plain
from experiments.bench.run.record import OFF, ON, mixed, to_hex
from experiments.bench.video.layout import (
    LEFT,
    MOST_DOWN,
    ONE_COLUMN,
    SMALLER,
    SMALLEST,
    Layout,
    Panel,
    levels_of,
    moves_on,
    seeing,
    traces_of,
)
from experiments.bench.video.pictures import Floats, Picture
from experiments.bench.video.reading import Reel
from scenes import ARENA_RADIUS_CM

LEVEL_COLOUR, FRAME_COLOUR, FAINT = "#6b6b6b", "#555555", 0.22
OBSTACLE_COLOUR = "#9a9a9a"
DARKER = 0.28
"""Share of black in the colours of changes where type is written in them on white."""
SCALE_CM = 10.0
"""Length of the plan's scale."""
CLOCK_PX = 360.0
"""Room that the spikes so far and the time take at the right of the caption, at plain size."""
ARROW = "\N{RIGHTWARDS ARROW} motion seen"
"""What the arrow on a picture of changes is: the motion that a model answers, HS to the right and VS downward."""
SIGNS = {"hs": "right +", "vs": "down +"}
"""Channel -> the motion that a positive potential is of."""
SPIKE_SHARE = 0.11
"""Length of the longest stroke of a spike, as a share of its lane's height."""
TYPE_PX = 27.0
"""Size of type, in pixels at plain size: some 8 pixels where a frame 1280 wide is shown 390 wide."""
SMALL = 0.85
"""Size of the type of axes and of keys beside a title, as a share of that of titles."""
CLEAR, CLEAR_LANE = 0.22, 0.4
"""Room below the line that a title stands on, as shares of its size: above pictures, and above lanes, whose titles have
brackets, and at whose edge strokes of spikes stand."""


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
    if layout.outside is not None:
        still.empty(layout.outside, "the world")
    if layout.plan is not None:
        still.plan(layout.plan, "from above", reel.obstacles)
    if layout.change is not None:
        still.change(layout.change, model=seeing(reel) if len(layout.lanes) > 1 else "")
    for model in layout.lanes:
        still.lane(reel, model, layout.lanes, faint=True)
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
        size, room = 0.95 * TYPE_PX * scale, self._width - CLOCK_PX * scale
        line = self.figure.text(20 * scale / self._width, 1 - 27 * scale / self._height, plain(text), va="center",
                                fontsize=size)  # fmt: skip
        renderer = self._canvas.get_renderer()  # type: ignore[no-untyped-call]
        with drawing(self._style):
            for length in range(len(text) - 1, 0, -1):
                if line.get_window_extent(renderer).x1 <= room:
                    break
                line.set_text(plain(f"{text[:length].rstrip()}..."))

    def empty(self, panel: Panel, title: str) -> Axes:
        """Draw the frame of a picture, with its title."""
        axes = self._axes(panel)
        axes.set(xticks=[], yticks=[])
        size = TYPE_PX * self._scale
        axes.set_title(plain(title), loc="left", fontsize=size, pad=CLEAR * size, color=FRAME_COLOUR)
        return axes

    def change(self, panel: Panel, room: float | None = None, model: str = "") -> Axes:
        """Draw the frame of a picture of changes; its title has the colours that these have, but darker.

        What the arrow is, by which ``model``, stands beside them where there is ``room`` for it, in pixels: by default
        the panel's width.
        """
        axes, size = self.empty(panel, ""), TYPE_PX * self._scale
        brighter, darker = (to_hex(mixed(colour, (0, 0, 0), DARKER)) for colour in (ON, OFF))
        words = [("brighter", brighter), (" / ", FRAME_COLOUR), ("darker", darker)]
        words.append((f"  {ARROW}{f' by {plain(model)}' if model else ''}", FRAME_COLOUR))
        self._words(axes, words, SMALL * size, CLEAR * size, room=panel.width if room is None else room)
        return axes

    def plan(self, panel: Panel, title: str, obstacles: Sequence[Floats]) -> None:
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
                      fontsize=SMALL * TYPE_PX * scale)  # fmt: skip

    def lane(self, reel: Reel, model: str, lanes: Mapping[str, Panel], *, faint: bool) -> None:
        """Draw the lane of a model: its axes, title and thresholds; potentials faint, or whole and with spikes.

        ``faint`` traces are a background for what moves.
        """
        panel, scale = lanes[model], self._scale
        size = TYPE_PX * scale * (SMALLER if len(lanes) > 1 else 1.0)
        axes = self._axes(panel)
        axes.axhline(0.0, color="#c9c9c9", lw=1.0 * scale)
        traces = traces_of(reel, model)
        for trace in traces if not (faint and moves_on(reel)) else ():
            axes.plot(trace.time_s, trace.values, color=to_hex(trace.colour), ls=":" if trace.dotted else "-",
                      lw=2.2 * scale, alpha=FAINT if faint else 1.0)  # fmt: skip
        colour = to_hex(traces[0].colour) if traces else LEVEL_COLOUR
        levels = [level for level in levels_of(reel, model) if panel.y[0] < level < panel.y[1]]
        for level in levels:
            axes.axhline(level, color=colour, lw=1.5 * scale, ls=(0, (5, 3)))
        for trace in () if faint else traces_of(reel, model, "spikes"):
            for time_s, ends in zip(trace.time_s, spike_ends(panel, trace.values), strict=True):
                axes.plot([time_s, time_s], ends, color=to_hex(trace.colour), lw=2.0 * scale)
        lowest = all(other.left != panel.left or other.top <= panel.top for other in lanes.values())
        axes.tick_params(width=0.8 * scale, length=4 * scale, labelbottom=lowest, labelsize=SMALL * size)
        room = 0.95 * size * (panel.y[1] - panel.y[0]) / panel.height
        ticks = [level for level in levels if level > 0] or [float(f"{0.7 * panel.y[1]:.1g}")]
        ticks += [tick for tick in (0.0, *levels) if all(abs(tick - other) >= room for other in (*ticks, *levels)
                                                        if other != tick)]  # fmt: skip
        axes.set_yticks(sorted({*ticks}))
        axes.yaxis.set_major_formatter("{x:g}")
        words = [(f"{plain(model)}  ", FRAME_COLOUR)]
        signs = SIGNS if len(lanes) <= ONE_COLUMN else {}
        for trace in traces:
            notes = _notes(signs.get(trace.channel, ""), "dots" if trace.dotted else "")
            words.append((f"{plain(trace.name.removeprefix(f'{model} '))}{notes}  ", to_hex(trace.colour)))
        if levels and len(lanes) <= ONE_COLUMN:
            words.append(("- -  threshold: beyond it spikes", colour))
        if len(lanes) == 1:
            self._spikes(axes, reel, model, SMALL * size)
        crowded = len(lanes) > MOST_DOWN * 2
        if crowded and len(traces) == 1:
            words = [(plain(model), colour)]
        self._words(axes, words, size * (SMALLEST if crowded else 1.0), CLEAR_LANE * size)
        column = [other for other in lanes.values() if other.left == panel.left]
        if panel == column[len(column) // 2]:
            axes.set_ylabel("potential", fontsize=SMALL * size)
            axes.yaxis.set_label_coords((36.0 - LEFT) * scale / panel.width, 0.5)
        if lowest:
            axes.locator_params(axis="x", nbins=5)
            axes.set_xlabel("time before now (s)" if faint and moves_on(reel) else "time (s)", fontsize=SMALL * size,
                            labelpad=1.0)  # fmt: skip

    def _spikes(self, axes: Axes, reel: Reel, model: str, size: float) -> None:
        """Name the strokes of spikes, beside the edge of the lane that most of them stand at."""
        traces = [trace for trace in traces_of(reel, model, "spikes") if trace.values.any()]
        if traces:
            above = sum(float(trace.values.sum()) for trace in traces) >= 0
            axes.text(-7.0 * self._scale / axes.bbox.width, float(above), "spikes", color=to_hex(traces[0].colour),
                      fontsize=size, transform=axes.transAxes, ha="right", va="top" if above else "bottom")  # fmt: skip

    def _words(
        self, axes: Axes, words: Sequence[tuple[str, str]], size: float, up: float, *, room: float | None = None
    ) -> None:
        """Write words of several colours ``up`` pixels above axes, one after the other.

        One that reaches beyond the axes is cut there; where ``room`` is given, one that reaches beyond it is left out.
        """
        renderer = self._canvas.get_renderer()  # type: ignore[no-untyped-call]
        with drawing(self._style):
            across, box = 0.0, axes.get_window_extent(renderer)
            width = box.width if room is None else room
            for text, colour in words:
                word: Text = axes.text(across / box.width, 1.0 + up / box.height, text, color=colour, fontsize=size,
                                       transform=axes.transAxes, va="baseline", ha="left")  # fmt: skip
                advance = _advance(word, renderer)
                if room is not None and across + advance > room:
                    word.remove()
                    continue
                for length in range(len(text) - 1, 0, -1):
                    if across + advance <= width:
                        break
                    word.set_text(f"{text[:length].rstrip()}...")
                    advance = _advance(word, renderer)
                across += advance

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


def spike_ends(panel: Panel, values: Floats) -> Floats:
    """Return from where to where the stroke of each spike goes, (N, 2), in the unit of a lane.

    Strokes stand at the upper edge, those of negative spikes at the lower one, and are longer where several spikes
    are in one frame.
    """
    low, high = panel.y
    room = SPIKE_SHARE * (high - low)
    longest = max(float(np.abs(values).max()), 1.0)
    edge = np.where(values < 0, low, high)
    return np.column_stack(
        [edge, edge - np.sign(values) * room * (0.5 + 0.5 * np.abs(values) / longest) * (values != 0)]
    )


def eye_title(entity: str) -> str:
    """Return what is written above the pictures of an eye."""
    eye = entity.split("/")[-2].partition("_")[2]
    return f"what is seen{f', {eye}' if eye else ''}"


def _notes(*notes: str) -> str:
    """Return the notes that there are, in brackets."""
    there = ", ".join(filter(None, notes))
    return f" ({there})" if there else ""


def _advance(word: Text, renderer: object) -> float:
    """Return the width of a text in pixels, with the spaces at its end, which its extent leaves out."""
    text = word.get_text()
    spaces = len(text) - len(text.rstrip())
    return float(word.get_window_extent(renderer).width) + 0.32 * float(word.get_fontsize()) * spaces  # type: ignore[arg-type]
