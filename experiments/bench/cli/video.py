"""The command ``colias video``. It imports what is heavy when it runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from experiments.bench.cli.options import Jitter, Quiet, Seed

ENDINGS = (".mp4", ".gif", ".webp", ".png")


def video(
    source: Annotated[Path, typer.Argument(metavar="RUN_OR_RRD", help="A run's folder, an .rrd file, or a stimulus.")],
    out: Annotated[
        Path,
        typer.Option(
            metavar="FILE",
            help="The file to make: .mp4, .gif, .webp, or .png for a strip. A name without ending is a folder of PNG"
            " pictures, as the camera saw them; an .avi of a stimulus is lossless, with a .csv of its truth beside it.",
        ),
    ],
    trial: Annotated[
        int | None, typer.Option(help="Number of the trial or episode; otherwise the first that was recorded.")
    ] = None,
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="In pixels; otherwise 1280x720, a GIF 640x360, a strip as its panels need."),
    ] = None,
    fps: Annotated[
        float | None, typer.Option(help="Frames a second; otherwise all that were recorded, in a GIF 12.5 at most.")
    ] = None,
    speed: Annotated[float, typer.Option(help="Seconds of the recording in a second of the video.")] = 1.0,
    frames: Annotated[int | None, typer.Option(help="How many moments a strip has, 1 to 12; otherwise 6.")] = None,
    model: Annotated[
        list[str] | None,
        typer.Option(metavar="MODEL", help="Show this model's answers, of several; otherwise the first 8. Repeatable."),
    ] = None,
    caption: Annotated[str | None, typer.Option(help="Text at the top; otherwise what the recording is of.")] = None,
    assignments: Annotated[
        list[str] | None, typer.Option("--set", metavar="NAME.PARAM=VALUE", help="Of a stimulus: set a parameter.")
    ] = None,
    seed: Seed = 0,
    jitter: Jitter = 0.0,
    quiet: Quiet = False,
) -> int:
    r"""Show a recording in one picture: what is seen, what changed, robots from above, potentials, spikes.

    It takes recordings of trials, clips and episodes, from a run's folder, of watched films too. MP4 is
    H.264, which browsers and slides play; WebP is a picture that moves, for pages. A strip has some moments side by
    side above the traces, for papers. All but strips need the extra colias-sim[video]. Each model has a lane.
    """
    if out.suffix == ".avi":
        from experiments.bench.cli.watch import write_stimulus

        return write_stimulus(str(source), out, assignments or (), seed, jitter)
    _check_out(out)
    width_height = _size(size)
    if frames is not None and out.suffix != ".png":
        from experiments.bench.run.errors import UsageError

        raise UsageError(f"--frames {frames}: a strip has frames side by side; give --out NAME.png")
    from experiments.bench.report.video import film_times, make, read, require_encoder, strip
    from experiments.bench.run.recordings import recording

    if out.suffix not in ("", ".png"):
        require_encoder(f"--out {out}: {out.suffix}")
    path = recording(source, trial)
    if not out.suffix:
        return _frames(path, out, quiet)
    from experiments.bench.report.terminal import error_console, progress, show_places

    reel = read(path).with_models(model or ())
    if out.suffix == ".png":
        strip(reel, out, 6 if frames is None else frames, width_height, caption)
    else:
        count = len(film_times(reel, fps, speed, out.suffix)[0]) if speed > 0 and (fps or 1) > 0 else 0
        with progress(out.name, count, quiet, "frames") as advance:
            make(reel, out, width_height, caption, fps, speed, advance)
    if not quiet:
        if reel.hidden:
            error_console.print(f"note: {reel.not_shown()}: --model chooses", markup=False, soft_wrap=True)
        show_places({"video" if out.suffix != ".png" else "strip": out})
    return 0


def _frames(recording: Path, out: Path, quiet: bool) -> int:
    """Write what each camera saw as pictures into a folder."""
    from experiments.bench.report.terminal import show_places
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.recordings import pictures, write_pictures

    seen = pictures(recording)
    if not seen:
        raise UsageError(f"--out {out}: {recording} has no pictures")
    for camera, images in seen.items():
        write_pictures(out / camera, images, ".png")
    if not quiet:
        show_places({"frames": out})
    return 0


def _size(text: str | None) -> tuple[int, int] | None:
    from experiments.bench.run.errors import UsageError

    if text is None:
        return None
    parts = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if parts is None:
        raise UsageError(f"--size {text}: legal is WIDTHxHEIGHT in pixels, for example 1280x720")
    return int(parts[1]), int(parts[2])


def _check_out(out: Path) -> None:
    """Refuse a file that cannot be written before anything is read for it; nothing is overwritten."""
    from experiments.bench.run.errors import UsageError

    if out.suffix and out.suffix not in ENDINGS:
        raise UsageError(f"--out {out}: the name should end in {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}")
    if out.exists():
        raise UsageError(f"--out {out}: is there already; choose another name, or remove it")
    if not out.parent.is_dir():
        raise UsageError(f"--out {out}: no such folder: {out.parent}")
