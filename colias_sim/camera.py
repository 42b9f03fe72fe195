"""The robot's camera: render frames of luma offscreen, with exposure, lens, noise and quantisation."""

from __future__ import annotations

import copy
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from types import TracebackType
from typing import Any

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig, check_tunable, needs_lamps
from colias_sim.exposure import (
    LAG_SDS,
    WHOLE,
    Render,
    exposure_samples,
    light_factor,
    next_exposure,
    plan_frame,
    settle,
)
from colias_sim.offscreen import Offscreen
from colias_sim.optics import Lamps, Noise, Tone, falloff, point_spread
from colias_sim.scene import steps_per_frame
from colias_sim.sensor import Sensor, render_shape, slots_of
from colias_sim.truth import Rays

Floats = npt.NDArray[np.float32]
VIDEO_BLACK, VIDEO_WHITE = 16.0, 235.0
"""The luma of black and white in the video range of ITU-R BT.601."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame of the camera.

    Parameters
    ----------
    luma
        The picture, (R, C) uint8. It is read-only, because several models, a recording and an agent share it.
    time
        Time at which the frame ends, in seconds of simulation. This is the end of its last row's exposure, except for
        ``age_ms``.
    exposure_ms
        Exposure time of each row. A fixed exposure has the setting's value, even if the frame cuts it.
    row_time_us
        Time from the end of a row's exposure to the end of the next row's; 0 with a global shutter.
    age_ms
        Time from the end of the last row's exposure to ``time``. It is 0 except with jitter, or if a dropped frame is
        replaced by the one before.
    """

    luma: npt.NDArray[np.uint8]
    time: float
    exposure_ms: float = 0.0
    row_time_us: float = 0.0
    age_ms: float = 0.0


