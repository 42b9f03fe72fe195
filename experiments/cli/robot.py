"""The commands about the robot and this machine: ``colias import``, ``camera``, ``firmware ...`` and ``doctor``.

Heavy imports happen when they run.
"""

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import typer

from experiments.base.console import count, error_console, out_console, show, show_places
from experiments.base.values import key_values
from experiments.cli import options
from experiments.store.asked import Asked

Folder = Annotated[Path, typer.Option("--out", metavar="FOLDER", help="A new or an empty folder.")]

app = typer.Typer(
    help="What the robot's chip would compute: its memory and time, the program checked in QEMU, the source to flash.",
    no_args_is_help=True,
)


def _program(values: Mapping[str, str]) -> Any:
    """Return the program that is asked for, and say on stderr where its codes are too coarse for its longest delay."""
    from dsnn.onboard.dead_zone import SMALL, dead_zone, longest_delay
    from experiments.robot import firmware

    program = firmware.program(values)
    network = program[0]
    falling, rising = dead_zone(network)
    if max(falling, rising) > SMALL:
        delay = f"a delay of {max(network.delays()):g} ms, but for one of up to {longest_delay(network):,.0f} ms"
        lost = f"its signal does not fall from up to {falling:.2g} of its range, nor rise to {rising:.2g} or less"
        error_console.print(f"note: {network.state_bits} bits are too coarse for {delay}: {lost}")
    return program


@app.command(short_help="Measure RAM, flash and instructions on the chip.")
def budget(assignments: options.Assignments = None) -> int:
    """Build the chip's program, measure its memory, and count its instructions in QEMU.

    Bytes are those of the linked program. Instructions are those of the worst frame of clips with noise, flicker and
    motion.

    colias firmware budget --set dsnn-onboard.lamina_bits=16 --set chip.ring_frames=2
    """
    from experiments.robot import firmware

    program = _program(key_values(assignments))
    row = firmware.measure(program)
    used = sum(row[name] for name in firmware.RAM)
    out_console.print(f"{row['memory']}: {used:,} of {program[1].ram_main + program[1].ram_core:,} B", style="b")
    for heading, columns in firmware.groups(row).items():
        out_console.print(f"{heading:<18}{', '.join(f'{name} {row[name]:,}' for name in columns)}")
    least, most = firmware.CYCLES
    out_console.print(f"of the worst frame, {row['clip']}, at {least} to {most} cycles an instruction, assumed")
    return 0


@app.command(short_help="Compare the chip's program in QEMU with the network here, bit for bit.")
def check(assignments: options.Assignments = None) -> int:
    """Run the chip's program in QEMU on over 1,000 frames, and compare every HS, VS and spike with the host's.

    Exit status 1: a response differs.
    """
    from experiments.robot import firmware

    table = firmware.check(_program(key_values(assignments)))
    wrong = firmware.differing(table)
    if wrong.height:
        show(wrong.head(1), "first difference")
    verdict, spikes = "not equal" if wrong.height else "equal", table["hs_spikes"].abs().sum()
    out_console.print(f"{verdict}: {table.height:,} frames, {spikes:,} spikes")
    return options.EXIT_FAILED if wrong.height else 0


@app.command(short_help="Write a folder that builds the network for the robot.")
def export(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="A new or an empty folder.")],
    assignments: options.Assignments = None,
) -> int:
    """Write C sources, the header of the parameters, a linker script, an example main.c, a Makefile and one page.

    There is a program that measures itself on a board too; colias firmware decode reads what it sends.
    """
    from experiments.robot import export as exporting, firmware

    options.check_new(folder)
    values = key_values(assignments)
    program = _program(values)
    exporting.export(program, folder, values)
    if program[1].clock_mhz != firmware.ChipSettings().clock_mhz:
        error_console.print("note: board_stm32.c sets a clock of 180 MHz: set yours at PLACE of the clock in it")
    show_places({"export": folder, "page": folder / "README.md"})
    return 0


