"""One Rerun recording per episode of a behaviour."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr
import rerun.blueprint as rrb

from dsnn import ResponseSeries
from experiments.bench.closed_loop.episode import Episode, Floats
from experiments.bench.figures.palette import HUES
from experiments.bench.figures.series import LIMIT_COLOUR, rgb
from experiments.bench.recording import (
    OBSERVER_COLOUR,
    OTHER_COLOUR,
    ROBOT_RADIUS_CM,
    jpegs,
    lanes,
    page,
    plot,
    potentials,
    recorded,
    timelines,
)
from scenes import ARENA_RADIUS_CM

JPEG_QUALITY = 85
TRACK_COLOURS = (rgb(HUES[2]), rgb(HUES[1]))
"""Colours of the observer's track and of headings."""
LEFT, RIGHT = rgb(HUES[1]), rgb(HUES[6])
"""Colours of the wheels."""


def record(episode: Episode, title: str = "") -> bytes:
    """Return the bytes of the .rrd file: the observer's view, the arena from above with tracks, the neurons,
    the wheels and the rewards.

    Frames are JPEG. An episode with a ``title`` cannot be played again by its behaviour's name and its seed, so that it
    is like no other. Raises ``ValueError`` on an episode without a step.
    """
    if episode.steps == 0:
        raise ValueError("an episode without a step cannot be recorded")
    name = f"{episode.name} in {_short(episode)}, seed {episode.seed}"
    identity = f"{episode.name}-{_short(episode)}-{episode.seed}"
    return recorded(partial(_write, episode), _blueprint(episode), title or name, None if title else identity)


def _short(episode: Episode) -> str:
    """Return the env's name without its namespace."""
    return episode.env.partition("/")[2]


@dataclass(frozen=True, slots=True)
class _Neurons:
    """Answers of the env's vision model."""

    model: str
    channels: tuple[str, ...]
    series: ResponseSeries
    thresholds: Mapping[str, float | None]


def _neurons(episode: Episode, series: ResponseSeries) -> _Neurons:
    return _Neurons(episode.model, episode.channels, series, episode.thresholds)


def _write(episode: Episode, recording: rr.RecordingStream) -> None:
    outcome: dict[str, Any] = {
        "behaviour": episode.name, "env": episode.env,
        "reset seed": "none" if episode.seed is None else str(episode.seed),  # which may be any whole number
        "ended by": {True: "touched something", False: "time", None: "left"}[episode.touched],
        "return": float(episode.rewards.sum()),
    }  # fmt: skip
    recording.send_property("episode", rr.AnyValues(**outcome))
    times = timelines(episode.time_s, np.arange(episode.steps))
    if len(episode.frames):
        jpegs(recording, "camera", episode.frames, times, JPEG_QUALITY)
    if episode.series is not None:
        potentials(recording, [_neurons(episode, episode.series)], episode.time_s)
    _arena(recording, episode, times)
    wheels = {"left": episode.wheels[:, 0], "right": episode.wheels[:, 1]}
    rewards = {name: values for name, values in episode.infos.items() if name.startswith("reward_")}
    rooms: dict[str, dict[str, npt.NDArray[Any]]] = {"wheels": wheels, "reward": rewards}
    for room, rooms_shown in rooms.items():
        tints = (LEFT, RIGHT) if room == "wheels" else tuple(map(rgb, HUES))
        for place, (name, values) in enumerate(rooms_shown.items()):
            style = rr.SeriesLines(
                colors=tints[place % len(tints)], names=name.removeprefix("reward_"), widths=1.5 + place // len(tints)
            )
            recording.log(f"{room}/{name}", style, static=True)
            recording.send_columns(f"{room}/{name}", times, rr.Scalars.columns(scalars=values.astype(float)))


def _arena(recording: rr.RecordingStream, episode: Episode, times: list[rr.TimeColumn]) -> None:
    """Draw the arena from above: x to the right, y up, centimetres; robots as discs with their heading, tracks of who
    moves.
    """
    turn = np.linspace(0, 2 * np.pi, 65)
    wall = ARENA_RADIUS_CM * np.column_stack([np.cos(turn), np.sin(turn)])
    recording.log("arena/wall", rr.LineStrips2D([_shown(wall)], colors=[LIMIT_COLOUR], radii=[0.3]), static=True)
    if outlines := [_shown(obstacle.closed_cm) for obstacle in episode.obstacles]:
        strips = rr.LineStrips2D(outlines, colors=[LIMIT_COLOUR], radii=[0.15])
        recording.log("arena/obstacles", strips, static=True)
    for place, (name, path) in enumerate(episode.paths.items()):
        colour = OBSERVER_COLOUR if place == 0 else OTHER_COLOUR
        recording.log(f"arena/{name}/body", rr.Points2D.from_fields(colors=[colour], radii=[ROBOT_RADIUS_CM]),
                      static=True)  # fmt: skip
        here = _shown(path[:, :2])
        recording.send_columns(f"arena/{name}/body", times, rr.Points2D.columns(positions=here))
        if np.ptp(path, axis=0).max() < 0.01:
            continue
        track = TRACK_COLOURS[0] if place == 0 else LIMIT_COLOUR
        recording.log(f"arena/{name}/track", rr.LineStrips2D([here], colors=[track], radii=[0.15]), static=True)
        heading = np.radians(path[:, 2])
        ahead = _shown(5.0 * np.column_stack([np.cos(heading), np.sin(heading)]))
        recording.log(f"arena/{name}/heading", rr.Arrows2D.from_fields(colors=[TRACK_COLOURS[1]], radii=[0.3]),
                      static=True)  # fmt: skip
        recording.send_columns(f"arena/{name}/heading", times, rr.Arrows2D.columns(origins=here, vectors=ahead))


def _shown(points: Floats) -> Floats:
    """Points (T, 2) as a 2-D view has them: its y axis points down."""
    return np.column_stack([points[:, 0], -points[:, 1]])


def _blueprint(episode: Episode) -> rrb.Blueprint:
    above = rrb.Spatial2DView(
        origin="arena", name="arena from above (cm)", background=(214, 214, 210),
        visual_bounds=rrb.VisualBounds2D(x_range=(-48, 48), y_range=(-48, 48)),
    )  # fmt: skip
    driven = rrb.Horizontal(
        *(plot(f"wheels/{side}", f"{side} wheel, share of 35 cm/s", 1.05) for side in ("left", "right")),
        plot("reward", "terms of the reward", legend=True),
    )
    if episode.series is None:
        return page(above, driven, shares=[3, 1])
    camera = rrb.Spatial2DView(origin="camera", name="what the robot sees")
    top = rrb.Horizontal(camera, above) if len(episode.frames) else above
    return page(top, rrb.Vertical(lanes([_neurons(episode, episode.series)]), driven), shares=[3, 2])
