"""The command ``colias watch``. It imports what is heavy when it runs."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import Models, Only

if TYPE_CHECKING:
    from experiments.bench.footage.video import Footage


def watch(
    source: Annotated[str, typer.Argument(metavar="FILE_OR_CAMERA", help="A video file, or a camera's index from 0.")],
    model: Models = None,
    only: Only = False,
    size: Annotated[
        str | None,
        typer.Option(metavar="WxH", help="What the network sees, exactly; otherwise 320 px along the longer side."),
    ] = None,
    fps: Annotated[
        str | None,
        typer.Option(metavar="real|NUMBER", help="The network's rate; otherwise 30, whatever the footage's own."),
    ] = None,
    record: Annotated[Path | None, typer.Option(metavar="OUT.rrd", help="Write a Rerun recording.")] = None,
    table: Annotated[
        Path | None, typer.Option(metavar="OUT.csv|.parquet", help="Write a row per frame and model.")
    ] = None,
    view: Annotated[bool, typer.Option(help="Stream to a Rerun viewer on this machine.")] = True,
    judge: Annotated[bool, typer.Option("--judge", help="Judge claim C12 against dense flow; takes longer.")] = False,
    assignments: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="Set a model's parameter. Repeatable.")
    ] = None,
) -> int:
    """Step the network through footage, a step a frame, and tell when what moved which way.

    The command's own model is dsnn.
    A file is taken as fast as it decodes. Thresholds are the paper's off-line ones, which
    belong to 30 steps a second: responses grow with the square of the rate, so --fps changes
    what passes them. Exit status: 1 if the footage ended early, 130 if interrupted; what was
    seen until then is summarised, and complete in the files.
    """
    asked = _size(size)
    rate = _number(fps)
    for option, path, endings in (("--record", record, (".rrd",)), ("--table", table, (".csv", ".parquet"))):
        _check_new(option, path, endings)
    from experiments.bench.footage import video

    film = video.Footage(source)
    # Not before: they load libraries that a film's refusal does without.
    from experiments.bench.footage import run as footage_run
    from experiments.bench.run import settings
    from experiments.bench.run.models import shown_models

    own_rate = _own_rate(film) if fps == "real" else rate
    chosen, _ = settings.watchers(shown_models(["dsnn"], model, only), assignments or (), fps=own_rate)
    wanted = footage_run.Wanted(record, table, view, judge)
    return footage_run.run(film, asked or video.usual_size(film.size), chosen, wanted)


def _size(text: str | None) -> tuple[int, int] | None:
    from experiments.bench.footage.video import SIZES_PX
    from experiments.bench.run.errors import UsageError

    if text is None:
        return None
    parts = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if parts is None or not all(int(part) in SIZES_PX for part in parts.groups()):
        bounds = f"from {SIZES_PX[0]} to {SIZES_PX[-1]} px"
        raise UsageError(f"--size {text}: legal is WIDTHxHEIGHT, each {bounds}, for example 320x180")
    return int(parts[1]), int(parts[2])


def _number(text: str | None) -> float | None:
    from experiments.bench.run.errors import UsageError

    if text is None or text == "real":
        return None
    try:
        return float(text)  # its range is the parameter's own
    except ValueError:
        raise UsageError(f"--fps {text}: legal is 'real', or a number of frames per second") from None


def _own_rate(film: Footage) -> float:
    from experiments.bench.run.errors import UsageError

    if film.rate is None:
        raise UsageError(f"--fps real: {film.source} tells no rate; give a number")
    return film.rate


def _check_new(option: str, path: Path | None, endings: tuple[str, ...]) -> None:
    """Refuse a file that cannot be written before anything is decoded for it; nothing is overwritten."""
    from experiments.bench.run.errors import UsageError

    if path is None:
        return
    if path.suffix not in endings:
        raise UsageError(f"{option} {path}: the name should end in {' or '.join(endings)}")
    if path.exists():
        raise UsageError(f"{option} {path}: is there already; choose another name, or remove it")
    if not path.parent.is_dir():
        raise UsageError(f"{option} {path}: no such folder")