@app.command(short_help="Make a log of what the self-measuring program has sent.")
def decode(
    serial: Annotated[Path, typer.Argument(metavar="FILE", help="What the board's serial line sent, as it came.")],
    out: Folder,
) -> int:
    """Decode the serial line of the self-measuring program that colias firmware export writes.

    Writes log.csv, which colias import reads, and cycles.csv: the cycles of each frame, blank where the board
    has no counter. A line that is damaged, or of another firmware, is skipped and counted. Exit status 1: frames are
    missing.
    """
    from experiments.base.files import Files
    from experiments.robot import firmware

    options.check_new(out)
    frames, board, skipped = firmware.decode(serial.read_bytes())
    out.mkdir(parents=True, exist_ok=True)
    Files(out).write_text("log.csv", firmware.log_of(frames, board).write_csv())
    Files(out).write_text("cycles.csv", frames.select("trial", "frame", "cycles").write_csv())
    sent = product(range(board.get("trials", 0)), range(board.get("frames", 0)))
    missing = sorted({*sent} - {*frames.select("trial", "frame").iter_rows()})
    lost = f"{count(skipped, 'damaged or unknown line')}, {count(len(missing), 'missing frame')}"
    out_console.print(f"{frames.height} frames; {lost}")
    if missing:
        out_console.print("run the program once more, append what it sends to this file, and decode it again")
    if (most := frames["cycles"].max()) is not None:  # a board in QEMU counts none
        out_console.print("most cycles:", most)
    show_places({"log": out / "log.csv", "cycles": out / "cycles.csv"})
    return options.EXIT_FAILED if missing or not frames.height else 0


@app.command(short_help="Write a run with the robot as the log that a robot would have sent.")
def log(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run with the robot.")], out: Folder
) -> int:
    """Write log.csv, which colias import reads, and the frames of the recordings as pictures."""
    from experiments.kinds.log import write
    from experiments.kinds.result import load
    from experiments.robot.logs import LOG

    options.check_new(out)
    write(load(run), out)
    show_places({"log": out / LOG})
    return 0


def import_log(
    log: Annotated[Path, typer.Argument(help="The log, a CSV with a row per frame.")],
    frames: Annotated[
        Path | None, typer.Option(metavar="FOLDER", help="The trials' frames: trial-0003/000000.pgm and so on.")
    ] = None,
    experiment: Annotated[str, typer.Option(help="The experiment whose conditions the trials show.")] = "speed",
    ran: Annotated[
        list[str] | None,
        typer.Option(metavar="MODEL", help="What the robot ran; otherwise the log's model, or dsnn. Repeatable."),
    ] = None,
    model: options.Models = None,
    assignments: options.Assignments = None,
    out: options.Out = None,
    quiet: options.Quiet = False,
) -> int:
    """Make a run of what a real Colias has sent, with the tables, figure and verdicts of a simulated one.

    The run is marked as measured. The same judges and bounds apply.

    colias import log.csv --experiment speed --set experiment.speeds_cm_s=20,30
    """
    asked = Asked(
        kind="measured", what=(str(log),), models=tuple(model or ()), values=key_values(assignments),
        options={"experiment": experiment, "frames": None if frames is None else str(frames), "ran": ran},
    )  # fmt: skip
    return options.finish(asked, out, options.pool(0, None, quiet), f"{Path(experiment).stem}-measured")


def camera(
    folder: Annotated[Path, typer.Argument(help="It has folders of pictures (.pgm, .png): still*, edge*, loop*.")],
    fps: Annotated[float, typer.Option(min=1.0, max=1000.0, help="Frames per second of edge*.")] = 30.0,
    gain: Annotated[float, typer.Option(min=0.1, max=16.0, help="The camera's gain; 1.5 on Colias.")] = 1.0,
) -> int:
    """Measure a camera from frames that it took, and print the settings that make the simulated eye like it."""
    from experiments.robot.calibrate import measure

    settings, notes = measure(folder, fps, gain)
    for note in notes:
        error_console.print(f"note: {note}")
    for name, value in settings.items():
        out_console.print(f"--set camera.{name}={value}")
    return 0


def doctor() -> int:
    """Say whether this machine has what the bench needs: Python, packages, what draws, the network, tools, extras.

    A reference frame is drawn and compared with those that are known. If its hash is another, pixels differ a little,
    and so may numbers. On a CPU with other features numbers differ by rounding. What is optional, only some commands
    need. The exit status is 1 if anything is missing.
    """
    from experiments.cli.doctor import examine

    missing = False
    for state, name, message in examine():
        missing |= state == "missing"
        out_console.print(f"{state:<10}{name:<20}{message}")
    return options.EXIT_FAILED if missing else 0
