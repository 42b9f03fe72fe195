"""The commands that show something: ``colias view``, ``video`` and ``list``.

Heavy imports happen when they run.
"""

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

import dsnn
from experiments.base import interrupts
from experiments.base.console import count, error_console, out_console, progress, show_places
from experiments.base.errors import UsageError, as_usage_error, check_known
from experiments.base.values import key_values
from experiments.cli import options
from experiments.cli.run import command_and_asked
from experiments.kinds.tables import BEHAVIOURS, NAMES, OFFLINE, STUDIES, shipped
from experiments.store.asked import Asked
from scenes import ARENA_ENDINGS, ARENAS

OTHER = "; --trial N for another"
ENDINGS = (".mp4", ".webp", ".png")
"""Of films and strips."""
MEANT = {
    "a stimulus": {"assignments", "seed", "jitter"}, "pictures": {"trial", "truth", "events"},
    "a strip": {"trial", "size", "frames", "model"}, "a film": {"trial", "size", "fps", "speed", "model"},
}  # fmt: skip
"""What ``colias video`` writes -> the options that it has."""
KINDS = ("experiments", "studies", "models", "scenes", "presets", "stimuli", "envs", "behaviours", "claims")
"""Kinds of what there is; ``colias list`` names all of them."""


def view(
    source: Annotated[Path, typer.Argument(metavar="RUN", help="A run, an .rrd file, a scene or an arena.")],
    trial: options.Trial = None,
    web: Annotated[bool, typer.Option("--web", help="Serve the viewer to a browser on this machine.")] = False,
    screenshot: Annotated[
        Path | None, typer.Option(metavar="FILE.png", help="Save a picture, without a window.")
    ] = None,
) -> int:
    """Open recordings in the Rerun viewer, which listens on 127.0.0.1 only; or a scene in MuJoCo's own viewer.

    The viewer ends with this command. --screenshot needs no screen; of a recording it shows the middle.
    """
    from experiments.draw import viewer
    from experiments.store.recordings import recording, recordings_in

    if (str(source) in ARENAS and not source.exists()) or source.suffix in ARENA_ENDINGS:
        return _view_scene(str(source), screenshot)
    one = source.is_file() or trial is not None or screenshot is not None
    first = recording(source, trial)
    files = [first] if one else [first, *(path for path in recordings_in(source) if path != first)]
    if not web and screenshot is None:
        viewer.require_screen(f"view {source}: ", "use --web, or --screenshot FILE.png")
    if source.is_dir() and trial is None:
        from experiments.draw.video import Reel  # not before: it loads matplotlib, which the viewer need not

        out_console.print(f"{first.stem}: {Reel(first).name}{OTHER}")
    with interrupts.once():
        if screenshot is None:
            return viewer.show(files, web=web)
        viewer.screenshot(first, screenshot)
    return 0


def _view_scene(arena: str, screenshot: Path | None) -> int:
    """Show both robots in the arena, live in MuJoCo's viewer, or draw them into a file."""
    import cv2
    import mujoco.viewer

    from colias_sim import CameraConfig, RobotConfig, SceneConfig
    from colias_sim.scene import compose
    from colias_sim.simulation import TRIAL_ROBOTS
    from experiments.draw import viewer

    if screenshot is None:
        viewer.require_screen(f"view {arena}: ", "use --screenshot")
    with as_usage_error():
        spec = compose(SceneConfig(arena=arena), RobotConfig(), CameraConfig(), TRIAL_ROBOTS)
    spec.body("stimulus/base").pos = [0.10, 0.05, 0.0]
    model = spec.compile()
    if screenshot is None:
        mujoco.viewer.launch(model)
        return 0
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    with mujoco.Renderer(model, 480, 640) as renderer:
        renderer.update_scene(data)
        screenshot.write_bytes(cv2.imencode(".png", renderer.render()[..., ::-1])[1].tobytes())
    return 0


