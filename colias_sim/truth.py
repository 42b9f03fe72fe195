"""What each pixel of a robot's eye truly shows: which surface, how far away, and how far it has moved in the picture.

A ray is cast through the centre of each pixel, without OpenGL. So truth is the same on every machine.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection
from dataclasses import dataclass, field

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.exposure import Render
from colias_sim.scene import groups_of, hidden, steps_per_frame

Floats = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]

MOST_SINCE = 6
"""Most frames that `Simulation.truth` looks back."""
DRAWN = np.array([1, 1, 1, 0, 0, 0], np.uint8)
"""Which of MuJoCo's groups of geoms are drawn, and hit by rays."""
HIT = ("geom_xpos", "geom_xmat", "xipos", "ximat")
"""What of the state rays depend on: places and turns of geoms, and of the boxes around bodies."""
TREMBLE = 1e-7
"""Metres, and radians, of a frame below which a body rests: 3 um/s. A robot that settles trembles by a fiftieth."""
SURFACE_M, SURFACE_SHARE = 2e-4, 1e-3
"""How far a point may be behind and before the surface at the pixels around it, in metres and as a share of its
distance; otherwise a ray of its own says whether it was visible."""
ASIDE_PX = 1e-5
"""How far rays are off the pixels' centres, right and down: one along a seam of two surfaces would meet neither."""
ROUNDING = 1e-6
"""Share of its distance by which a ray may end before the point that it aims at."""

COLUMNS = (
    "true_flow_x", "true_flow_y", "true_view_x", "true_view_y", "true_share", "true_width_deg",
    "true_image_speed_deg_s", "true_time_to_contact_s", "true_heading_deg", "true_interval_ms",
)  # fmt: skip
"""The numbers that `Truth.columns` computes."""


