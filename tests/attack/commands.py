"""Bad models through the commands that show them frames: what each leaves is held against what it would be without."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.csv
import pyarrow.parquet as pq

from experiments.bench.reproduction.plan import ENOUGH
from tests.attack.models import LOOMING_TWIN, TWIN
from tests.attack.processes import Ended, colias, python
from tests.helpers.footage import write

Rows = list[dict[str, Any]]
Tables = dict[str, Rows]
"""Model -> its rows in order, its own name and what is measured with a clock left out."""

CLOCKS = ("wall_s", "us_", "rank", "code")
"""What columns begin with that tell of a clock, of the models beside, or of the files that computed."""

EXPERIMENT = """
from experiments.bench.robot.experiment import Experiment
from experiments.bench.robot.designs import Translation

EXPERIMENT = Experiment(
    name="tiny", summary="short crossings", varies="speed_cm_s", repeats={repeats},
    design=Translation(speeds_cm_s={speeds}, distances_cm=(5,)),
)
"""
CLIPS = """
from experiments.bench.clips.experiment import Clip, OfflineExperiment

SMALL = (("motion", "rightward"), ("rows", 48), ("columns", 64), ("width", 12.0), ("height", 20.0), ("speed", 90.0))

EXPERIMENT = OfflineExperiment(
    name="clips", summary="a light clip and a dark one", models=("emd",),
    clips=tuple(Clip(name, "plain", (*SMALL, ("background_grey", ground), ("grey", 128.0)))
                for name, ground in (("light", 220.0), ("dark", 30.0))),
)
"""


@dataclass(frozen=True, slots=True)
class Command:
    """A command that shows frames to models: its words without the models, and where its tables are."""

    name: str
    words: tuple[str, ...]
    table: str
    """``runs``: the tables of run folders; otherwise the name of a file with a row per frame, or of points."""
    left: tuple[str, ...]
    """What it leaves in the folder."""
    others: tuple[str, ...] = ("dsnn",)
    """The honest models beside those of the attack."""
    own: tuple[str, ...] = ()
    """Those of them that the command shows anyway."""
    runs: tuple[str, ...] = ()
    """The run folders in what it leaves."""
    more: tuple[str, ...] = ()
    """Tables beside the first, where a model may stand instead of it, or too."""
    last: int = -1
    """The number of the last frame of a trial, where all have as many."""
    timeout_s: float = 150.0
    leaves_programs: bool = False
    """It shows frames in its own process: what a model forks there is out of its hands."""
    script: str = ""
    """What is started instead of the command line."""

    def tables(self, folder: Path) -> Tables:
        """The rows by model, of everything that it left."""
        if self.table == "runs":
            tables: Tables = {}
            for run in self.runs:
                for name in ("trials.parquet", "frames.parquet"):
                    for row in pq.read_table(folder / run / name).to_pylist():
                        tables.setdefault(row.pop("model"), []).append({**_timeless(row), "of": f"{run}/{name}"})
            return tables
        tables = by_model(rows_of(folder / self.table))
        for path in (folder / name for name in self.more):
            for model, rows in by_model(rows_of(path)).items() if path.exists() else ():
                tables.setdefault(model, []).extend(rows)
        return tables


def rows_of(path: Path) -> Rows:
    """The rows of a table, Parquet or CSV."""
    read = pq.read_table if path.suffix == ".parquet" else pyarrow.csv.read_csv
    rows: Rows = read(path).to_pylist()
    return rows


def by_model(rows: Rows) -> Tables:
    """The rows of each model."""
    tables: Tables = {}
    for row in rows:
        tables.setdefault(row.pop("model"), []).append(_timeless(row))
    return tables


def _timeless(row: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in row.items() if not name.startswith(CLOCKS)}


RUN = Command(
    "run", ("run", "tiny.py", "--workers", "1", "--no-recordings", "--out", "out"), "runs", ("out",), runs=("out",)
)
OFFLINE = Command(
    "run-clips", ("run", "clips.py", "--workers", "1", "--no-recordings", "--out", "out"), "runs", ("out",),
    others=("emd", "dsnn"), own=("emd",), runs=("out",),
)  # fmt: skip
INSIDE = Command(
    "run-without-workers", ("run", "clips.py", "--workers", "0", "--no-recordings", "--out", "out"), "runs", ("out",),
    others=("emd", "dsnn"), own=("emd",), runs=("out",), leaves_programs=True,
)  # fmt: skip
WATCH = Command(
    "watch", ("watch", "film.avi", "--no-view", "--table", "seen.parquet", "--record", "seen.rrd"), "seen.parquet",
    ("seen.parquet", "seen.rrd"), leaves_programs=True,
)  # fmt: skip
PLAY = Command(
    "play",
    ("play", "plain", "--set", "plain.rows=48", "--set", "plain.columns=64", "--no-view", "--record", "played.rrd"),
    "played.rrd", ("played.rrd",), leaves_programs=True,
)  # fmt: skip
TUNE = Command(
    "tune", ("tune", "--curve", "size", "--workers", "1", "--out", "out"), "out/tuning.csv", ("out",), runs=("out",)
)
LEADERBOARD = Command(
    "leaderboard", ("leaderboard", "--only", "--repeats", "1", "--workers", "1", "--out", "out"),
    "out/leaderboard.csv", ("out",), timeout_s=400, more=("out/looming.csv",),
    runs=("out/robot", "out/clips-plain", "out/clips-clutter", "out/looming-plain", "out/looming-moving"),
)  # fmt: skip
REPRODUCE = Command(
    "reproduce", ("reproduce", "--quick", "--robot-only", "--workers", "1", "--out", "out"), "runs", ("out",),
    own=("dsnn",), runs=("out/general",), timeout_s=600,
)  # fmt: skip
GENERAL = Command(
    "run-general",
    ("run", "general", "--repeats", f"{ENOUGH}", "--workers", "1", "--no-recordings", "--out", "out/general"),
    "runs", ("out",), runs=("out/general",),
)  # fmt: skip
"""The first experiment of `REPRODUCE`, whose numbers that has too."""
SMALL_REPRODUCE = dataclasses.replace(
    REPRODUCE, name="reproduce-small", script=str(Path(__file__).with_name("small_reproduce.py"))
)
SMALL_GENERAL = dataclasses.replace(
    GENERAL, name="run-general-small", words=("run", "general", "--repeats", "1", *GENERAL.words[4:])
)


@dataclass(slots=True)
class Reference:
    """What a command says of honest models: their rows, and the number of a trial's last frame."""

    tables: Tables
    last: int
    printed: list[str] = field(default_factory=list)


