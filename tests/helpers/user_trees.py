"""Models and experiments of one's own, in folders of their own, and what a run notes of their files."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import experiments
from experiments import Run

MODEL = """
import sys
from dataclasses import dataclass

import dsnn
{imports}


@dataclass(frozen=True)
class Parameters:
    t_sp: float = 0.9


class Constant:
    def __init__(self, shape, parameters):
        pass

    def reset(self):
        pass

    def step(self, frame):
        {step}
        return dsnn.Response(hs={value}, vs=0.0)


MODEL = dsnn.ModelEntry(name="{name}", summary="a constant", build=Constant, robot=Parameters())
"""


EXPERIMENT = """
from experiments import Clip, ClipClaim, OfflineExperiment, Outcome
{imports}

SMALL = {{"motion": "rightward", "rows": 24, "columns": 32, "width": 6.0, "height": 8.0, "speed": 90.0}}


def judge(clips, threshold):
    {judge}


EXPERIMENT = OfflineExperiment(
    "mine", "one clip", [Clip({clip}, "plain", SMALL)], models=({models}),
    claims=(ClipClaim(id="mine", says="as I say", judge=judge, models={{"{judged}"}}),), repeats={repeats},
)
"""


def model(file: Path, value: object = 0.5, imports: str = "", step: str = "pass", name: str = "") -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(MODEL.format(value=value, imports=imports, step=step, name=name or file.parent.name))
    return file


def experiment(
    file: Path, judge: str = "return Outcome('holds', 'as it is')", clip: str = "'light'", imports: str = "",
    models: str = "'dsnn',", judged: str = "dsnn", repeats: int = 1,
) -> Path:  # fmt: skip
    told = {"judge": judge, "clip": clip, "imports": imports, "models": models, "judged": judged, "repeats": repeats}
    file.write_text(EXPERIMENT.format(**told))
    return file


def run(file: Path, out: Path | None, **more: Any) -> Run:
    return experiments.run(file, out=out, quiet=True, recordings=False, **{"workers": 0, **more})


def peaks(finished_run: Run) -> dict[str, float]:
    return {row["model"]: row["peak_hs"] for row in finished_run.trials.to_dicts()}


def hashes(finished_run: Run) -> dict[str, str]:
    return json.loads((finished_run.folder / "run.json").read_text())["files"]


def sha(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()
