"""The command ``colias camera``. Heavy imports happen when it runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def camera(
    folder: Annotated[
        Path, typer.Argument(help="It has folders of pictures (.pgm, .png): still*, flat*, edge*, loop*.")
    ],
    fps: Annotated[float, typer.Option(min=1.0, max=1000.0, help="Frames per second of the folders edge*.")] = 30.0,
    gain: Annotated[
        float, typer.Option(min=0.1, max=16.0, help="The camera's gain; of the OV7670 on Colias 1.5.")
    ] = 1.0,
) -> int:
    """Measure a camera from frames that it took, and print the settings that make the simulated eye like it.

    The functions are those by which the tests measure the simulated eye (colias_sim.calibrate).
    """
    from rich.table import Table

    from experiments.bench.engine.terminal import error_console, out_console, show_table
    from experiments.bench.measured.camera import measure

    measurements = measure(folder, fps, gain)
    table = Table(title=f"camera of {folder}", title_justify="left", box=None, header_style="bold", pad_edge=False)
    table.add_column("measured", no_wrap=True)
    table.add_column("value")
    for measurement in measurements:
        table.add_row(measurement.what, measurement.value)
    show_table(table)
    for note in (measurement.note for measurement in measurements if measurement.note):
        error_console.print(f"note: {note}", soft_wrap=True, markup=False)
    settings = [text for measurement in measurements for text in measurement.settings]
    if gain != 1.0 and settings:
        settings.insert(0, f"camera.gain={gain:g}")
    for text in settings:
        out_console.print(f"--set {text}", soft_wrap=True, markup=False)
    return 0