def video(
    context: typer.Context,
    source: Annotated[Path, typer.Argument(metavar="RUN_OR_RRD", help="A run, an .rrd file, or a stimulus.")],
    out: Annotated[Path, typer.Option(metavar="FILE", help=".mp4, .webp, .png: a strip; or a folder of pictures.")],
    trial: options.Trial = None,
    size: options.Size = None,
    fps: Annotated[float | None, typer.Option(min=0.1, max=120.0, help="Frames a second; otherwise all.")] = None,
    speed: Annotated[
        float, typer.Option(min=0.01, max=100.0, help="Seconds of the recording in a second of the video.")
    ] = 1.0,
    frames: Annotated[int, typer.Option(min=1, max=12, help="Moments of a strip.")] = 6,
    truth: Annotated[
        bool, typer.Option("--truth", help="With a folder: a data set of what pixels truly show.")
    ] = False,
    events: Annotated[bool, typer.Option("--events", help="With a folder: the events of an event camera.")] = False,
    model: options.Models = None,
    assignments: options.Assignments = None,
    seed: options.Seed = 0,
    jitter: options.Jitter = 0.0,
    quiet: options.Quiet = False,
) -> int:
    """Show a recording in one picture: what is seen, what changed, robots from above, potentials, spikes.

    MP4 is H.264, which browsers and slides play, of 1280x720 px. WebP is a picture that moves, for pages. A strip has
    some moments side by side above the traces, for papers. Videos need the extra colias-sim[video]. Each model has a
    lane. A folder gets the pictures as the camera saw them; of a stimulus (--set, --seed, --jitter) also truth.csv.
    With --truth a trial of RUN is played once more, and its flow, depth, surfaces, poses and responses are written too.
    With --events an event camera sees it once more: events.npz, and events.h5 where h5py is installed.
    """
    from dsnn.stimuli import STIMULI
    from experiments.draw.video import Reel, film_times, make, strip
    from experiments.store.recordings import recording

    _check_place(out)
    stimulus = (str(source) in STIMULI and not source.exists()) or source.suffix == ".py"
    kind = "a stimulus" if stimulus else {"": "pictures", ".png": "a strip"}.get(out.suffix, "a film")
    if other := sorted(options.typed(context) - MEANT[kind] - {"source", "out", "quiet"}):
        names = ", ".join(f"--{name}" for name in other).replace("--assignments", "--set")
        raise UsageError(f"{names}: not an option of {kind}")
    if stimulus:
        _write_stimulus(str(source), out, key_values(assignments), seed, jitter)
        return 0
    if (truth or events) and not out.suffix:
        _write_data_set(source, trial, out, truth=truth, events=events)
        return 0
    path, shape = recording(source, trial), options.width_height(size)
    if not out.suffix:
        _write_frames(path, out)
    elif out.suffix == ".png":
        strip(Reel(path, model or ()), out, frames, shape)
    else:
        reel = Reel(path, model or ())
        with progress(out.name, len(film_times(reel, fps, speed)[0]), quiet, "frames") as advance:
            make(reel, out, shape, fps, speed, advance)
    if not quiet:
        show_places({kind.split()[-1]: out, "of": path.stem + OTHER * (trial is None and source.is_dir())})
    return 0


def _check_place(out: Path) -> None:
    if out.suffix and out.suffix not in ENDINGS:
        raise UsageError(f"--out {out}: the name should end in {', '.join(ENDINGS)}")
    if out.exists() or not out.parent.is_dir():
        raise UsageError(f"--out {out}: {'is there already' if out.exists() else 'its folder is not there'}")


def _write_frames(path: Path, out: Path) -> None:
    """Write the frames of a recording, a folder for each camera."""
    from experiments.store.recordings import pictures, write_pictures

    seen = pictures(path)
    if not seen:
        raise UsageError(f"--out {out}: {path} has no pictures")
    for camera, images in seen.items():
        write_pictures(out / camera, images, ".png")


def _write_data_set(run: Path, trial: int | None, out: Path, *, truth: bool, events: bool) -> None:
    """Write a trial of a run with its truth and its events, planned where the run's own command was given."""
    from experiments.kinds import data_set
    from experiments.kinds.result import load

    place = out.absolute()
    command, asked = command_and_asked(run, load(run).description)
    with contextlib.chdir(command["folder"]):
        for write in [data_set.write] * truth + [data_set.write_events] * events:
            write(Asked.read(asked), trial, place)


def _write_stimulus(name: str, out: Path, values: Mapping[str, str], seed: int, jitter: float) -> None:
    """Write a stimulus as pictures, and the truth about each of them as a table."""
    import numpy as np

    from experiments.base.files import Files
    from experiments.declare.clip import find_stimulus
    from experiments.kinds.footage import clip_of
    from experiments.show.clips import truth_of
    from experiments.store.recordings import write_pictures

    if out.suffix:
        raise UsageError(f"--out {out}: a stimulus is written into a folder; colias watch {name} records a video's run")
    clip = clip_of(find_stimulus(name), values, jitter).build(seed)
    write_pictures(out, np.stack([frame.luma for frame in clip]), ".png")
    rows = [
        {"frame": index, "time_s": index / clip.fps, **truth_of(frame.truth, index, clip.fps)}
        for index, frame in enumerate(clip)
    ]
    Files(out).write_rows("truth.csv", rows)


