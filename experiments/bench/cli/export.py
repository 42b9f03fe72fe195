"""The command ``colias export``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import Quiet

LOG, VIDEOS = "log", "mp4"


def register(app: typer.Typer) -> None:
    """Put the command into ``app``."""
    app.command(short_help="Write a run as CSV, .npz or .mat, as a robot's log, as videos, or its frames as pictures.")(
        export
    )


def export(
    run: Annotated[
        Path,
        typer.Argument(
            help="A run's folder; of footage its table (.parquet, .csv), or with --frames or --to mp4 a recording."
        ),
    ],
    to: Annotated[
        str | None,
        typer.Option(
            metavar="csv|npz|mat|mp4|log",
            help="What to write; mp4: a video of each recording; log: what colias import reads.",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option(help="New folder; otherwise the run's name and the kind.")] = None,
    frames: Annotated[
        Path | None, typer.Option(help="Write the frames of its recordings into this new folder, as PNG pictures.")
    ] = None,
    trial: Annotated[
        int | None, typer.Option(help="With --to mp4 or --frames: the recording of this trial or episode alone.")
    ] = None,
    tracked: Annotated[
        bool, typer.Option("--tracked", help="In a log: poses too, as a tracker over the arena gives them.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace what is there already.")] = False,
    quiet: Quiet = False,
) -> int:
    """Write the tables of a run, of any kind, for other programs; or the whole run as a robot would have logged it.

    --to mp4 makes a video of each recording, as colias video does without options, which has more of them.

    A folder that is there already is refused, unless --force replaces it.
    """
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store.convert import KINDS

    if to is not None and to not in (*KINDS, VIDEOS, LOG):
        raise UsageError(f"--to {to}: legal is {', '.join((*KINDS, VIDEOS, LOG))}")
    if to is None and frames is None:
        raise UsageError("colias export: give --to, --frames, or both: nothing was asked for")
    if tracked and to != LOG:
        raise UsageError("--tracked: only --to log has poses to add; other tables hold what the run has")
    if trial is not None and to != VIDEOS and frames is None:
        raise UsageError(f"--trial {trial}: --to mp4 and --frames take one trial; tables and logs have all")
    if not run.exists():
        raise UsageError(f"{run}: no such run, table or recording")
    place = out or Path(f"{run.resolve().stem if run.is_file() else run.resolve().name}-{to}")
    for target in ([place] if to else []) + ([frames] if frames else []):
        target.parent.mkdir(parents=True, exist_ok=True)
        if target.exists() and not force:
            raise FileExistsError(f"{target} is there already: choose another folder, or give --force to replace it")
        if target.resolve() == run.resolve() or target.resolve() in run.resolve().parents:
            raise UsageError(f"{target}: holds what is to be exported; choose another folder")
    if to == LOG:
        _log(run, place, tracked, quiet)
    elif to == VIDEOS:
        _videos(run, place, trial, quiet)
    elif to is not None:
        _tables(run, place, to, quiet)
    if frames is not None:
        _pictures(run, frames, trial, quiet)
    return 0


def _tables(run: Path, place: Path, kind: str, quiet: bool) -> None:
    from experiments.bench.engine.terminal import show_places
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store import convert
    from experiments.bench.store.places import replacing_folder
    from experiments.bench.store.record import Record

    tables = Record.read(run).tables()
    if not tables:
        raise UsageError(f"{run}: no trial of its parts is finished")
    with replacing_folder(place) as part:
        paths = convert.write(tables, part, kind)
    if not quiet:
        show_places({path.stem: f"{place / path.relative_to(part)}" for path in paths})


def _log(run: Path, place: Path, tracked: bool, quiet: bool) -> None:
    from experiments.bench.engine.terminal import progress, show_places
    from experiments.bench.measured import export as measured_export
    from experiments.bench.store.places import replacing_folder
    from experiments.bench.store.record import Record

    record = Record.read(run)
    with replacing_folder(place) as part, progress("export", record.done, quiet) as advance:
        command = measured_export.write_log(record, part, tracked=tracked, advance=advance)
    if not quiet:
        frames = place / measured_export.FRAMES
        pictured = {"frames": frames} if frames.is_dir() else {}
        command = command.replace(str(part), str(place))
        show_places({"log": place / measured_export.LOG, **pictured, "import by": command})


def _videos(run: Path, place: Path, trial: int | None, quiet: bool) -> None:
    from experiments.bench.engine.terminal import count, progress, show_places
    from experiments.bench.report.video import make, read, require_encoder
    from experiments.bench.store.places import replacing_folder

    require_encoder("--to mp4:")
    recordings, reels = _recordings(run, trial, "--to mp4"), {}
    with progress("read", len(recordings), quiet, "recordings") as advance:
        for inside, path in recordings.items():
            reels[inside] = read(path).with_models()
            advance()
    count_frames = sum(len(reel.time_s) for reel in reels.values())
    with replacing_folder(place) as part, progress("videos", count_frames, quiet, "frames") as advance:
        for inside, reel in reels.items():
            film = part / inside.with_name(f"{inside.name}.mp4")
            film.parent.mkdir(parents=True, exist_ok=True)
            make(reel, film, advance=advance)
    if not quiet:
        show_places({"videos": f"{place}  ({count(len(reels), 'recording')})"})


def _pictures(run: Path, place: Path, trial: int | None, quiet: bool) -> None:
    from experiments.bench.engine.terminal import progress, show_places
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store.pictures import pictures, write_pictures
    from experiments.bench.store.places import replacing_folder

    recordings = _recordings(run, trial, "--frames")
    count = 0
    with replacing_folder(place) as part, progress("frames", len(recordings), quiet) as advance:
        for inside, recording in recordings.items():
            seen = pictures(recording)
            if not seen:
                raise UsageError(f"--frames: {recording} has no pictures")
            for entity, images in seen.items():
                write_pictures(part / inside / entity if len(seen) > 1 else part / inside, images, ".png")
                count += len(images)
            advance()
    if not quiet:
        show_places({"frames": f"{place}  ({count} pictures of {len(recordings)} recordings)"})


def _recordings(run: Path, trial: int | None, asked: str) -> dict[Path, Path]:
    """Map the place of a recording's output, inside the new folder, to the recording; of one trial, or of all."""
    from experiments.bench.run.errors import UsageError
    from experiments.bench.store.record import Record, recording

    recordings = [recording(run, trial)] if trial is not None else Record.read(run).all_recordings()
    if not recordings:
        raise UsageError(f"{asked}: {run} has no recordings (.rrd), which hold the frames")
    inside = [path.relative_to(run) if path != run else Path(path.name) for path in recordings]
    places = [Path(*[name for name in path.with_suffix("").parts if name != "recordings"]) for path in inside]
    return dict(zip(places, recordings, strict=True))
