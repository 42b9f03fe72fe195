"""Write a folder that builds the network for the robot: C sources, parameters, linker script, Makefile, one page."""

import shlex
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType

from dsnn.native.binding import ONBOARD
from experiments.base.templates import render
from experiments.robot import firmware
from experiments.robot.logs import FRAMES
from experiments.store.recordings import write_pictures

ADDRESSES = {"FLASH": 0x0800_0000, "MAIN": 0x2000_0000, "CORE": 0x1000_0000}
"""Addresses of the STM32F427's memories (its reference manual, memory map)."""
SHOWN = ("noise", "pixel flicker", "grating")
"""The clips that the self-measuring program shows: those with the frames of the most instructions."""
RENDERED = ("Makefile", "README.md", "experiment.py", "measure_frames.h", "measure_frames.c")
"""Files of the folder that have a template each."""


def export(program: firmware.Program, folder: Path, values: Mapping[str, str] = MappingProxyType({})) -> None:
    """Write the folder.

    Parameters
    ----------
    program
        The network's parameters, and the chip.
    folder
        A new or an empty one.
    values
        What ``--set`` was typed by, for the page: key -> text.

    Raises
    ------
    UsageError
        The parameters have no fixed-point form. Nothing was written.
    """
    network, chip = program
    shown = {name: clip for name, clip in firmware.clips(chip.shape, firmware.COUNTED).items() if name in SHOWN}
    sizes = {"FLASH": chip.flash, "MAIN": chip.ram_main, "CORE": chip.ram_core}
    typed = [f" --set {shlex.quote(f'{key}={text}')}" for key, text in values.items()]
    words = {
        "chip": chip, "config": firmware.CONFIG, "table_place": firmware.TABLE_PLACE, "model": firmware.MODEL,
        "version": version("colias-sim"), "shown": shown, "frames": firmware.COUNTED, "fps": network.fps,
        "options": "".join(typed),
        "of_model": "".join(option for option in typed if firmware.MODEL in option),
    }  # fmt: skip
    written = {
        firmware.CONFIG: firmware.config(program),
        "memory.ld": firmware.memory_script(chip, {name: (ADDRESSES[name], size) for name, size in sizes.items()}),
        "memory-qemu.ld": firmware.memory_script(chip, firmware.QEMU_MEMORY),
        **{name: render(f"robot/templates/{name}.j2", **words) + "\n" for name in RENDERED},
    }
    sources = {str(path.relative_to(firmware.CHIP_SIDE)): path for path in firmware.CHIP_SIDE.rglob("*.*")}
    sources["main.c"] = sources.pop("robot_main.c")
    sources |= {name: firmware.NATIVE / name for name in ONBOARD}
    (folder / "include").mkdir(parents=True, exist_ok=True)
    for name, source in sources.items():
        (folder / name).write_bytes(source.read_bytes())
    for name, text in written.items():
        (folder / name).write_text(text, encoding="utf-8")
    for index, frames in enumerate(shown.values()):
        write_pictures(folder / FRAMES / f"trial-{index:04d}", frames, ".pgm")