def list_names(
    kind: Annotated[
        str | None, typer.Argument(help=f"{', '.join(KINDS)}, parameters or runs; otherwise all but the last two.")
    ] = None,
    of: Annotated[
        str | None, typer.Argument(help="Of parameters the experiment, a stimulus or firmware; the folder of runs.")
    ] = None,
    model: options.Models = None,
    only: options.Only = False,
) -> int:
    """Name what there is.

    parameters: every key of --set, with its default, bounds, unit and meaning. runs: when each was begun, its
    experiment, seed, models, parameters that are not at their defaults, how many trials are finished, and verdicts.
    """
    if kind == "runs":
        return _list_runs(Path(of or "runs"))
    if kind == "parameters":
        return _list_parameters(of or "speed", model, only)
    if kind is not None:
        check_known("kind", kind, KINDS)
    for heading in KINDS if kind is None else (kind,):
        out_console.print(heading, style="b")
        for name, summary in _names(heading).items():
            out_console.print(f"  {name:<20} {summary}")
    return 0


def _names(kind: str) -> Mapping[str, str]:
    """Return what there is of a kind: its name, and what it is."""
    from experiments.kinds import registry

    match kind:
        case "experiments":
            return {name: registry.find(name).summary for name in (*NAMES, *OFFLINE)}
        case "studies":
            whole = {"model-claims": "the claims of the looming models' own papers, on clips"}
            return {name: registry.shipped_study(name).summary for name in STUDIES} | whole
        case "scenes":
            return ARENAS
        case "presets":
            from colias_sim.config import CameraConfig, RobotConfig

            cameras = {f"camera.preset={name}": text for name, text in CameraConfig.preset_summaries().items()}
            return cameras | {f"robot.preset={name}": text for name, text in RobotConfig.preset_summaries().items()}
        case "claims":
            from experiments.declare.claim import claim_ids, texts

            implied = {name: " (the equations imply it)" if "implied" in texts()[name] else "" for name in claim_ids()}
            return {name: texts()[name]["title"] + note for name, note in implied.items()}
        case "behaviours":
            known, groups = shipped(BEHAVIOURS["behaviours"]), shipped(BEHAVIOURS["groups"])
            notes = {name: f"a group: {', '.join(members)}" for name, members in groups.items()}
            return {name: entry.summary for name, entry in known.items()} | notes
        case "envs":
            from colias_sim.envs import ENVS

            return {name.partition("/")[2]: env.summary for name, env in ENVS.items()}
    from dsnn.stimuli import STIMULI

    entries = dsnn.MODELS if kind == "models" else STIMULI
    return {name: entry.summary for name, entry in entries.items()}


def _list_parameters(name: str, models: list[str] | None, only: bool) -> int:
    """Print the parameters of an experiment with the robot, of a stimulus, or of the chip's program."""
    from rich.text import Text

    from dsnn.stimuli import STIMULI
    from experiments.base.user_code import declares, is_file
    from experiments.declare.clip import find_stimulus
    from experiments.kinds import registry
    from experiments.settings.models import shown_models
    from experiments.settings.settings import described, sections

    if name in STIMULI or (is_file(name) and declares(Path(name), "STIMULUS")):
        entry = find_stimulus(name)
        values: dict[str, Any] = {entry.name: entry.params}
    elif name == "firmware":
        from experiments.robot import firmware

        values = firmware.sections()
    else:
        declared = registry.load(name)
        values = sections(declared, shown_models(declared.models, models, only))
    for row in described(values):
        notes = "; ".join(filter(None, (row["legal"], row["unit"] and f"in {row['unit']}")))
        legal = f"  ({notes})" if notes else ""
        out_console.print(Text.assemble(f"{row['key']}=", (row["value"], "b"), (legal, "dim")))
        out_console.print(f"    {row['description']}")
    return 0


def _list_runs(folder: Path) -> int:
    """Print the runs in a folder; those of another version in a line each, with the version that reads it."""
    import polars as pl
    from rich.text import Text

    from experiments.kinds.result import runs

    table = runs(folder)
    for row in table.filter(pl.col("trouble").is_null()).to_dicts():
        out_console.print(Text.assemble((row["run"], "b"), f"  {row['when']:%Y-%m-%d %H:%M}"))
        done = f"{row['done']} of {count(row['planned'], 'trial')}, {count(row['failures'], 'failure')}"
        first = f"{row['experiment']} ({row['models']}), seed {row['seed']}, {done}, {row['provenance']}"
        out_console.print("    " + "\n    ".join(filter(None, (first, row["changed"], row["verdicts"]))))
    for line in table["trouble"].drop_nulls() if table.height else [f"no runs in {folder}"]:
        error_console.print(line)
    return 0
