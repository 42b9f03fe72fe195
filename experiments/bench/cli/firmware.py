"""The commands ``colias firmware ...``. Heavy imports happen when they run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from experiments.bench.cli.options import (
    EXIT_FAILED,
    Quiet,
    Repeats,
    Seed,
    Workers,
    resources,
    results_folder,
    run_folder,
)

if TYPE_CHECKING:
    from collections.abc import Iterable

    from experiments.bench.firmware.budget import Tools
    from experiments.bench.firmware.settings import Firmware

Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="A parameter of dsnn-onboard (dsnn.n_con=4 is short for dsnn-onboard.n_con=4) or of the chip"
        " (chip.shape=99x72); see colias firmware parameters. Repeatable.",
    ),
]
Which = Annotated[
    str | None,
    typer.Option(
        "--compiler", metavar="gcc|zig", help="gcc-arm-none-eabi or the ziglang wheel; otherwise what is there."
    ),
]
DEFAULT_GRID = (
    "dsnn-onboard.n_con=4,6,8", "dsnn-onboard.d=1,2", "dsnn-onboard.state_bits=8,16", "dsnn-onboard.lamina_bits=16,8",
)  # fmt: skip
"""What ``budget`` measures where it is given no parameters."""

app = typer.Typer(
    help="What the robot's chip would compute: its memory and time, the program checked in QEMU, the source to flash.",
    no_args_is_help=True,
)


@app.command(short_help="RAM, flash and instructions on the chip, measured.")
def budget(
    assignments: Sets = None,
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="KEY=V1,V2", help="Measure every combination of these values. Repeatable."),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="New folder for the results; otherwise runs/firmware-budget-TIME.")
    ] = None,
    which: Which = None,
    workers: Workers = None,
    quiet: Quiet = False,
) -> int:
    """Build the chip's program, link it into the chip's memory, and count its instructions in QEMU.

    RAM and flash are sections of the linked program, the stack a painted high-water mark. Instructions are counted in
    clips with noise, flicker and motion; "fits" means the frame of the most. Without --set and --over it measures the
    paper's range: N_con 4, 6 and 8, d 1 and 2, delay states and LA of 8 and 16 bits. Writes budget.csv, budget.svg
    and budget.png.
    """
    from experiments.bench.firmware import settings, table
    from experiments.bench.firmware.budget import measure_all
    from experiments.bench.firmware.export import check_folder
    from experiments.bench.report.terminal import error_console, progress, show_places

    means = resources(workers, None, quiet, False)
    grid = DEFAULT_GRID if over is None and not assignments else over or ()
    points = settings.points(grid, assignments or ())
    folder = results_folder(out, "firmware-budget")
    check_folder(folder)
    if not quiet:
        _notes(wanted for _, wanted in points)
    tools = _tools(which)
    if not quiet:
        programs = f"{len(points)} program{'s' * (len(points) > 1)}"
        message = f"firmware budget: {programs} to build and to run in QEMU, into {folder}"
        error_console.print(message, soft_wrap=True, markup=False)
    with progress("budget", len(points), quiet, "programs") as advance:
        budgets = measure_all(points, tools, means.workers, advance)
    from experiments.bench.firmware import figure
    from experiments.bench.report.style import save

    folder.mkdir(parents=True, exist_ok=True)
    table.write(budgets, folder / "budget.csv")
    drawn = save(figure.draw(budgets), folder / "budget")
    if not quiet:
        table.show(budgets)
        show_places({"table": folder / "budget.csv", "figure": drawn})
    return 0


@app.command(short_help="Hold the chip's program in QEMU against the host's form, bit for bit.")
def check(
    assignments: Sets = None,
    trial: Annotated[bool, typer.Option(help="Show the frames of a trial rendered by MuJoCo too.")] = True,
    which: Which = None,
    quiet: Quiet = False,
) -> int:
    """Run the chip's program in QEMU on at least 1,000 frames, and compare every HS, VS and spike with the host's.

    The frames: a still scene, noise, 0/255 flicker, a moving grating, a crossing, the golden clips where there is a
    checkout, the camera's frames of a trial, and noise again after a reset. Exit status 1: an answer differs.
    """
    from experiments.bench.firmware import check as checking
    from experiments.bench.firmware import clips, settings
    from experiments.bench.report.terminal import error_console, out_console, progress

    wanted = settings.firmware(assignments or ())
    tools = _tools(which)
    if trial and not quiet:
        error_console.print("rendering a trial of speed", markup=False)
    sequences = checking.sequences(wanted.shape, clips.of_trial(wanted.shape) if trial else None)
    with progress("check", len(sequences), quiet, "clips") as advance:
        result = checking.check(wanted, tools, sequences, advance)
    if result.difference is not None:
        out_console.print(f"not equal: {result.difference.words()}", markup=False, soft_wrap=True)
        return EXIT_FAILED
    if not quiet:
        for name, frames in result.clips.items():
            out_console.print(f"{frames:>6} frames  {name}", markup=False)
        if result.large:
            out_console.print(
                "note: this program is too large for the chip; QEMU's board has more memory", markup=False
            )
        spiking = f"{result.spiking:,} of them with spikes"
        out_console.print(
            f"equal: {result.frames:,} frames, {spiking}; every HS, VS and spike is the host's", markup=False
        )
        versions = f"{tools.compiler.version}; {tools.qemu.version}"
        out_console.print(versions, markup=False, soft_wrap=True, style="dim")
    return 0


@app.command(short_help="Run an experiment whose observer has the emulated chip.")
def loop(
    experiment: Annotated[str, typer.Argument(help="A robot experiment that colias list shows, or a .py file.")],
    repeats: Repeats = None,
    seed: Seed = 0,
    out: Annotated[
        Path | None, typer.Option(help="New folder for the results; otherwise runs/firmware-NAME-TIME.")
    ] = None,
    assignments: Sets = None,
    recordings: Annotated[bool, typer.Option(help="Write a Rerun recording of each trial.")] = False,
    workers: Workers = None,
    quiet: Quiet = False,
) -> int:
    """Run trials in which the network is the chip's program in QEMU, frame by frame, beside the host's form.

    The tables are those of colias run, with the models dsnn-onboard and dsnn-firmware. --set takes the
    parameters of the experiment too. Exit status 1: a trial failed, or an answer of the chip differs from the host's.
    """
    from experiments.bench import registry
    from experiments.bench.api import perform
    from experiments.bench.cli import robot_table as table
    from experiments.bench.firmware import loop as looping
    from experiments.bench.report.terminal import out_console
    from experiments.bench.run.errors import UsageError
    from experiments.bench.sources.experiment import Experiment
    from experiments.bench.trials import Report

    declared = registry.find(experiment)
    if not isinstance(declared, Experiment):
        raise UsageError(f"{experiment}: shows clips; legal is an experiment with a robot, such as speed")
    folder = run_folder(out, f"firmware-{declared.name}")
    means = resources(workers, None, quiet, False)
    report = perform(declared, folder, means, recordings=recordings, models=looping.models(), only=True,
                     settings=looping.assignments(assignments or ()), repeats=repeats, seed=seed)  # fmt: skip
    if not quiet and isinstance(report, Report):
        table.show(report, recordings)
    if report.failures:
        return EXIT_FAILED
    comparison = looping.compare(folder)
    if comparison.difference:
        out_console.print(f"not equal: {comparison.difference}", markup=False, soft_wrap=True)
        return EXIT_FAILED
    if not quiet:
        frames = f"{comparison.frames:,} frames of {comparison.trials} trials"
        message = f"equal: {frames}; every HS, VS and spike of the chip is the host's"
        out_console.print(message, markup=False, soft_wrap=True)
    return 0


@app.command(short_help="Write a folder that builds the network for the robot.")
def export(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="A new or an empty folder.")],
    assignments: Sets = None,
    which: Which = None,
    quiet: Quiet = False,
) -> int:
    """Write C sources, the header of the parameters, a linker script, an example main.c, a Makefile and one page.

    There is a program that measures itself on a board too; colias firmware decode reads what it sends.

    The page has the measured budget; where the compiler or QEMU is missing, it says which package to install.
    """
    from experiments.bench.firmware import export as exporting
    from experiments.bench.firmware import settings
    from experiments.bench.firmware.budget import measure_all
    from experiments.bench.report.terminal import error_console, show_places
    from experiments.bench.run.errors import UsageError

    wanted = settings.firmware(assignments or ())
    exporting.check_folder(folder)
    if not quiet:
        _notes([wanted])
    try:
        tools = _tools(which)
    except UsageError as error:
        if which is not None:
            raise
        exporting.export(wanted, folder, assignments or (), str(error))
        if not quiet:
            error_console.print(f"note: the budget was not measured: {error}", markup=False, soft_wrap=True)
    else:
        if not quiet:
            error_console.print("building it, and counting its instructions in QEMU", markup=False)
        (measured,) = measure_all([({}, wanted)], tools, 1, lambda: None)
        exporting.export(wanted, folder, assignments or (), measured)
    if not quiet:
        show_places({"export": folder, "page": folder / "README.md"})
    return 0


@app.command(short_help="Make a log of what the self-measuring program has sent.")
def decode(
    serial: Annotated[Path, typer.Argument(metavar="FILE", help="What the board's serial line sent, as it came.")],
    out: Annotated[
        Path | None, typer.Option(help="New folder for the results; otherwise runs/firmware-serial-TIME.")
    ] = None,
    quiet: Quiet = False,
) -> int:
    """Decode the serial line of the program that colias firmware export writes beside the network.

    Writes log.csv, which colias import reads, and cycles.csv: the cycles of each frame, blank where the board
    has no counter. A damaged line is skipped. Exit status 1: lines are damaged, or frames are missing.
    """
    from experiments.bench.firmware import serial as line
    from experiments.bench.firmware.export import check_folder
    from experiments.bench.report.terminal import count, error_console, out_console, show_places
    from experiments.bench.run.errors import UsageError

    folder = results_folder(out, "firmware-serial")
    check_folder(folder)
    capture = line.decode(serial.read_bytes())
    if not capture.frames.height:
        raise UsageError(f"{serial}: no frame is whole")
    if capture.damaged or capture.missing:
        lost = f"{count(capture.damaged, 'damaged line')} skipped; {count(capture.missing, 'frame')} missing"
        error_console.print(f"{serial}: {lost}", markup=False, soft_wrap=True)
    line.write(capture, folder)
    if not quiet:
        for text in line.summary(capture):
            out_console.print(text, markup=False, soft_wrap=True)
        show_places({"log": folder / line.LOG, "cycles": folder / line.CYCLES})
    return EXIT_FAILED if capture.damaged or capture.missing else 0


@app.command(short_help="Write a run with the robot as the log that a robot would have sent.")
def log(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run with the robot.")],
    out: Annotated[Path, typer.Option(metavar="FOLDER", help="A new folder.")],
) -> int:
    """Write log.csv, which colias import reads, and the frames of the recordings as pictures."""
    from experiments.bench.firmware.export import check_folder
    from experiments.bench.report.terminal import show_places
    from experiments.bench.result import load
    from experiments.bench.robot_side import import_log

    check_folder(out)
    command = import_log.write(load(run), out)
    show_places({"log": out / import_log.LOG, "import by": command})
    return 0


@app.command(short_help="List the parameters that --set reaches here.")
def parameters() -> None:
    """List every parameter of dsnn-onboard and of the chip: key, default, legal range, meaning."""
    from experiments.bench.cli.listing import show_parameters
    from experiments.bench.firmware import settings

    show_parameters(settings.parameters())
    typer.echo(f"note: {settings.longest_delay()}")


def _notes(programs: Iterable[Firmware]) -> None:
    """Print what the programs' formats cannot follow, each line once."""
    from experiments.bench.firmware.settings import dead_zone_notice
    from experiments.bench.report.terminal import error_console

    for line in dict.fromkeys(filter(None, (dead_zone_notice(program.network) for program in programs))):
        error_console.print(f"note: {line}", markup=False, soft_wrap=True)


def _tools(which: str | None) -> Tools:
    """Compiler and emulator; `UsageError` where one is missing."""
    from experiments.bench.firmware.budget import Tools
    from experiments.bench.firmware.toolchain import compiler, qemu

    return Tools(compiler(which), qemu())
