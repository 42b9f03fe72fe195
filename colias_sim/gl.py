"""Choose MuJoCo's OpenGL backend before ``import mujoco``, and make contexts with it.

MuJoCo reads the environment variable ``MUJOCO_GL`` once, when it is imported. Without a display and without that
variable its renderer fails. So this package sets the variable before any of its modules imports mujoco.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import os
import sys
import warnings
from typing import Any

LIBRARIES = {"egl": ("libEGL.so.1", "libGL.so.1"), "osmesa": ("libOSMesa.so.8",)}
"""Backends that need no screen -> their libraries. Their packages: `PACKAGES`."""
PACKAGES = {"egl": "libegl1 libgl1", "osmesa": "libosmesa6"}
OFF = ("off", "disable", "disabled", "false", "0")
"""Values of ``MUJOCO_GL`` that switch off rendering."""
FAMILIES = (
    "MUJOCO_GL", "MUJOCO_EGL", "PYOPENGL_", "DISPLAY", "WAYLAND_DISPLAY", "MESA_", "LIBGL_", "GALLIUM_", "EGL_",
    "__EGL_", "__GLX_", "CUDA_VISIBLE_DEVICES",
)  # fmt: skip
"""Prefixes of the environment variables that OpenGL, its drivers and MuJoCo's contexts use."""
_set = ", ".join(f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith(FAMILIES))


class GLUnavailable(OSError):
    """No OpenGL backend can render. The message names the package to install, or the variables to check."""


def unavailable(reason: Exception | str) -> GLUnavailable:
    """Make an error that explains in one sentence why nothing can be drawn, and what to check."""
    backend = os.environ.get("MUJOCO_GL", "").lower() or "egl"
    missing = backend in LIBRARIES and not _loads(backend)
    cause = f"no OpenGL library for {backend} loads" if missing else str(reason).partition(". ")[0].rstrip(".")
    if _set and not missing:
        return GLUnavailable(f"OpenGL cannot draw here: {cause}; the environment sets {_set}")
    packages = PACKAGES.get(backend, PACKAGES["egl"])
    return GLUnavailable(f"OpenGL cannot draw here: {cause}; on Debian or Ubuntu run 'apt-get install {packages}'")


def choose_backend() -> None:
    """Set ``MUJOCO_GL`` on Linux unless the user has: to ``egl`` if its libraries load, otherwise to ``osmesa``.

    Raises
    ------
    GLUnavailable
        The user's choice does not load. MuJoCo cannot even be imported then.
    """
    # llvmpipe loses time by splitting so small a picture between threads: 50 us a frame at 99x72.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    # Mesa prints a line for every driver that it fails to load. If all fail there is an exception, too.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    if chosen and not (chosen in LIBRARIES and _loads(chosen)):
        try:
            import mujoco  # noqa: F401
        except Exception as error:  # of what kind depends on the backend
            raise unavailable(error) from None
    elif not chosen and sys.platform.startswith("linux") and (backend := next(filter(_loads, LIBRARIES), "")):
        os.environ["MUJOCO_GL"] = backend


def _loads(backend: str) -> bool:
    with contextlib.suppress(OSError):
        return all(ctypes.CDLL(name) for name in LIBRARIES[backend])
    return False


_described: list[str] = []


def context(columns: int, rows: int) -> Any:
    """Make an OpenGL context with the chosen backend; raise `GLUnavailable` if that fails."""
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    if chosen in OFF:
        raise unavailable("MuJoCo's rendering is switched off")
    backend = chosen if chosen in LIBRARIES else "cgl" if sys.platform == "darwin" and chosen != "glfw" else "glfw"
    try:
        # GLFW only warns of a dead display. The filters of warnings are not a thread's own, and GLFW is for one alone.
        heard: contextlib.AbstractContextManager[list[warnings.WarningMessage]] = (
            warnings.catch_warnings(record=True) if backend == "glfw" else contextlib.nullcontext([])
        )
        with heard as said:
            made = importlib.import_module(f"mujoco.{backend}").GLContext(columns, rows)
        if not made._context:
            raise unavailable(" ".join(str(warning.message) for warning in said[:1]))
        with made.as_current():
            if not _described:
                _described.append(f"{_description()}, by {backend}")
    except GLUnavailable:
        raise
    except Exception as error:  # of what kind depends on backend and driver
        raise unavailable(error) from None
    return made


def _description() -> str:
    # PyOpenGL is there as MuJoCo's own contexts come by it; its larger OpenGL.GL takes 0.3 s to import, this 0.2 ms.
    from OpenGL.raw.GL.VERSION import GL_1_0 as opengl

    name, version = (
        ctypes.string_at(opengl.glGetString(which)).decode(errors="replace")
        for which in (opengl.GL_RENDERER, opengl.GL_VERSION)
    )
    return f"{name}, OpenGL {version}"


def renderer() -> str:
    """Name the renderer of this process.

    Returns
    -------
    str
        OpenGL's name, its version and the backend, such as ``llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5
        (Compatibility Profile) Mesa 22.3.6, by egl``. It is empty before anything was drawn.
    """
    return _described[0] if _described else ""


def clip_light(clip: bool) -> None:
    """Set whether OpenGL clips the light on a surface at white before multiplying it with a texture, its default.

    OpenGL older than 3.0 always clips; then this does nothing.
    """
    from OpenGL.error import NullFunctionError
    from OpenGL.raw.GL.VERSION import GL_3_0 as opengl

    with contextlib.suppress(NullFunctionError):
        opengl.glClampColor(0x891A, clip)  # GL_CLAMP_VERTEX_COLOR


def has_screen() -> bool:
    """Whether there is a screen to open a window on."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
