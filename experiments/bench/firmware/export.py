"""Write a folder that builds the network for the robot: C sources, parameters, linker script, Makefile, one page."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from colias_sim.config import CameraConfig
from dsnn.native.binding import ONBOARD
from experiments.bench.firmware import clips
from experiments.bench.firmware.budget import Budget
from experiments.bench.firmware.build import (
    CHIP_SIDE,
    CONFIG,
    CORE,
    FLASH,
    MAIN,
    NATIVE,
    SECTIONS,
    TABLE_PLACE,
    computed,
    config,
    memory_script,
)
from experiments.bench.firmware.settings import MODEL, STACKED, Firmware, dead_zone_notice, plain_key
from experiments.bench.robot_side.import_log import FRAMES
from experiments.bench.run.errors import UsageError
from experiments.bench.run.recordings import write_pictures
from experiments.bench.run.templates import render

ADDRESSES = {FLASH: 0x0800_0000, MAIN: 0x2000_0000, CORE: 0x1000_0000}
"""Addresses of the STM32F427's memories (its reference manual, memory map)."""
COPIED = (
    "startup.c", "memory.c", "chip.h", "camera.c", "camera.h", "semihost.c", "semihost.h", "counter.c", "counter.h",
    "answers.c", "host_main.c", "states.h", "split.h", "measure_main.c", "record.c", "record.h", "cycles.c", "cycles.h",
    "board.h", "board_qemu.c", "board_stm32.c", SECTIONS,
)  # fmt: skip


def export(wanted: Firmware, folder: Path, assignments: Sequence[str], measured: Budget | str) -> None:
    """Write the folder.

    Parameters
    ----------
    wanted
        Parameters and chip.
    folder
        A new or an empty one.
    assignments
        The ``--set`` texts that led here, for the page.
    measured
        The budget, or why there is none.

    Raises
    ------
    UsageError
        The parameters have no fixed-point form. Nothing was written.
    """
    parameters = config(wanted)
    if isinstance(measured, str):
        placement, over = computed(wanted)
    else:
        placement, over = measured.built.placement, measured.built.over
    chosen_clips = clips.worst(wanted)
    words = {
        **_words(wanted, assignments, measured), "split": placement.split, "over": over, "shown": list(chosen_clips),
        "shown_frames": clips.COUNTED_FRAMES,
    }  # fmt: skip
    sources = {name: CHIP_SIDE / name for name in COPIED}
    sources |= {"main.c": CHIP_SIDE / "robot_main.c", "include/string.h": CHIP_SIDE / "include" / "string.h"}
    sources |= {name: NATIVE / name for name in ONBOARD}
    written = {
        CONFIG: parameters,
        "memory.ld": memory_script(wanted.chip, placement, ADDRESSES),
        "memory-qemu.ld": memory_script(wanted.chip, placement, large=True),
        "Makefile": render("firmware/templates/Makefile.j2", **words) + "\n",
        "README.md": render("firmware/templates/README.md.j2", **words) + "\n",
        "experiment.py": render("firmware/templates/experiment.py.j2", clips=list(chosen_clips)) + "\n",
        "measure_frames.h": frames_header(chosen_clips, wanted),
        "measure_frames.c": frames_source(chosen_clips),
    }
    contents = {name: path.read_bytes() for name, path in sources.items()}
    contents |= {name: text.encode() for name, text in written.items()}
    (folder / "include").mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        (folder / name).write_bytes(content)
    for index, frames in enumerate(chosen_clips.values()):
        write_pictures(folder / FRAMES / f"trial-{index:04d}", frames, ".pgm")


def frames_header(chosen_clips: Mapping[str, clips.Frames], wanted: Firmware) -> str:
    """Return ``measure_frames.h``: which frames the self-measuring program shows."""
    names = "".join(f" * trial {index}: {name}\n" for index, name in enumerate(chosen_clips))
    lines = [
        f"/* Frames that the self-measuring program shows, written by colias-sim:\n{names} */",
        "#ifndef MEASURE_FRAMES_H", "#define MEASURE_FRAMES_H", "", "#include <stdint.h>", "",
        f"#define MEASURE_TRIALS {len(chosen_clips)}u", f"#define MEASURE_FRAMES {clips.COUNTED_FRAMES}u",
        f"#define MEASURE_FRAME_US {round(1e6 / wanted.network.fps)}u", "",
        f"extern const uint8_t measure_luma[MEASURE_TRIALS * MEASURE_FRAMES][{wanted.shape[0] * wanted.shape[1]}];",
        "", "#endif", "",
    ]  # fmt: skip
    return "\n".join(lines)


def frames_source(chosen_clips: Mapping[str, clips.Frames]) -> str:
    """Return ``measure_frames.c``: the frames themselves, a line each."""
    frames = np.concatenate(list(chosen_clips.values())).reshape(len(chosen_clips) * clips.COUNTED_FRAMES, -1)
    rows = ["{" + ",".join(map(str, frame.tolist())) + "}," for frame in frames]
    begin = f"const uint8_t measure_luma[{len(frames)}][{frames.shape[1]}] = {{"
    return "\n".join(['#include "measure_frames.h"', "", begin, *rows, "};", ""])


def check_folder(folder: Path) -> None:
    """Raise `UsageError` where something is in the way of an export."""
    if folder.exists() and not folder.is_dir():
        raise UsageError(f"{folder}: is a file; legal is a new or an empty folder")
    if folder.is_dir() and any(folder.iterdir()):
        raise UsageError(f"{folder}: is not empty; legal is a new or an empty folder")


def _settings(wanted: Firmware, assignments: Sequence[str]) -> str:
    """Return the options by which ``colias import`` sets model and camera as they are here."""
    rows, columns = wanted.shape
    texts = [plain_key(text) for text in assignments]
    options = [text for text in texts if text.startswith(f"{MODEL}.")]
    camera = CameraConfig()
    values = {"width": columns, "height": rows, "fps": wanted.network.fps}
    options += [f"camera.{name}={value:g}" for name, value in values.items() if value != getattr(camera, name)]
    return "".join(f" --set {shlex.quote(option)}" for option in options)


def _words(wanted: Firmware, assignments: Sequence[str], measured: Budget | str) -> dict[str, Any]:
    rows, columns = wanted.shape
    options = "".join(f" --set {text}" for text in assignments)
    words: dict[str, Any] = {
        "chip": wanted.chip, "rows": rows, "columns": columns, "config": CONFIG, "table_place": TABLE_PLACE,
        "model": MODEL, "settings": _settings(wanted, assignments), "version": version("colias-sim"),
        "notice": dead_zone_notice(wanted.network),
        "command": f"Its parameters: the defaults{' but' if options else ''}{options}.", "budget": None,
    }  # fmt: skip
    if isinstance(measured, str):
        return {**words, "missing": measured}
    return {
        **words, "budget": measured,
        "compiler": measured.compiler, "emulator": measured.emulator,
        "purposes": [(name, size, measured.regions[name]) for name, size in measured.purposes.items()],
        "stages": [*measured.stages, measured.whole],
        "verdict": f"On the chip: {measured.verdict}.", "stacked": STACKED,
    }  # fmt: skip