@dataclass(frozen=True, slots=True)
class Truth:
    """What each pixel (R, C) of a frame truly shows. A ray through its centre decides.

    The moment of a pixel is that of the render nearest the middle of the exposure of its band of rows, in both frames.
    Blur, noise and falloff are no part of truth. A frame that was dropped is the frame before it.

    Parameters
    ----------
    flow
        (R, C, 2) float32: how far the surface point at the pixel has moved in the picture since the frame before, px,
        right and down positive. NaN where the point was outside or hidden, or there was no frame before.
    depth_m, depth_before_m
        (R, C) float32: distance of that point along the optical axis, now and in the frame before, in metres. NaN where
        there is no surface, and before also where ``flow`` is NaN.
    geom, robot
        (R, C) int32: index into ``geoms`` and ``robots``, -1 where there is no surface, or none of a robot.
    interval_ms
        (B,): time since the frame before of each band of rows, in ms; NaN without a frame before.
    translation_m
        (3,): how far the lens has moved since the frame before, to the right, down and ahead, in metres. A mean over
        the bands.
    focal_px
        Focal length, px. The axis is at the picture's middle.
    geoms, robots
        Names of all geoms and robots of the scene.
    """

    flow: npt.NDArray[np.float32]
    depth_m: npt.NDArray[np.float32]
    depth_before_m: npt.NDArray[np.float32]
    geom: npt.NDArray[np.int32]
    robot: npt.NDArray[np.int32]
    interval_ms: Floats
    translation_m: Floats
    focal_px: float
    geoms: tuple[str, ...]
    robots: tuple[str, ...]

    def mask(self, things: Collection[str]) -> npt.NDArray[np.bool_]:
        """Find the pixels that show some robots or geoms.

        Parameters
        ----------
        things
            Names of robots and of geoms.

        Returns
        -------
        ndarray of bool
            (R, C).
        """
        robots, geoms = (np.array([*(name in things for name in names), False]) for names in (self.robots, self.geoms))
        return np.asarray(robots[self.robot] | geoms[self.geom])  # -1 finds the last

    def errors(self, flow: npt.NDArray[np.floating], least_px: float = 0.5) -> tuple[float, float]:
        """Compare an estimate of the flow with the true one, over the pixels that truly move.

        Parameters
        ----------
        flow
            (R, C, 2): the estimate, px since the frame before, right and down positive.
        least_px
            The least motion of a pixel that counts.

        Returns
        -------
        end_point : float
            Mean distance of the estimated from the true motion, px; NaN where nothing moves.
        angular : float
            Mean angle between (right, down, 1 px) of both, degrees (Barron, Fleet and Beauchemin 1994, IJCV 12).
        """
        moving = np.hypot(self.flow[..., 0], self.flow[..., 1]) >= least_px
        if not moving.any():
            return math.nan, math.nan
        true, other = (np.insert(np.asarray(one[moving], np.float64), 2, 1.0, axis=1) for one in (self.flow, flow))
        off, turn = np.linalg.norm(true - other, axis=1), np.linalg.norm(np.cross(true, other), axis=1)
        return float(off.mean()), float(np.degrees(np.arctan2(turn, (true * other).sum(axis=1))).mean())

    def columns(self, things: Collection[str]) -> dict[str, float]:
        """Summarise the frame: the stimulus in the picture, and the observer's way.

        Parameters
        ----------
        things
            Names of the robots, or of the geoms, that are the stimulus.

        Returns
        -------
        dict of str to float
            The `COLUMNS`; docs/reference/files.md has their equations. NaN where there is none.
        """
        (height, width), focal = self.depth_m.shape, self.focal_px
        mask = self.mask(things)
        found = dict.fromkeys(COLUMNS, math.nan) | {"true_interval_ms": float(self.interval_ms.mean())}
        right, _, ahead = self.translation_m.tolist()
        if math.hypot(right, ahead) > TREMBLE:
            found["true_heading_deg"] = math.degrees(math.atan2(right, ahead))
        known = np.isfinite(self.flow[..., 0])
        if known.any():
            found["true_view_x"], found["true_view_y"] = self.flow[known].mean(axis=0, dtype=np.float64).tolist()
        if not mask.any():
            return found
        seen = np.flatnonzero(mask.any(axis=0))
        ends = (float(seen[0]) - width / 2) / focal, (float(seen[-1]) + 1 - width / 2) / focal
        found["true_share"] = float(mask.mean())
        found["true_width_deg"] = math.degrees(math.atan(ends[1]) - math.atan(ends[0]))
        rows, places = np.nonzero(mask & known)
        if not rows.size:
            return found
        flow = self.flow[rows, places].astype(np.float64)
        found["true_flow_x"], found["true_flow_y"] = flow.mean(axis=0).tolist()
        seconds = found["true_interval_ms"] / 1000
        now = (np.stack([places, rows], axis=1) - np.array([width - 1, height - 1]) / 2) / focal
        before = now - flow / focal
        one, other = (np.append(part.mean(axis=0), 1.0) for part in (now, before))
        turn = math.atan2(float(np.linalg.norm(np.cross(one, other))), float(one @ other))
        away = np.hypot(1.0, np.hypot(*now.T)) * self.depth_m[rows, places]
        nearest = int(away.argmin())
        was = math.hypot(1.0, *before[nearest]) * float(self.depth_before_m[rows[nearest], places[nearest]])
        closing = was - float(away[nearest])
        if seconds > 0.0:
            found["true_image_speed_deg_s"] = math.degrees(turn) / seconds
            if closing > ROUNDING * was:
                found["true_time_to_contact_s"] = float(away[nearest]) * seconds / closing
        return found


@dataclass(frozen=True, slots=True)
class Moment:
    """Where everything was: physics steps since the reset, places and turns of bodies and eye, and what rays need."""

    step: int
    bodies: Floats
    body_turns: Floats
    eye: Floats
    eye_turn: Floats
    hit: tuple[Floats, ...]

    def from_eye(self, body: int) -> tuple[Floats, Floats]:
        """Return the turn (3, 3) and the place (3,) of a body in the eye's frame."""
        back = self.eye_turn.T
        return back @ self.body_turns[body], back @ (self.bodies[body] - self.eye)


