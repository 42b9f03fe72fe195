"""The command ``colias view``. Heavy imports happen when it runs."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Open recordings in Rerun, or a scene in MuJoCo's viewer.")(view)


def view(
    path: Annotated[
        Path, typer.Argument(help="A run's folder, one .rrd file, a scene's name, or an arena's .xml or .py file.")
    ],
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
) -> int:
    """Open recordings in the Rerun viewer, which listens on 127.0.0.1 only; or a scene in MuJoCo's own viewer.

    The viewer, or with --web its server, ends with this command.
    """
    from experiments.bench.cli import viewer
    from experiments.bench.engine.errors import UsageError
    from experiments.bench.store.record import recordings_in
    from scenes import ARENA_ENDINGS, ARENAS

    if (str(path) in ARENAS and not path.exists()) or path.suffix in ARENA_ENDINGS:
        _view_scene(str(path))
        return 0
    files = [path] if path.is_file() else recordings_in(path)
    if not files:
        raise UsageError(f"{path}: no such file, or no .rrd recordings in it")
    if not web:
        viewer.require_screen(f"view {path}: ", "use --web")
    return viewer.show(files, web=web, instead="use --web")


def _view_scene(arena: str) -> None:
    """Show both robots in the arena, live, in MuJoCo's viewer."""
    import mujoco.viewer
    from pydantic import ValidationError

    from colias_sim import CameraConfig, RobotConfig, SceneConfig
    from colias_sim.scene import compose
    from colias_sim.simulation import TRIAL_ROBOTS
    from experiments.bench.engine.errors import UsageError, explain

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(f"view {arena}: MuJoCo's viewer needs a screen (DISPLAY is not set)")
    try:
        spec = compose(SceneConfig(arena=arena), RobotConfig(), CameraConfig(), TRIAL_ROBOTS, "observer")
    except ValueError as error:  # a pydantic.ValidationError too
        raise UsageError(explain(error) if isinstance(error, ValidationError) else str(error)) from None
    spec.body("stimulus/base").pos = [0.10, 0.05, 0.0]
    mujoco.viewer.launch(spec.compile())
