"""The playground, a page that opens from disk: the network as WebAssembly, and a script with the frames of each trial.

Its HTML, style and JavaScript are in ``tools/playground/``. What depends on the code comes from here as data: the C
compiled by Zig, the frames of runs that are made here, the ranges of parameters, the tables that need Python's
exponential, and the pairs of speeds and the bound that C15 is judged by.
"""

from __future__ import annotations

import base64
import dataclasses
import json
import re
import shlex
import subprocess
import sys
import tempfile
import zlib
from collections.abc import Iterable, Mapping, Sequence
from math import ceil, floor, log10
from pathlib import Path
from typing import Any, get_args

import jinja2
import numpy as np
import numpy.typing as npt

import experiments
from dsnn import DSNNParams, field_docs
from dsnn.filters import gaussian_kernel, residue
from dsnn.native import binding
from experiments.base import palette
from experiments.declare.claim import texts
from experiments.declare.outcome import MARGIN
from experiments.paper.claims.robot import PAIRS
from experiments.store.recordings import pictures

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "tools" / "playground"
PAGE = "play.html"
MODULES = ("main", "network", "trials", "settings", "judging", "drawing", "footage")
EXPORTS = ("dsnn_size", "dsnn_make", "dsnn_step_u8", "dsnn_maps", "malloc", "free")
"""Functions of the network, and of the C library, that the page calls."""
LEVERS = ("w_i", "n_con", "d", "t_sp", "k_sp", "tau_s", "fdsr", "dog", "on", "off")
BOTH = "the nearest and the farthest pair"
PARTS = ("the nearest pair", "the farthest pair")
"""What the two entries of ``tau_s`` belong to, in the words of its description."""
STEPS = 20
"""Least number of steps that a slider of a float has."""
FOOTAGE_SHAPE = 72, 99
FIRST = "speed-6"
LONGEST_FOOTAGE = 300
SCRIPT = 'document.head.append(Object.assign(document.createElement("data"), {{id: "frames-{}", innerText: "{}"}}));\n'
"""What puts the packed frames of a trial into the page."""


CROSSINGS, DEPTH, OTHERS = "Crossings, 8 cm away", "Approach and recession, 6 cm/s", "Harder to see"
RUNS: Mapping[str, tuple[str, Mapping[int, tuple[str, str, str, str]]]] = {
    "speed": ("colias run speed --repeats 1", {
        index: (f"speed-{speed}", CROSSINGS, f"To the right, {speed} cm/s",
                f"A black Colias crosses from left to right, 8 cm away, at {speed} cm/s.")
        for index, speed in enumerate((2, 4, 6, 10))
    }),
    "general": ("colias run general --repeats 1", {
        3: ("leftward-6", CROSSINGS, "To the left, 6 cm/s", "A black Colias crosses from right to left at 6 cm/s."),
        0: ("approach-0", DEPTH, "Approach straight ahead",
            "It comes from 20 to 5 cm along the optical axis: both sides move outward, and cancel in HS."),
        1: ("recession-0", DEPTH, "Recession straight ahead", "It leaves from 5 to 20 cm along the optical axis."),
    }),
    "approach": ("colias run angular-approach --repeats 1 --set experiment.angles_deg=-30", {
        0: ("approach-30", DEPTH, "Approach at -30\N{DEGREE SIGN}",
            "It comes along a line 30\N{DEGREE SIGN} to the robot's left: its image moves to the right."),
    }),
    "recession": ("colias run angular-recession --repeats 1 --set experiment.angles_deg=-30", {
        0: ("recession-30", DEPTH, "Recession at -30\N{DEGREE SIGN}",
            "It leaves along the same line: its image moves to the left."),
    }),
    "eye": ("colias run speed --repeats 1 --set experiment.speeds_cm_s=10 --set camera.preset=ov7670", {
        0: ("ov7670-10", OTHERS, "To the right, 10 cm/s, by the robot's eye",
            "The model of the robot's own camera, ov7670: automatic exposure takes the bright arena to a middle grey, "
            "rows are read one after the other, and steps in grey are half as large."),
    }),
    "clutter": ("colias run tools/playground/clutter.py --repeats 1", {
        0: ("clutter", OTHERS, "Clip before clutter",
            "A synthetic clip: a dark object crosses at 60 px/s before a natural image that shifts left at 8 px/s."),
    }),
}  # fmt: skip
"""Folder of a run -> the command that makes it; index of a trial -> its name in links, group, title, and a note.

Each has few trials, which seed and index determine: ``colias run speed`` with ten repeats begins with the same.
"""


