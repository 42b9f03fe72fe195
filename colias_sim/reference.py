"""The reference frame: one fixed picture that tells whether two machines' renderers draw equal pixels.

A scene of its own (``scenes/reference.xml``) is drawn by the same code as the camera's frames. It knows no robot and no
camera model, so a release of colias-sim leaves the picture as it is.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from colias_sim import gl
from colias_sim.offscreen import Offscreen

SHAPE = (72, 99)
KNOWN: Mapping[str, str] = {
    "9a20af5472ea": "Mesa 22.3.6, llvmpipe with 256 bits, by EGL, Debian 12",
}
"""Hash -> where it was seen."""

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
        Where nothing can render.
    """
    model = mujoco.MjModel.from_xml_string(_scene())
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    eye = mujoco.MjvCamera()
    eye.type, eye.fixedcamid = mujoco.mjtCamera.mjCAMERA_FIXED, 0
    surface = Offscreen(model, *SHAPE)
    try:
        return np.ascontiguousarray(surface.render(data, eye, mujoco.MjvOption())[::-1])
    finally:
        surface.close()


def digest(frame: Luma) -> str:
    """Return the hash of a frame's pixels: 12 hexadecimal digits of SHA-256."""
    return hashlib.sha256(np.ascontiguousarray(frame).tobytes()).hexdigest()[:12]


def expected_frame() -> Luma:
    """Return the frame that belongs to the first of the `KNOWN` hashes, from ``colias_sim/reference.png``.

    The file was written by `reference_frame` itself, on Debian 12's Mesa without a graphics processor.
    """
    coded = np.frombuffer(files("colias_sim").joinpath("reference.png").read_bytes(), np.uint8)
    return np.asarray(cv2.imdecode(coded, cv2.IMREAD_COLOR_RGB), np.uint8)


@cache
def reference_hash() -> str:
    """Return the hash of the reference frame as this process draws it.

    Drawing it takes a tenth of a second and more, so it is drawn once for each renderer, as `gl.renderer` names it, and
    version of MuJoCo. The hash is then kept in the user's cache (``$XDG_CACHE_HOME/colias-sim``).

    Returns
    -------
    str
        12 hexadecimal digits; empty before this process has drawn anything.
    """
    renderer = gl.renderer()
    if not renderer:
        return ""
    key = hashlib.sha256(f"{renderer}\n{mujoco.__version__}\n{_scene()}".encode()).hexdigest()[:16]
    kept = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "colias-sim" / f"reference-{key}"
    with contextlib.suppress(OSError, UnicodeDecodeError):
        known = kept.read_text(encoding="ascii")
        if len(known) == 12:
            return known
    drawn = digest(reference_frame())
    with contextlib.suppress(OSError):
        kept.parent.mkdir(parents=True, exist_ok=True)
        partial = kept.with_name(f"{kept.name}.{os.getpid()}.part")
        try:
            partial.write_text(drawn, encoding="ascii")
            partial.replace(kept)
        finally:
            partial.unlink(missing_ok=True)
    return drawn


def _scene() -> str:
    return files("scenes").joinpath("reference.xml").read_text(encoding="utf-8")
