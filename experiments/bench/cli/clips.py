"""The commands that show stimuli to a model, or write them to a file, without a robot."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import Models, Only
from experiments.bench.run import interrupts

if TYPE_CHECKING:
    from dsnn.stimuli import StimulusEntry
    from experiments.bench.sources.clips import ClipSource

INSTEAD = "use --record FILE.rrd --no-view"
"""What to do where there is no screen."""

Name = Annotated[str, typer.Argument(help="A stimulus that colias list shows, or a .py file.")]
Assignments = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME.PARAM=VALUE", help="Set a parameter of the stimulus. Repeatable."),
]
Seed = Annotated[int, typer.Option(help="Seed of all that is random in it, 0 or more.")]
Jitter = Annotated[float, typer.Option(metavar="PX", help="A trembling camera: standard deviation of its shifts, px.")]


def stimulus(
    name: Name,
    out: Annotated[Path | None, typer.Option(help="The clip, an .avi file; otherwise NAME.avi.")] = None,
    assignments: Assignments = None,
    seed: Seed = 0,
    jitter: Jitter = 0.0,
    parameters: Annotated[bool, typer.Option("--parameters", help="List what --set reaches, and do no more.")] = False,
) -> None:
    """Write a stimulus to a lossless clip (FFV1), and the truth about each frame to a .csv file beside it.

    What is there already is never overwritten.
    """
    from experiments.bench.cli.listing import show_parameters
    from experiments.bench.report.terminal import out_console
    from experiments.bench.run import settings
    from experiments.bench.sources import clip_file as export
    from experiments.bench.sources.clips import find_stimulus as find

    entry = find(name)
    section = {entry.name: entry.params}
    if parameters:
        return show_parameters(settings.described(section))
    clip = _clip(entry, settings.collect(assignments or (), section, _listed_by(name)), seed, jitter)
    video = out or Path(f"{entry.name}.avi")
    with _progress(entry.name, len(clip)) as advance:
        table = export.write(clip.stimulus, video, advance)
    rows, columns = clip.shape
    about = f"{len(clip)} frames of {columns}x{rows} px at {clip.fps:g} per second"
    out_console.print(f"clip        {video}  ({about})", soft_wrap=True, markup=False)
    out_console.print(f"truth       {table}", soft_wrap=True, markup=False)


def play(
    name: Name,
    model: Models = None,
    only: Only = False,
    assignments: Annotated[
        list[str] | None,
        typer.Option(
            "--set", metavar="KEY=VALUE", help="A parameter of the stimulus or of a model (dsnn.n_con=6). Repeatable."
        ),
    ] = None,
    seed: Seed = 0,
    jitter: Jitter = 0.0,
    record: Annotated[Path | None, typer.Option(help="Keep the recording as this .rrd file.")] = None,
    view: Annotated[bool, typer.Option("--view/--no-view", help="Open Rerun's viewer.")] = True,
) -> int:
    """Show a stimulus to a model, and open frames, object, potentials, thresholds and spikes in Rerun.

    The command's own model is dsnn. A DSNN has the paper's off-line threshold (0.16) and spike gain (2) unless --set
    says otherwise.
    """
    from experiments.bench.report.terminal import error_console, out_console
    from experiments.bench.run import settings
    from experiments.bench.run.models import rate_notes, shown_models
    from experiments.bench.run.play import Showing
    from experiments.bench.sources import clip_file as export
    from experiments.bench.sources.clips import find_stimulus as find
    from experiments.bench.sources.clips import record as recorded

    _check_outputs(record, view)
    if record is not None:
        export.refuse(record)
    entry = find(name)
    listed_by = f"{_listed_by(name)}, colias list parameters"
    models, collected = settings.watchers(
        shown_models(["dsnn"], model, only), assignments or (), {entry.name: entry.params}, listed_by
    )
    source = _clip(entry, collected, seed, jitter)
    showing = Showing(source, models)
    with _progress(entry.name, len(source)) as advance:
        for _ in showing:
            advance()
    for answered, series in showing.series():
        ranges = {channel: getattr(series, channel) for channel in answered.channels}
        parts = [f"{channel.upper()} {v.min():+z.2f} .. {v.max():+z.2f}" for channel, v in ranges.items()]
        levels = dict.fromkeys(level for level in answered.thresholds.values() if level is not None)
        parts += [f"T {' and '.join(f'{level:g}' for level in levels)}"] if levels else []
        out_console.print(f"{answered.label:<18}{'   '.join(parts)}", soft_wrap=True, markup=False)
    notes = [f"note: {note}" for note in rate_notes((model, source.fps) for model in models)]
    for line in (*notes, *(f"{label} failed: {trouble}" for label, trouble in showing.troubles().items())):
        error_console.print(line, soft_wrap=True, markup=False)
    status = _show(entry.name, recorded(showing, source.clip.name, exact=True), record, view)
    return status or int(bool(showing.troubles()))


def _check_outputs(record: Path | None, view: bool) -> None:
    from experiments.bench.run.errors import UsageError
    from experiments.bench.run.viewer import require_screen

    if not view and record is None:
        raise UsageError("--no-view: give a file to --record too, or nothing comes of it")
    if record is not None and record.suffix != ".rrd":
        raise UsageError(f"--record {record}: the file's name should end in .rrd")
    if view:
        require_screen("play: ", INSTEAD)


def _show(name: str, recording: bytes, record: Path | None, view: bool) -> int:
    """Write the recording, to a file that goes with the viewer if none was asked for; the exit status."""
    from experiments.bench.report.terminal import out_console
    from experiments.bench.run import viewer
    from experiments.bench.run.files import replacing

    with interrupts.held(), tempfile.TemporaryDirectory(prefix="colias-") as folder:
        place = record or Path(folder) / f"{name}.rrd"
        place.parent.mkdir(parents=True, exist_ok=True)
        with replacing(place) as partial:
            partial.write_bytes(recording)
        if record is not None:
            out_console.print(f"recording   {record}", soft_wrap=True, markup=False)
        return viewer.show([place], instead=INSTEAD) if view else 0


def _listed_by(name: str) -> str:
    return f"colias stimulus {name} --parameters"


def _clip(
    entry: StimulusEntry, collected: Mapping[str, Mapping[str, str]], seed: int, jitter: float
) -> ClipSource:  # fmt: skip
    """Return the stimulus that was asked for; `UsageError` in one line on what is not legal."""
    from experiments.bench.run import settings
    from experiments.bench.run.errors import UsageError
    from experiments.bench.sources.clips import Clip

    params = settings.changed(entry.name, entry.params, collected.get(entry.name, {}))
    try:
        return Clip(entry.name, replace(entry, params=params), (), jitter).open(seed)
    except ValueError as error:
        raise UsageError(f"{entry.name}: {error}") from error


@contextmanager
def _progress(name: str, total: int) -> Iterator[Callable[[], None]]:
    """Show the progress of frames. Ctrl-C waits for the end of a frame, so that half-written files are removed."""
    from experiments.bench.report.terminal import progress

    with interrupts.held(), progress(name, total, quiet=False, things="frames") as advance:

        def next_frame() -> None:
            interrupts.check()
            advance()

        yield next_frame