def furnish(folder: Path) -> None:
    """Put what the commands show into a folder: experiments and a film."""
    (folder / "tiny.py").write_text(EXPERIMENT.format(repeats=1, speeds="(25,)"))
    (folder / "clips.py").write_text(CLIPS)
    film(folder / "film.avi", 30)


def film(path: Path, frames: int, dark: bool = False) -> None:
    """A film of 64x48 px: a grey square crosses noise, on a light ground or a dark one."""
    rng = np.random.default_rng(0)
    ground = rng.normal(60 if dark else 190, 12, (48, 64, 1))

    def picture(i: int) -> np.ndarray:
        seen = np.repeat(ground, 3, axis=2)
        left = (2 * i) % 80 - 16
        seen[16:32, max(left, 0) : max(left + 16, 0)] = 125
        return np.clip(seen, 0, 255).astype(np.uint8)

    write(path, (picture(i) for i in range(frames)))


def show(command: Command, folder: Path, models: Sequence[str], last: int = -1) -> Ended:
    """Run the command in ``folder`` on models, the honest ones last, so that mischief to what they see is seen."""
    temporary = folder / "tmp"
    temporary.mkdir()
    named = [*models, *(name for name in command.others if name not in command.own)]
    words = [*command.words, *(word for name in named for word in ("--model", name))]
    environment = {"ATTACK_LAST": str(last), "TMPDIR": str(temporary)}
    if command.script:
        return python(folder, [command.script, *words], environment=environment, timeout_s=command.timeout_s)
    return colias(folder, words, environment=environment, timeout_s=command.timeout_s)


def reference(command: Command, folder: Path) -> Reference:
    """The command on honest models."""
    furnish(folder)
    ended = show(command, folder, [TWIN.write(folder), LOOMING_TWIN.write(folder)])
    assert (ended.status, ended.crashes(), ended.left) == (0, [], ()), ended
    if command is PLAY:
        return Reference({}, 0, potentials(ended.out))
    tables = command.tables(folder)
    rows = tables["twin"]
    numbers = [row["frame"] for row in rows if "frame" in row]
    return Reference(tables, max(numbers, default=-1))


def potentials(printed: str) -> list[str]:
    return [line for line in printed.splitlines() if line.startswith("dsnn ")]
