"""The reference frame: one fixed picture to check whether two machines' renderers draw equal pixels.

Its scene (``scenes/reference.xml``) is drawn by the same code as the camera's frames. It contains no robot and no
camera model, so the picture stays the same between releases of colias-sim.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim.offscreen import Offscreen

SHAPE = (72, 99)
KNOWN: Mapping[str, str] = {
    "9a20af5472ea": "Mesa 22.3.6, llvmpipe with 256 bits, by EGL, Debian 12",
}
"""Hash -> the renderer that drew it."""

Luma = npt.NDArray[np.uint8]


def reference_frame() -> Luma:
    """Draw the reference frame.

    Returns
    -------
    ndarray
        RGB, (72, 99, 3) uint8, top row first.

    Raises
    ------
    colias_sim.GLUnavailable
        No OpenGL backend works.
    """
    model = mujoco.MjModel.from_xml_string(_scene())
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    eye = mujoco.MjvCamera()
    eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    surface = Offscreen(model, *SHAPE)
    try:
        return np.ascontiguousarray(surface.render(data, eye)[::-1])
    finally:
        surface.close()


def digest(frame: Luma) -> str:
    """Compute the hash of a frame's pixels: 12 hexadecimal digits of SHA-256."""
    return hashlib.sha256(np.ascontiguousarray(frame).tobytes()).hexdigest()[:12]


@cache
def reference_hash() -> str:
    """Compute the hash of the reference frame. It is drawn once per process, which takes a third of a second."""
    return digest(reference_frame())


def _scene() -> str:
    return files("scenes").joinpath("reference.xml").read_text(encoding="utf-8")