def write(folder: Path) -> None:
    """Make the runs, and the page `PAGE` with its scripts in ``folder``; the tables stay beside it for the tests."""
    trials, site = [], folder / "site"
    (site / "play").mkdir(parents=True)
    for name, (command, captions) in RUNS.items():
        run = experiments.run(**arguments(command), out=folder / "runs" / name, workers=0, quiet=True)
        for trial, film in _recorded(run, command, captions):
            trials.append(trial)
            (site / "play" / f"{trial['id']}.js").write_text(SCRIPT.format(trial["id"], _base64(packed(film))))
        for recording in run.recordings:
            recording.unlink()
    groups = list(dict.fromkeys(trial["group"] for trial in trials))
    data = {
        "trials": sorted(trials, key=lambda trial: groups.index(trial["group"])),
        "first": FIRST,
        "footage": _footage(),
        "levers": levers(),
        "claim": {"id": "C15", "says": texts()["C15"]["says"], "pairs": PAIRS, "margin": MARGIN["spikes"]},
        "tables": tables(),
    }
    (site / PAGE).write_text(page(data, compiled()), encoding="utf-8")


def arguments(command: str) -> dict[str, Any]:
    """Return the arguments of `experiments.run` that do what a command of the page does."""
    words = shlex.split(command)
    named = list(zip(words[3::2], words[4::2], strict=True))
    settings = dict(value.split("=", 1) for option, value in named if option == "--set")
    (repeats,) = (int(value) for option, value in named if option == "--repeats")
    name = str(ROOT / words[2]) if words[2].endswith(".py") else words[2]
    return {"experiment": name, "repeats": repeats, "settings": settings}


def _recorded(
    run: experiments.Run, command: str, captions: Mapping[int, tuple[str, str, str, str]]
) -> Iterable[tuple[dict[str, Any], npt.NDArray[np.uint8]]]:
    """Yield what the page tells of each trial, and its frames, (T, R, C)."""
    rows = {row["trial"]: row for row in run.trials.to_dicts()}
    (model,) = run.description.get("settings", run.description)["models"]
    for index, (name, group, title, note) in captions.items():
        film = camera_frames(run.recordings[index])
        yield {
            "id": name, "group": group, "title": title, "note": note, "count": film.shape[0], "rows": film.shape[1],
            "columns": film.shape[2], "params": model["network"], "spikes": rows[index]["spikes"],
            "command": command, "speed": rows[index]["speed_cm_s"] if run.folder.name == "speed" else None,
        }, film  # fmt: skip


def camera_frames(recording: Path) -> npt.NDArray[np.uint8]:
    """Read the frames of the first eye of a recording, (T, R, C); trials and clips have them without loss."""
    return next(iter(pictures(recording).values()))


def packed(film: npt.NDArray[np.uint8]) -> bytes:
    """Pack frames, (T, R, C): the differences from frame to frame, modulo 256, as zlib has them."""
    return zlib.compress(np.diff(film, axis=0, prepend=np.zeros_like(film[:1])).tobytes(), 9)


def _footage() -> dict[str, Any]:
    rows, columns = FOOTAGE_SHAPE
    return {
        "id": "footage", "group": "", "title": "Your own", "note": "", "count": 0, "rows": rows, "columns": columns,
        "params": dataclasses.asdict(DSNNParams.offline()), "spikes": 0, "command": "", "speed": None,
    }  # fmt: skip