@dataclass
class Picture:
    """One frame: its bands of rows as (first, after the last, moment), and what its rays met, once they are cast."""

    bands: list[tuple[int, int, Moment]]
    met: tuple[npt.NDArray[np.int32], Floats] | None = field(default=None, init=False)


class Rays:
    """Casts the rays of a robot's eye, and remembers where everything was in its last frames.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the eye's camera in the scene.
    config
        The camera's settings.
    """

    def __init__(self, model: mujoco.MjModel, name: str, config: CameraConfig) -> None:
        self._model, self._data = model, mujoco.MjData(model)
        self._eye, self._own = model.camera(name).id, groups_of(model, name.removesuffix("/eye"))
        self._steps, self._focal = steps_per_frame(config.fps), config.focal_px
        self._step_ms = 1000.0 / (config.fps * self._steps)
        self.shape = rows, columns = config.height, config.width
        # Arrays have an axis of coordinates first, and one of all pixels: a pixel's place is its column and row.
        self._places: Floats = np.indices(self.shape).reshape(2, -1)[::-1].astype(np.float64) + ASIDE_PX
        self._middle = np.array([[columns - 1], [rows - 1]]) / 2
        across, down = (self._places - self._middle) / self._focal
        directions = np.stack([across, -down, -np.ones_like(down)])  # MuJoCo's cameras look along -z, y is up
        self._axial = 1.0 / np.linalg.norm(directions, axis=0)
        self._directions: Floats = directions * self._axial
        bodies = [model.body(index).name.partition("/") for index in range(model.nbody)]
        self._robots = tuple(owner for owner, _, part in bodies if part == "base")
        owners = [self._robots.index(owner) if part else -1 for owner, _, part in bodies]
        geoms = [model.geom(index) for index in range(model.ngeom)]
        self._geoms = tuple(geom.name or model.body(geom.bodyid[0]).name for geom in geoms)  # wheels have none
        # The last entry is what index -1 finds: no surface.
        self._robot_of = np.append(np.array(owners, np.int32)[model.geom_bodyid], np.int32(-1))
        self._body_of = np.append(model.geom_bodyid, -1)
        self.restart()

    def restart(self) -> None:
        """Forget everything."""
        self._begun = 0
        self._notes: tuple[_Notes, _Notes] = {}, {}
        self._pictures: deque[Picture] = deque(maxlen=MOST_SINCE + 1)

    def note(self, data: mujoco.MjData, render: Render) -> None:
        """Note where everything is at a render, after ``mj_kinematics`` and ``mj_camlight``.

        Parameters
        ----------
        data
            State of the scene.
        render
            The render.
        """
        moment = Moment(
            self._begun + render.step, data.xpos.copy(), data.xmat.reshape(-1, 3, 3).copy(),
            data.cam_xpos[self._eye].copy(), data.cam_xmat[self._eye].reshape(3, 3).copy(),
            tuple(getattr(data, name).copy() for name in HIT),
        )  # fmt: skip
        band = render.top, render.bottom or self.shape[0]
        self._notes[render.ahead].setdefault(band, []).append((render.parts, moment))

    def turn(self, *, again: bool = False) -> None:
        """End a frame.

        Parameters
        ----------
        again
            Whether the frame before it is delivered again.
        """
        now, ahead = self._notes
        self._notes = ahead, {}
        self._begun += self._steps
        bands = [(top, bottom, _middle(notes)) for (top, bottom), notes in sorted(now.items())]
        self._pictures.append(self._pictures[-1] if again else Picture(bands))

    def truth(self, since: int = 1) -> Truth:
        """Compute the truth of the last frame.

        Parameters
        ----------
        since
            Number of frames back to the frame that is "before".

        Returns
        -------
        Truth
            The truth.

        Raises
        ------
        ValueError
            ``since`` is out of range.
        """
        if not 1 <= since <= MOST_SINCE:
            raise ValueError(f"since must be between 1 and {MOST_SINCE}, got {since}")
        now, before = self._pictures[-1], self._pictures[-1 - since] if len(self._pictures) > since else None
        geom, distance = self._met(now)
        flow, depth_before = np.full((2, len(geom)), np.nan), np.full(len(geom), np.nan)
        interval, translation = np.full(len(now.bands), np.nan), np.full(3, np.nan)
        if before is not None:
            pairs = [(one, other) for (_, _, one), (_, _, other) in zip(now.bands, before.bands, strict=True)]
            interval = np.array([one.step - other.step for one, other in pairs]) * self._step_ms
            translation = np.mean([one.eye_turn.T @ (one.eye - other.eye) for one, other in pairs], axis=0)
            translation = np.where(np.abs(translation) > TREMBLE, translation * np.array([1, -1, -1]), 0.0)
            flow, depth_before = self._moved(geom, distance, now, before)
        return Truth(
            flow.T.reshape(*self.shape, 2).astype(np.float32),
            (distance * self._axial).reshape(self.shape).astype(np.float32),
            depth_before.reshape(self.shape).astype(np.float32),
            geom.reshape(self.shape), self._robot_of[geom].reshape(self.shape), interval, translation, self._focal,
            self._geoms, self._robots,
        )  # fmt: skip

    def _met(self, picture: Picture) -> tuple[npt.NDArray[np.int32], Floats]:
        """Return the geom that each pixel's ray meets, -1 for none, and the distance along the ray, (R C,)."""
        if picture.met is None:
            met = [
                self._cast(moment, self._directions[:, top * self.shape[1] : bottom * self.shape[1]])
                for top, bottom, moment in picture.bands
            ]
            picture.met = np.concatenate([geom for geom, _ in met]), np.concatenate([distance for _, distance in met])
        return picture.met

    def _cast(self, moment: Moment, directions: Floats) -> tuple[npt.NDArray[np.int32], Floats]:
        """Cast rays (3, N), of the eye's frame and of length 1: the geom that each meets, and its distance or NaN."""
        for name, values in zip(HIT, moment.hit, strict=True):
            getattr(self._data, name)[:] = values
        number = directions.shape[1]
        geom, distance = np.empty(number, np.int32), np.empty(number)
        rays = (moment.eye_turn @ directions).T.ravel()
        with hidden(self._own):
            mujoco.mj_multiRay(
                self._model, self._data, moment.eye, rays, DRAWN, True, -1, geom, distance, None, number,
                mujoco.mjMAXVAL,
            )  # fmt: skip
        distance[geom < 0] = np.nan
        return geom, distance

    def _moved(
        self, geom: npt.NDArray[np.int32], distance: Floats, now: Picture, before: Picture
    ) -> tuple[Floats, Floats]:
        """Compute flow (2, R C) and the depth before (R C,); NaN where the point was outside or hidden."""
        columns = self.shape[1]
        at = self._directions * distance
        points, old = at.copy(), self._places.copy()  # where they are, of bodies that rest
        bands = np.repeat(np.arange(len(now.bands)), [(bottom - top) * columns for top, bottom, _ in now.bands])
        band = bands.copy()  # of each point in the frame before: at first that of its pixel now
        pixels = np.flatnonzero(geom >= 0)
        self._carry(pixels, self._body_of[geom[pixels]], at, (now, bands), (before, band), points, old)
        for _ in before.bands[1:]:
            row = np.clip(np.rint(old[1, pixels]), 0, self.shape[0] - 1).astype(np.intp)
            there = bands[row * columns]
            changed = there != band[pixels]
            pixels = pixels[changed]
            band[pixels] = there[changed]  # a point that moves between bands is found there at another moment
            if not pixels.size:
                break
            points[:, pixels], old[:, pixels] = at[:, pixels], self._places[:, pixels]
            self._carry(pixels, self._body_of[geom[pixels]], at, (now, bands), (before, band), points, old)
        inside = (points[2] < 0.0) & (np.abs(old - self._middle) < self._middle + 0.5).all(axis=0)
        visible = self._visible(np.flatnonzero(inside), geom, points, old, before, band)
        return np.where(visible, self._places - old, np.nan), np.where(visible, -points[2], np.nan)

    def _carry(
        self, pixels: Indices, bodies: npt.NDArray[np.int32], at: Floats, now: tuple[Picture, Indices],
        before: tuple[Picture, Indices], points: Floats, old: Floats,
    ) -> None:  # fmt: skip
        """Find where the points ``at`` pixels were: ``points`` in the eye's frame then, and their ``old`` places."""
        key = (now[1][pixels] * len(before[0].bands) + before[1][pixels]) * self._model.nbody + bodies
        for value in np.flatnonzero(np.bincount(key)).tolist():
            pair, body = divmod(value, self._model.nbody)
            one, other = divmod(pair, len(before[0].bands))
            turn, place = now[0].bands[one][2].from_eye(body)
            turn_then, place_then = before[0].bands[other][2].from_eye(body)
            if np.abs(turn - turn_then).max() < TREMBLE and np.abs(place - place_then).max() < TREMBLE:
                continue
            mine, carried = pixels[key == value], turn_then @ turn.T
            points[:, mine] = then = carried @ at[:, mine] + (place_then - carried @ place)[:, np.newaxis]
            ahead = np.maximum(-then[2], 1e-9)  # a point behind the eye is outside
            old[:, mine] = self._middle + self._focal * then[:2] * np.array([[1.0], [-1.0]]) / ahead

    def _visible(
        self, pixels: Indices, geom: npt.NDArray[np.int32], points: Floats, old: Floats, before: Picture, band: Indices
    ) -> npt.NDArray[np.bool_]:
        """Return whether each point (R C,) is one of ``pixels`` that was not hidden in the frame before.

        Where the four rays around a point met its geom, and at its distance, it was visible. The others get a ray each.
        """
        rows, columns = self.shape
        met, reach = self._met(before)
        then, mine = points[:, pixels], geom[pixels]
        away = np.sqrt(np.einsum("ij,ij->j", then, then))
        across, down = old[:, pixels].astype(np.intp)  # no place is below -0.5
        corner = np.minimum(down, rows - 2) * columns + np.minimum(across, columns - 2)
        near, far, sure = np.full_like(away, np.inf), np.full_like(away, -np.inf), np.ones(len(pixels), np.bool_)
        for beside in (0, 1, columns, columns + 1):
            sure &= met[corner + beside] == mine
            distance = reach[corner + beside]
            near, far = np.minimum(near, distance), np.maximum(far, distance)
        slack = SURFACE_M + SURFACE_SHARE * away
        sure &= (near - slack < away) & (away < far + slack)
        found = np.zeros(len(geom), np.bool_)
        found[pixels[sure]] = True
        for index, (_, _, moment) in enumerate(before.bands):
            doubtful = np.flatnonzero(~sure & (band[pixels] == index))
            if doubtful.size:
                _, distance = self._cast(moment, then[:, doubtful] / away[doubtful])
                found[pixels[doubtful]] = ~(distance < (1.0 - ROUNDING) * away[doubtful])
        return found


_Notes = dict[tuple[int, int], list[tuple[int, Moment]]]
"""Rows of a band -> the parts of its exposure that each render stands for, and the moment of the render."""


def _middle(notes: list[tuple[int, Moment]]) -> Moment:
    """Return the moment of the render nearest the middle of an exposure."""
    middle = sum(parts * moment.step for parts, moment in notes) / sum(parts for parts, _ in notes)
    return min((moment for _, moment in notes), key=lambda moment: abs(moment.step - middle))
