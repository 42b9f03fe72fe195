"""The command ``colias view``. Heavy imports happen when it runs."""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

MOST_RUNS = 2
"""Runs that are shown side by side."""


def view(
    paths: Annotated[
        list[Path],
        typer.Argument(
            help="A run's folder, an .rrd file, a scene's name, or an arena's .xml or .py file; or two runs.",
        ),
    ],
    trial: Annotated[
        int | None, typer.Option(help="Show this trial or episode alone; of two runs otherwise the first recorded one.")
    ] = None,
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
    screenshot: Annotated[
        Path | None, typer.Option(help="Open no window: save a picture of the middle of the recording as this .png.")
    ] = None,
) -> int:
    """Open recordings in the Rerun viewer, which listens on 127.0.0.1 only; or a scene in MuJoCo's own viewer.

    Of two runs a trial of the first stands beside the trial of the second that has the same seed and condition, on one
    timeline.

    The viewer, or with --web its server, ends with this command. --screenshot needs no screen.
    """
    from experiments.bench.run import viewer
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.recordings import recording, recordings_in
    from experiments.bench.run.viewer import require_screen
    from scenes import ARENA_ENDINGS, ARENAS

    if len(paths) > MOST_RUNS:
        raise UsageError(f"view: {len(paths)} paths; legal is one, or two runs to be seen side by side")
    if screenshot is not None:
        return _screenshot(paths, trial, screenshot)
    if len(paths) == MOST_RUNS:
        return _view_both(paths[0], paths[1], trial, web)
    path = paths[0]
    if (str(path) in ARENAS and not path.exists()) or path.suffix in ARENA_ENDINGS:
        if trial is not None:
            raise UsageError(f"--trial {trial}: {path} is a scene, which has no trials")
        _view_scene(str(path))
        return 0
    files = [recording(path, trial)] if trial is not None else [path] if path.is_file() else recordings_in(path)
    if not files:
        raise UsageError(f"{path}: no such file, or no .rrd recordings in it")
    if not web:
        require_screen(f"view {path}: ", "use --web")
    return viewer.show(files, web=web, instead="use --web")


def _screenshot(paths: list[Path], trial: int | None, place: Path) -> int:
    """Save a picture of a recording, or of two side by side."""
    from experiments.bench.cli.beside import side_by_side
    from experiments.bench.run import viewer
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.recordings import recording

    if place.suffix != ".png":
        raise UsageError(f"--screenshot {place}: the file's name should end in .png")
    if len(paths) == 1:
        viewer.screenshot(recording(paths[0], trial), place)
        return 0
    with tempfile.TemporaryDirectory(prefix="colias-") as folder:
        file = Path(folder) / "both.rrd"
        file.write_bytes(side_by_side(paths[0], paths[1], trial)[1])
        viewer.screenshot(file, place)
    return 0


def _view_both(first: Path, second: Path, trial: int | None, web: bool) -> int:
    """Show a trial of a run beside the equal trial of another."""
    from experiments.bench.cli.beside import side_by_side
    from experiments.bench.report.terminal import error_console
    from experiments.bench.run import interrupts, viewer
    from experiments.bench.run.viewer import require_screen

    title, data = side_by_side(first, second, trial)
    if not web:
        require_screen(f"view {first} {second}: ", "use --web")
    error_console.print(title, soft_wrap=True, markup=False)
    with interrupts.held(), tempfile.TemporaryDirectory(prefix="colias-") as folder:
        file = Path(folder) / "both.rrd"
        file.write_bytes(data)
        return viewer.show([file], web=web, instead="use --web")


def _view_scene(arena: str) -> None:
    """Show both robots in the arena, live, in MuJoCo's viewer."""
    import mujoco.viewer
    from pydantic import ValidationError

    from colias_sim import CameraConfig, RobotConfig, SceneConfig
    from colias_sim.scene import compose
    from colias_sim.simulation import TRIAL_ROBOTS
    from experiments.bench.run.errors import UsageError, explain

    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise UsageError(f"view {arena}: MuJoCo's viewer needs a screen (DISPLAY is not set)")
    try:
        spec = compose(SceneConfig(arena=arena), RobotConfig(), CameraConfig(), TRIAL_ROBOTS, "observer")
    except ValueError as error:  # a pydantic.ValidationError too
        raise UsageError(explain(error) if isinstance(error, ValidationError) else str(error)) from None
    spec.body("stimulus/base").pos = [0.10, 0.05, 0.0]
    mujoco.viewer.launch(spec.compile())