class Camera:
    """Renders one camera of a model as an OV7670 would see the scene, without the robot that it is part of.

    `Simulation` does all of the following. A frame is exposed by its ``renders``, and by the ``next_renders`` that are
    due before the next frame begins. Call `expose` for each render when it is due, then
    `develop`. Call `restart` to start again, and `skip` to discard a frame. A camera holds an OpenGL context: close it,
    or use it in a ``with`` statement, in the thread and process that made it.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the camera in the scene.
    config
        The camera's settings.
    truth
        Whether it remembers what its pixels truly show, in ``rays``, which otherwise is ``None``.
    offscreen
        The framebuffer of another camera, from `cameras`; ``None`` for its own.

    Raises
    ------
    KeyError
        The scene has no camera of that name.
    colias_sim.GLUnavailable
        No OpenGL backend works.
    """

    def __init__(
        self, model: mujoco.MjModel, name: str, config: CameraConfig, *, truth: bool = False,
        offscreen: Offscreen | None = None,
    ) -> None:  # fmt: skip
        self.config = self._made_with = config
        self.rays = Rays(model, name, config) if truth else None
        self._steps = steps_per_frame(config.fps)
        self._eye = mujoco.MjvCamera()
        self._eye.type, self._eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera(name).id
        self._set_optics()
        self._last: Frame | None = None
        self._exposure_ms = config.exposure_ms
        self._lamps = Lamps(model) if needs_lamps(config) else None
        if offscreen is None:
            model.vis.quality.offsamples = config.multisample  # read by MjrContext alone
            bright = self._lamps is not None
            offscreen = Offscreen(model, *render_shape(config), slots=slots_of(config), bright=bright)
        self.offscreen = offscreen
        self._sensor = Sensor(self._eye, offscreen, config)
        # Of this frame and the next: exposure time (ms), and physics steps from its last row's end to the frame's end.
        self._planned = self._next_planned = self._plan(0.0)

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Free the OpenGL context."""
        self.offscreen.close()

    def in_use(self) -> AbstractContextManager[Any]:
        """Keep the OpenGL context current in this thread, which saves time at each frame.

        Returns
        -------
        context manager
            Others may draw in the meantime, but no other thread may use this camera.
        """
        return self.offscreen.in_use()

    def copy(self, model: mujoco.MjModel, offscreen: Offscreen) -> Camera:
        """Make a twin in a copy of the scene, which shares the OpenGL context and has no exposure yet.

        Parameters
        ----------
        model
            The copy.
        offscreen
            A twin of this camera's framebuffer, for the copy.

        Returns
        -------
        Camera
            The twin.
        """
        twin = copy.copy(self)
        if self.rays is not None:
            twin.rays = Rays(model, model.camera(self._eye.fixedcamid).name, self._made_with)
        twin._lamps = None if self._lamps is None else Lamps(model)
        twin.offscreen, twin._sensor = offscreen, Sensor(self._eye, offscreen, self._made_with)
        twin._set_optics()
        return twin

    @property
    def renders(self) -> tuple[Render, ...]:
        """The renders of the current frame."""
        return self._renders_of(*self._planned)

    @property
    def next_renders(self) -> tuple[Render, ...]:
        """The renders of the next frame, of which those with steps up to 0 are in this one."""
        return self._renders_of(*self._next_planned)

    def tune(self, config: CameraConfig) -> None:
        """Use other settings from the next `restart` on, without compiling the scene again.

        Parameters
        ----------
        config
            The settings. Noise, lens, times, luma and the exposure loop may change.

        Raises
        ------
        ValueError
            The settings need another framebuffer or scene, for example another size, view, frame rate or sampling.
        """
        if config != self.config:
            check_tunable(config, self._made_with)
            self.config = config
            self._set_optics()
        if self._lamps is not None:
            self._lamps.look()

    def _set_optics(self) -> None:
        """Set up plans, lens, noise and tone from the settings."""
        config = self.config
        self._renders_of = lru_cache(partial(plan_frame, config, self._steps))
        shape = config.height, config.width
        self._falloff = falloff(*shape, config.focal_px, config.vignetting) if config.vignetting > 0.0 else None
        tone = Tone(config)
        self._tone = tone if tone.on else None
        self._noise = Noise(config)
        self._kernel = point_spread(config.blur_px) if config.blur_px > 0.0 else None

    def retexture(self, texture: int) -> None:
        """Upload a texture of the model that has changed.

        Parameters
        ----------
        texture
            Its index in the model.
        """
        self.offscreen.retexture(texture)

    def restart(self, data: mujoco.MjData) -> None:
        """Start again with a still scene: discard everything, and reset the exposure time.

        Parameters
        ----------
        data
            State of the scene. Parts of the first frame that are exposed before it show this state.
        """
        self._sensor.restart()
        if self.rays is not None:
            self.rays.restart()
        self._last = None
        self._exposure_ms = self.config.exposure_ms
        if self._lamps is not None:
            self._lamps.look()
        if self.config.auto_exposure and self.config.ae_start == "settled":
            self._exposure_ms = settle(self.config, lambda exposure_ms: self._mean(data, exposure_ms))
        self._planned = self._next_planned = self._plan(0.0)
        if self._sensor.bands:
            for render in self.renders:
                if render.step < 1:
                    self.expose(data, render)
                    if self.rays is not None:
                        self.rays.note(data, render)
            self.collect()

    def expose(self, data: mujoco.MjData, render: Render = WHOLE) -> None:
        """Render the present scene, and add it to the exposure under way.

        Parameters
        ----------
        data
            State of the scene.
        render
            The rows of the picture, and how many equal parts of their exposure the render stands for.
        """
        if self._lamps is None:
            self._sensor.expose(data, render)
            return
        exposure_ms, _ = self._next_planned if render.ahead else self._planned
        with self._lamps.scaled(light_factor(self.config, exposure_ms)):
            self._sensor.expose(data, render)

    def collect(self) -> None:
        """Read the pixels that OpenGL has drawn since the last call. Do not draw in a shared context before it."""
        self._sensor.collect()

    def skip(self) -> None:
        """Discard the current frame and continue with the next. The exposure loop pauses."""
        self._sensor.discard()
        if self.rays is not None:
            self.rays.turn()
        self._turn(self._next_planned)

    def develop(self, rng: np.random.Generator, time: float) -> Frame:
        """End the exposure: average its renders, blur, add noise, and quantise to 8 bits.

        Parameters
        ----------
        rng
            Generator of the noise, of dropped frames and of jitter.
        time
            The present time of the simulation, in seconds.

        Returns
        -------
        Frame
            The frame.
        """
        config, light = self.config, self._averaged()
        luma = np.empty(light.shape, np.uint8)
        noise = self._noise.draw(light, rng)
        if config.luma_range == "full" and self._tone is None:
            cv2.add(light, noise, dst=luma, dtype=cv2.CV_8U)  # rounds and saturates
        else:
            grey = np.clip(light + noise, 0.0, 255.0) if self._tone is None else self._tone.of(light + noise)
            black, white = (VIDEO_BLACK, VIDEO_WHITE) if config.luma_range == "video" else (0.0, 255.0)
            cv2.convertScaleAbs(grey, dst=luma, alpha=(white - black) / 255.0, beta=black)
        # An array over immutable bytes: no model can make it writable again.
        picture = np.frombuffer(luma.tobytes(), np.uint8).reshape(luma.shape)
        exposure_ms, early_steps = self._planned
        age_ms = early_steps * 1000.0 / (self._steps * config.fps)
        frame = Frame(picture, time, exposure_ms, config.row_time_us, age_ms)
        if config.auto_exposure:
            mean = float(self._metered(light).mean(dtype=np.float64))  # OpenCV's last bits depend on the array's memory
            self._exposure_ms = next_exposure(config, self._exposure_ms, mean, exposure_ms)
        self._sensor.discard()
        # Disabled parts draw no random numbers, so that the noise of the others stays the same.
        again = False
        if config.drop_probability > 0.0:
            dropped = rng.random() < config.drop_probability
            if again := dropped and self._last is not None:
                frame = replace(self._last, time=time, age_ms=self._last.age_ms + 1000.0 * (time - self._last.time))
            self._last = frame
        if self.rays is not None:
            self.rays.turn(again=again)
        self._turn(self._plan(rng.standard_normal() if config.jitter_ms > 0.0 else 0.0))
        return frame

    def _plan(self, jitter_sds: float) -> tuple[float, int]:
        """Plan a frame with the present exposure time; ``jitter_sds`` is the delay of its clock, in sd."""
        config = self.config
        early_ms = config.jitter_ms * (LAG_SDS - min(max(jitter_sds, -LAG_SDS), LAG_SDS))
        return self._exposure_ms, round(early_ms * config.fps * self._steps / 1000.0)

    def _turn(self, after_next: tuple[float, int]) -> None:
        """Continue with the next frame, parts of which may be exposed already."""
        self._planned, self._next_planned = self._next_planned, after_next
        self._sensor.turn()

    def _mean(self, data: mujoco.MjData, exposure_ms: float) -> float:
        """Compute the mean grey of the present scene at an exposure time, with all rows at this moment."""
        assert self._lamps is not None
        with self._lamps.scaled(light_factor(self.config, exposure_ms)):
            if self._falloff is None and self._tone is None:
                return self._sensor.mean(data)
            light = self._sensor.still(data)
        if self._falloff is not None:
            light *= self._falloff
        return float(self._metered(light).mean(dtype=np.float64))

    def _metered(self, light: Floats) -> Floats:
        """Return the picture that the exposure loop meters: the light behind the lens, or its luma."""
        return light if self._tone is None or self.config.ae_meter == "light" else self._tone.of(light)

    def _averaged(self) -> Floats:
        """Return the light of the current frame behind the lens."""
        light = self._sensor.average(exposure_samples(self.config, self._planned[0], self._steps))
        if self._falloff is not None:
            light *= self._falloff
        if self._kernel is None:
            return light
        blurred = cv2.sepFilter2D(light, cv2.CV_32F, self._kernel, self._kernel, borderType=cv2.BORDER_REPLICATE)
        return np.asarray(blurred, np.float32)


def cameras(model: mujoco.MjModel, eyes: Mapping[str, CameraConfig], *, truth: bool = False) -> dict[str, Camera]:
    """Make the cameras of several robots.

    Those whose framebuffers would be alike share one, and with it the textures in OpenGL's memory. Each view is drawn
    into the same corner and read before the next: at another place OpenGL rounds some pixels otherwise, so that a
    frame would depend on how many robots see.

    Parameters
    ----------
    model
        The compiled scene.
    eyes
        Name of a robot -> settings of its camera.
    truth
        As for `Camera`.

    Returns
    -------
    dict of str to Camera
        The cameras by the robot's name.
    """
    shared: dict[tuple[object, ...], Offscreen] = {}
    made = {}
    for name, config in eyes.items():
        banded = slots_of(config) > 1  # its bands of rows wait unread in the framebuffer
        alike = render_shape(config), config.multisample, needs_lamps(config), name if banded else ""
        made[name] = Camera(model, f"{name}/eye", config, truth=truth, offscreen=shared.get(alike))
        shared[alike] = made[name].offscreen
    return made
