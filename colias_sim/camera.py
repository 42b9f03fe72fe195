"""The robot's camera: frames of luma, rendered offscreen, with exposure, noise and quantisation."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.config import CameraConfig
from colias_sim.offscreen import Offscreen
from colias_sim.scene import OWN_BODY_GROUP

Floats = npt.NDArray[np.float32]
WARM_UP_ROWS = 2
_STANDARD_NORMAL = np.zeros(1), np.ones(1)


@dataclass(frozen=True, slots=True)
class Frame:
    """One frame of the camera.

    Parameters
    ----------
    luma
        The picture, (R, C) uint8. It is read-only, as several models, a recording and an agent share it.
    time
        End of its exposure, in seconds of simulation.
    """

    luma: npt.NDArray[np.uint8]
    time: float


class Camera:
    """Renders one camera of a model as an OV7670 would see the scene.

    Call `expose` at each of the moments that `exposure_steps` lists, then `develop`. A camera holds an OpenGL context:
    close it, or use it in a ``with`` statement, in the thread and process that made it.

    Parameters
    ----------
    model
        The compiled scene.
    name
        Name of the camera in the scene.
    config
        The camera's settings.

    Raises
    ------
    colias_sim.GLUnavailable
        Where nothing can render.
    """

    def __init__(self, model: mujoco.MjModel, name: str, config: CameraConfig) -> None:
        self.config = config
        self._eye = mujoco.MjvCamera()
        self._eye.type, self._eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED.value, model.camera(name).id
        rows, columns = config.height * config.supersample, config.width * config.supersample
        self._option = mujoco.MjvOption()
        self._option.geomgroup[OWN_BODY_GROUP] = 0
        self._grey = np.empty((rows, columns), np.uint8)
        self._light = np.zeros((config.height, config.width), np.float32)
        self._noise, self._spread = np.empty_like(self._light), np.empty_like(self._light)
        self._no_noise = np.zeros_like(self._light)
        self._read_variance = np.full_like(self._light, config.read_noise**2)
        self._noise_tape = np.empty((config.height + WARM_UP_ROWS, config.width), np.float32)
        self._exposures = 0
        self._offscreen = Offscreen(model, rows, columns)

    def __enter__(self) -> Camera:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Free the OpenGL context."""
        self._offscreen.close()

    def expose(self, data: mujoco.MjData, parts: int = 1) -> None:
        """Render the present scene, and add it to the exposure under way.

        Parameters
        ----------
        data
            State of the scene.
        parts
            How many equal parts of the exposure this render stands for.
        """
        rgb = self._offscreen.render(data, self._eye, self._option)
        cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY, dst=self._grey)  # BT.601: the Y of YUV
        cv2.flip(self._grey, 0, dst=self._grey)  # OpenGL's first row is the lowest
        if self.config.supersample > 1:
            small = cv2.resize(self._grey.astype(np.float32), self._light.shape[::-1], interpolation=cv2.INTER_AREA)
            self._light += parts * small
        else:
            for _ in range(parts):
                cv2.accumulate(self._grey, self._light)
        self._exposures += parts

    def develop(self, rng: np.random.Generator, time: float) -> Frame:
        """End the exposure: average its renders, add noise, and quantise to 8 bits.

        Parameters
        ----------
        rng
            Generator of the noise.
        time
            The present time of the simulation, in seconds.

        Returns
        -------
        Frame
            The frame.
        """
        light = self._light
        if self._exposures > 1:
            light *= 1.0 / self._exposures
        luma = np.empty(light.shape, np.uint8)
        noisy = self.config.shot_noise > 0.0 or self.config.read_noise > 0.0
        noise = self._draw_noise(light, rng) if noisy else self._no_noise
        cv2.add(light, noise, dst=luma, dtype=cv2.CV_8U)  # rounds and saturates
        self.discard()
        # An array over immutable bytes: no model can make it writable again.
        return Frame(np.frombuffer(luma.tobytes(), np.uint8).reshape(luma.shape), time)

    def discard(self) -> None:
        """Discard the exposure under way."""
        self._light[:] = 0.0
        self._exposures = 0

    def _draw_noise(self, light: Floats, rng: np.random.Generator) -> Floats:
        """Draw photon and read noise of one frame, both Gaussian, as photon noise is above some tens of electrons."""
        config, spread, noise = self.config, self._spread, self._noise
        # OpenCV's generator, seeded for each frame from the trial's, is five times faster than NumPy's. Its first
        # numbers after seeding correlate with the seed: they are drawn into rows above the picture and not used.
        cv2.setRNGSeed(int(rng.bit_generator.random_raw()) & 0x7FFFFFFF)  # of 32 or 64 bits
        cv2.randn(self._noise_tape, *_STANDARD_NORMAL)
        cv2.scaleAdd(light, config.shot_noise**2 / 255.0, self._read_variance, spread)
        np.sqrt(spread, out=spread)
        return np.multiply(self._noise_tape[WARM_UP_ROWS:], spread, out=noise)


def exposure_steps(config: CameraConfig, steps_per_frame: int) -> tuple[int, ...]:
    """Compute after which physics steps of a frame the camera renders: the middles of the exposure's equal parts.

    The exposure ends with the frame; one that is longer than the frame is cut to it. Moments are rounded to whole
    steps, by half a step at most. Parts with the same step share its render.

    Parameters
    ----------
    config
        The camera's settings.
    steps_per_frame
        Number of physics steps in a frame.

    Returns
    -------
    tuple of int
        A step, from 1 to ``steps_per_frame``, for each part, in order.
    """
    length = min(config.exposure_ms * config.fps / 1000.0, 1.0) * steps_per_frame
    parts = (np.arange(config.exposure_samples) + 0.5) / config.exposure_samples
    moments = np.rint(steps_per_frame - length * (1.0 - parts)).astype(int)
    return tuple(int(m) for m in np.clip(moments, 1, steps_per_frame))
