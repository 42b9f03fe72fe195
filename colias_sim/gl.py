"""Choose MuJoCo's OpenGL backend, which must happen before ``import mujoco``.

MuJoCo reads the environment variable ``MUJOCO_GL`` once, when it is imported, and without a display
and without that variable its renderer fails. So this package chooses before any of its modules imports it.
"""

from __future__ import annotations

import ctypes
import os
import sys

PACKAGES = "libegl1 libgl1"  # Debian's names for what EGL rendering without a screen needs
_ADVICE = f"on Debian or Ubuntu run 'apt-get install {PACKAGES}'"
_OFF = ("off", "disable", "disabled", "false", "0")
_GLFW = ("glfw", "glx", "wgl", "on", "enable", "enabled", "true", "1")  # MuJoCo's own names for a screen
_LIBRARIES = {"egl": ("libEGL.so.1", "libGL.so.1"), "osmesa": ("libOSMesa.so.8",)}


class GLUnavailable(OSError):
    """No way to render: names the package to install."""


def choose_backend() -> str:
    """Set ``MUJOCO_GL`` if the user has not, and return it: on Linux egl, else osmesa, else glfw if there is a display.

    Returns "" when there is none, for `require_backend` to complain of once something is to be rendered. Raises
    `GLUnavailable` when the user's own choice does not load: MuJoCo could not even be imported.
    """
    # llvmpipe splits so small a picture between threads at a loss: 50 us a frame at 99x72.
    os.environ.setdefault("LP_NUM_THREADS", "0")
    # Mesa tells of every driver that it tries in vain; where none is left an exception says so.
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
    """The backend's name in MuJoCo's modules: egl, osmesa, glfw or cgl. Raises `GLUnavailable` if there is none."""
    chosen = choose_backend()
    module = "glfw" if chosen in _GLFW else chosen
    unseen = module == "glfw" and sys.platform.startswith("linux") and not _has_display()
    if not chosen or chosen in _OFF or unseen:
        raise GLUnavailable(f"no OpenGL library for rendering without a screen: {_ADVICE}")
    return module


def require_screen() -> None:
    """Raise `GLUnavailable` where there is no screen to open a window on."""
    if not has_screen():
        raise GLUnavailable("no screen to open a window on (DISPLAY is not set): render_mode='rgb_array' needs none")


def has_screen() -> bool:
    """Whether a window could be opened."""
    return not sys.platform.startswith("linux") or _has_display()


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
