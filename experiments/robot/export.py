"""Write a folder that builds the network for the robot: C sources, parameters, linker script, Makefile, one page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from types import MappingProxyType

import numpy as np

from dsnn.native.binding import ONBOARD
from experiments.base.templates import render
from experiments.robot import firmware
from experiments.robot.logs import FRAMES
from experiments.store.recordings import write_pictures

ADDRESSES = {"FLASH": 0x0800_0000, "MAIN": 0x2000_0000, "CORE": 0x1000_0000}
"""Addresses of the STM32F427's memories (its reference manual, memory map)."""
SHOWN = ("noise", "pixel flicker", "grating")
"""The clips that the self-measuring program shows: those with the frames of the most instructions."""


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
        "measure_frames.h": _frames_header(program, shown),
        "measure_frames.c": _frames_source(shown),
        **{name: render(f"robot/templates/{name}.j2", **words) + "\n"
           for name in ("Makefile", "README.md", "experiment.py")},
    }  # fmt: skip
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


def _frames_header(program: firmware.Program, shown: dict[str, firmware.Frames]) -> str:
    """Return ``measure_frames.h``: which frames the self-measuring program shows."""
    network, chip = program
    names = "".join(f" * trial {index}: {name}\n" for index, name in enumerate(shown))
    return f"""/* Frames that the self-measuring program shows, written by colias-sim:
{names} */
#ifndef MEASURE_FRAMES_H
#define MEASURE_FRAMES_H
#include <stdint.h>
#define MEASURE_TRIALS {len(shown)}u
#define MEASURE_FRAMES {firmware.COUNTED}u
#define MEASURE_FRAME_US {round(1e6 / network.fps)}u
extern const uint8_t measure_luma[MEASURE_TRIALS * MEASURE_FRAMES][{chip.rows * chip.columns}];
#endif
"""


def _frames_source(shown: dict[str, firmware.Frames]) -> str:
    """Return ``measure_frames.c``: the frames themselves, a line each."""
    frames = np.concatenate(list(shown.values())).reshape(len(shown) * firmware.COUNTED, -1)
    rows = "\n".join("{" + ",".join(map(str, frame.tolist())) + "}," for frame in frames)
    begin = f"const uint8_t measure_luma[{len(frames)}][{frames.shape[1]}] = {{"
    return f'#include "measure_frames.h"\n\n{begin}\n{rows}\n}};\n'
