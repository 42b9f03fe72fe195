"""Choose MuJoCo's OpenGL backend, which must happen before ``import mujoco``.

MuJoCo reads the environment variable ``MUJOCO_GL`` once, when it is imported. Without a display and without that
variable its renderer fails. So this package sets the variable before any of its modules imports mujoco.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
from collections.abc import Sequence
from functools import cache
from typing import Any

PACKAGES = "libegl1 libgl1"  # Debian's names for what EGL rendering without a screen needs
_ADVICE = f"on Debian or Ubuntu run 'apt-get install {PACKAGES}'"
_OFF = ("off", "disable", "disabled", "false", "0")
_GLFW = ("glfw", "glx", "wgl", "on", "enable", "enabled", "true", "1")  # MuJoCo's own names for a screen
_LIBRARIES = {"egl": ("libEGL.so.1", "libGL.so.1"), "osmesa": ("libOSMesa.so.8",)}


class GLUnavailable(OSError):
    """Error: nothing can render here. The message names the package to install."""


def choose_backend() -> str:
    """Choose the OpenGL backend, and set ``MUJOCO_GL`` if the user has not.

    Returns
    -------
    str
        The user's choice. Otherwise on Linux ``egl`` if it loads, else ``osmesa``, else ``glfw`` if there is a
        display, else ""; `require_backend` then raises once something is to be rendered.

    Raises
    ------
    GLUnavailable
        If the user's choice does not load. MuJoCo could not even be imported then.
    """
    # llvmpipe splits so small a picture between threads at a loss: 50 us a frame at 99x72.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    # Mesa prints a line for every driver that it fails to load. If all fail there is an exception, too.
    os.environ.setdefault("EGL_LOG_LEVEL", "fatal")
    chosen = os.environ.get("MUJOCO_GL", "").lower()
    if chosen not in {"", "cgl", *_LIBRARIES, *_GLFW, *_OFF}:
        raise GLUnavailable(f"MUJOCO_GL={chosen} is no backend: use egl, osmesa or glfw, or unset it")
    if chosen in _LIBRARIES and not _loads(chosen):
        raise GLUnavailable(f"MUJOCO_GL={chosen}, but its library does not load: {_ADVICE}")
    if chosen or not sys.platform.startswith("linux"):
        return chosen or ("cgl" if sys.platform == "darwin" else "glfw")
    for backend in _LIBRARIES:
        if _loads(backend):
            os.environ["MUJOCO_GL"] = backend
            return backend
    return "glfw" if _has_display() else ""


def require_backend() -> str:
    """Choose the OpenGL backend for something that is to be rendered.

    Returns
    -------
    str
        The backend's name among MuJoCo's modules: ``egl``, ``osmesa``, ``glfw`` or ``cgl``.

    Raises
    ------
    GLUnavailable
        If there is no backend.
    """
    chosen = choose_backend()
    module = "glfw" if chosen in _GLFW else chosen
    unseen = module == "glfw" and sys.platform.startswith("linux") and not _has_display()
    if not chosen or chosen in _OFF or unseen:
        raise GLUnavailable(f"no OpenGL library for rendering without a screen: {_ADVICE}")
    return module


_CLAMP_VERTEX_COLOR = 0x891A

_described: list[str] = []


def renderer() -> str:
    """Tell what draws in this process.

    Returns
    -------
    str
        OpenGL's own words for it, its version and the backend, such as ``llvmpipe (LLVM 15.0.6, 256 bits), OpenGL 4.5
        (Compatibility Profile) Mesa 22.3.6, by egl``; empty before anything was drawn.
    """
    return _described[0] if _described else ""


SOFTWARE = ("llvmpipe", "softpipe", "swrast", "software", "osmesa", "lavapipe")
"""Words in the names of renderers that draw on the processor."""


def is_software(name: str) -> bool:
    """Return whether a renderer, as `renderer` names it, draws in software: without a graphics processor."""
    return any(word in name.lower() for word in SOFTWARE)


def describe_context() -> None:
    """Ask the current OpenGL context for what `renderer` returns; once a process, as one backend is all it has."""
    if not _described:
        _described.append(_describe())


def _describe() -> str:
    # PyOpenGL is there as MuJoCo's own contexts come by it; its larger OpenGL.GL takes 0.3 s to import, this 0.2 ms.
    from OpenGL.raw.GL.VERSION import GL_1_0 as opengl

    try:
        name, version = (
            ctypes.string_at(opengl.glGetString(which)).decode(errors="replace")
            for which in (opengl.GL_RENDERER, opengl.GL_VERSION)
        )
    except Exception:  # a note is not worth a run, and what a broken driver makes PyOpenGL raise is not documented
        return f"unknown, by {require_backend()}"
    return f"{name}, OpenGL {version}, by {require_backend()}"


def clip_light(clip: bool) -> None:
    """Let OpenGL clip the light on a surface at white before it multiplies that with a texture, as it does by default.

    An OpenGL older than 3.0 cannot do otherwise; then this does nothing.
    """
    with contextlib.suppress(_null_function()):
        _clamp_color()(_CLAMP_VERTEX_COLOR, clip)


@cache
def _clamp_color() -> Any:
    from OpenGL.raw.GL.VERSION import GL_3_0 as opengl

    return opengl.glClampColor


@cache
def _null_function() -> type[Exception]:
    from OpenGL.error import NullFunctionError

    error: type[Exception] = NullFunctionError
    return error


def require_screen() -> None:
    """Raise `GLUnavailable` where there is no screen to open a window on."""
    if not has_screen():
        raise GLUnavailable("no screen to open a window on (DISPLAY is not set): render_mode='rgb_array' needs none")


def has_screen() -> bool:
    """Tell whether there is a screen to open a window on."""
    return not sys.platform.startswith("linux") or _has_display()


def render_modes(every: Sequence[str]) -> list[str]:
    """Return those of an env's render modes that this machine can show."""
    return [mode for mode in every if mode != "human" or has_screen()]


def _has_display() -> bool:
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def _loads(backend: str) -> bool:
    try:
        for name in _LIBRARIES[backend]:
            ctypes.CDLL(name)
    except OSError:
        return False
    return True


if __name__ == "__main__":
    try:
        require_backend()
    except GLUnavailable as problem:
        sys.exit(str(problem))