def levers() -> list[dict[str, Any]]:
    """List the parameters that the page moves: over the paper's range, or over the legal one where it has no range."""
    listed = []
    for name in LEVERS:
        field = vars(DSNNParams)["__pydantic_fields__"][name]
        description = field_docs.meaning(DSNNParams, name)
        given = re.search(r" \(paper: ([^)]*)\)", description)
        paper = given[1] if given else ""
        meaning = (description.replace(given[0], "") if given else description).replace("; false ", "; switching off ")
        parts = PARTS if get_args(field.annotation) else ("",)
        extra = field.json_schema_extra or {}
        for index, part in enumerate(parts):
            is_switch = field.annotation is bool
            low, high = (0.0, 1.0) if is_switch else _range(paper, field.metadata)
            listed.append({
                "key": f"{name}.{index}" if part else name, "name": name, "part": index if part else None,
                "kind": "switch" if is_switch else "number", "low": low, "high": high,
                "step": 1 if field.annotation is int else slider_step(low, high), "paper": paper,
                "unit": "ms" if part else extra.get("unit", "") if isinstance(extra, dict) else "",
                "meaning": meaning.replace(BOTH, part) if part else meaning,
            })  # fmt: skip
    return listed


def _range(paper: str, metadata: Sequence[Any]) -> tuple[float, float]:
    """Return the ends of a slider: those that the paper gives as ``4..8``, or else the legal ones."""
    low, two, high = paper.partition("..")
    if two:
        return float(low), float(high)
    (least,) = (float(c.ge) for c in metadata if getattr(c, "ge", None) is not None)
    (most,) = (float(c.le) for c in metadata if getattr(c, "le", None) is not None)
    return least, most


def slider_step(low: float, high: float) -> float:
    """Return a step of 1, 2 or 5 times a power of ten that divides the range into `STEPS` or somewhat more."""
    most = (high - low) / STEPS * (1 + 1e-9)
    power = 10.0 ** floor(log10(most))
    step = max(times * power for times in (1, 2, 5) if times * power <= most)
    return round(step, max(0, ceil(-log10(step))))


def tables() -> dict[str, Any]:
    """Return the tables of the network that need Python's exponential, for all that the levers can be set to."""
    widest = max(int(lever["high"]) for lever in levers() if lever["name"] == "d")
    widths = sorted({width for d in range(1, widest + 1) for width in (d, 2 * d)})
    return {
        "residues": [residue(DSNNParams().u, i) for i in range(1, 7)],
        "kernels": {width: gaussian_kernel(width)[4 * width :, 0].tolist() for width in widths},
    }


def compiled() -> bytes:
    """Compile the network to WebAssembly by Zig's C compiler, with the options that keep its bits."""
    here = Path(binding.__file__).parent
    sources = [str(here / name) for name in ("dsnn.c", "lgmd1.c", "passes.c", "exponential.c")]
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder, "dsnn.wasm")
        command = [
            sys.executable, "-m", "ziglang", "cc", "-target", "wasm32-wasi", "-mexec-model=reactor", "-std=c99", "-O3",
            "-msimd128", "-ffp-contract=off", "-fno-fast-math", "-s", *sources, "-o", str(out),
            *(f"-Wl,--export={name}" for name in EXPORTS),
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"the network does not compile to WebAssembly: {done.stderr.strip()}")
        return out.read_bytes()


def page(data: Mapping[str, Any], wasm: bytes) -> str:
    """Put the page together: modules refer to each other by names that its import map gives their sources."""
    modules = {name: (SOURCES / f"{name}.js").read_text(encoding="utf-8") for name in MODULES}
    named = {name: f"{source}//# sourceURL={name}.js\n".encode() for name, source in modules.items()}
    imports = {f"#{name}": f"data:text/javascript;base64,{_base64(source)}" for name, source in named.items()}
    rows, columns = FOOTAGE_SHAPE
    template = jinja2.Template((SOURCES / "page.html").read_text(encoding="utf-8"), undefined=jinja2.StrictUndefined)
    text: str = template.render(
        colours=palette.css(),
        style=(SOURCES / "style.css").read_text(encoding="utf-8"),
        data=json.dumps(data).replace("<", "\\u003c"),
        wasm=_base64(wasm),
        modules=json.dumps({"imports": imports}),
        rows=rows,
        columns=columns,
        longest=LONGEST_FOOTAGE,
    )
    return text


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode("ascii")
